//! Colour bars.

use units::Unit;

use super::canvas::{Anchor, Canvas, Colour, Fill, Point, Stroke};
use super::colour::{ColourMap, ValueRange};
use super::layout::{KeySide, LABEL_SIZE, TICK_SIZE, fitting_ticks};
use super::scale::{Ticks, UnitScale};
use super::text::Label;

/// Number of slices that show the colour map.
const SLICES: usize = 128;
const THICKNESS: f64 = 14.0;

/// How the values of one field become colours, and how they are called.
#[derive(Clone, Debug)]
pub(super) struct ColourKey {
    pub(super) range: ValueRange,
    pub(super) map: ColourMap,
    /// Symbol and unit.
    pub(super) title: Label,
    /// What is special about the field; empty in general.
    remark: &'static str,
    scale: UnitScale,
    /// Whether some value is not finite.
    has_gaps: bool,
}

impl ColourKey {
    /// The key of a field with the given symbol and unit.
    pub(super) fn new(
        values: impl Iterator<Item = f64> + Clone,
        map: ColourMap,
        symbol: &Label,
        unit: &Unit,
    ) -> Self {
        let has_gaps = values.clone().any(|value| !value.is_finite());
        Self::with_range(ValueRange::of(values), has_gaps, map, symbol, unit)
    }

    /// The key of a field whose colours cover a given range.
    pub(super) fn with_range(
        range: ValueRange,
        has_gaps: bool,
        map: ColourMap,
        symbol: &Label,
        unit: &Unit,
    ) -> Self {
        let magnitude = match range {
            ValueRange::Nothing => 0.0,
            ValueRange::Constant(value) => value.abs(),
            ValueRange::Interval(low, high) => low.abs().max(high.abs()),
        };
        let scale = UnitScale::new(magnitude, unit);
        let remark = match range {
            ValueRange::Nothing => "(no value)",
            ValueRange::Constant(0.0) => "(zero everywhere)",
            ValueRange::Constant(_) => "(constant)",
            ValueRange::Interval(..) => "",
        };
        Self {
            range,
            map,
            title: scale.title(symbol),
            remark,
            scale,
            has_gaps: has_gaps && range != ValueRange::Nothing,
        }
    }

    /// How to fill the pane of a value.
    pub(super) fn fill(&self, value: f64) -> Fill {
        self.range.fill(self.map, value)
    }

    /// Draws the bar, below or at the right of a plot, from `corner` over `length` pixels.
    pub(super) fn draw(&self, canvas: &mut Canvas, side: KeySide, corner: Point, length: f64) {
        match side {
            KeySide::Below => self.draw_horizontal(canvas, corner, length),
            KeySide::Right => self.draw_vertical(canvas, corner, length),
        }
    }

    fn draw_horizontal(&self, canvas: &mut Canvas, [left, top]: Point, length: f64) {
        for slice in 0..self.slices() {
            let from = length * slice as f64 / SLICES as f64;
            let fill = self.slice_fill(slice);
            canvas.rectangle([left + from, top], [length - from, THICKNESS], fill, None);
        }
        let frame = Stroke::solid(Colour::BLACK, 0.8);
        canvas.rectangle([left, top], [length, THICKNESS], Fill::Empty, Some(frame));
        let ticks = self.ticks(|low, high| fitting_ticks(low, high, length));
        for (value, fraction) in self.positions(&ticks) {
            let x = left + fraction * length;
            let bottom = top + THICKNESS;
            canvas.line([x, bottom], [x, bottom + 4.0], frame);
            let label = Label::plain(ticks.text(value));
            canvas.text([x, bottom + 16.5], &label, TICK_SIZE, Anchor::Middle);
        }
        let baseline = top + THICKNESS + 35.0;
        let centre = [left + length / 2.0, baseline];
        let title = match self.remark {
            "" => self.title.clone(),
            remark => self.title.clone().upright(format!(" {remark}")),
        };
        canvas.text(centre, &title, LABEL_SIZE, Anchor::Middle);
        if self.has_gaps {
            draw_gap_swatch(canvas, [left + length - 78.0, baseline - 11.0]);
        }
    }

    fn draw_vertical(&self, canvas: &mut Canvas, [left, top]: Point, length: f64) {
        canvas.text([left, top + 10.0], &self.title, LABEL_SIZE, Anchor::Start);
        let top = top + 22.0;
        let footer = self.has_gaps || !self.remark.is_empty();
        let length = length - 22.0 - if footer { 30.0 } else { 0.0 };
        for slice in 0..self.slices() {
            let height = length * (1.0 - slice as f64 / SLICES as f64);
            let fill = self.slice_fill(slice);
            canvas.rectangle([left, top], [THICKNESS, height], fill, None);
        }
        let frame = Stroke::solid(Colour::BLACK, 0.8);
        canvas.rectangle([left, top], [THICKNESS, length], Fill::Empty, Some(frame));
        let ticks = self.ticks(|low, high| Ticks::new(low, high, 7));
        for (value, fraction) in self.positions(&ticks) {
            let y = top + (1.0 - fraction) * length;
            let right = left + THICKNESS;
            canvas.line([right, y], [right + 4.0, y], frame);
            let label = Label::plain(ticks.text(value));
            let position = [right + 8.0, y + 0.36 * TICK_SIZE];
            canvas.text(position, &label, TICK_SIZE, Anchor::Start);
        }
        if self.has_gaps {
            draw_gap_swatch(canvas, [left, top + length + 16.0]);
        } else if footer {
            let position = [left, top + length + 26.0];
            canvas.text(
                position,
                &Label::plain(self.remark),
                TICK_SIZE,
                Anchor::Start,
            );
        }
    }

    fn slices(&self) -> usize {
        match self.range {
            ValueRange::Interval(..) => SLICES,
            ValueRange::Nothing | ValueRange::Constant(_) => 1,
        }
    }

    fn slice_fill(&self, slice: usize) -> Fill {
        match self.range {
            ValueRange::Nothing => Fill::NoValue,
            ValueRange::Constant(value) => self.fill(value),
            ValueRange::Interval(..) => {
                Fill::Plain(self.map.at((slice as f64 + 0.5) / SLICES as f64))
            }
        }
    }

    /// Ticks in scaled values.
    fn ticks(&self, choose: impl Fn(f64, f64) -> Ticks) -> Ticks {
        match self.range {
            ValueRange::Nothing => Ticks::none(),
            ValueRange::Constant(value) => Ticks::single(self.scale.scaled(value)),
            ValueRange::Interval(low, high) => {
                choose(self.scale.scaled(low), self.scale.scaled(high))
            }
        }
    }

    /// Every tick value with its position on the bar from 0 to 1.
    fn positions(&self, ticks: &Ticks) -> Vec<(f64, f64)> {
        let ValueRange::Interval(low, high) = self.range else {
            let middle = |&value: &f64| (value, 0.5);
            return ticks.values.iter().map(middle).collect();
        };
        let (low, high) = (self.scale.scaled(low), self.scale.scaled(high));
        let position = |&value: &f64| (value, ((value - low) / (high - low)).clamp(0.0, 1.0));
        ticks.values.iter().map(position).collect()
    }
}

/// The explanation of hatched panes.
fn draw_gap_swatch(canvas: &mut Canvas, corner: Point) {
    let frame = Stroke::solid(Colour::GREY, 0.6);
    canvas.rectangle(corner, [THICKNESS, 12.0], Fill::NoValue, Some(frame));
    let position = [corner[0] + 20.0, corner[1] + 10.0];
    canvas.text(
        position,
        &Label::plain("no value"),
        TICK_SIZE,
        Anchor::Start,
    );
}

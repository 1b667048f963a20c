//! Axes over slips and coefficients.

use units::{Dimension, Unit, Units};

use super::canvas::{Anchor, Canvas, Colour, Fill, Point, Stroke};
use super::colour::ValueRange;
use super::law::SlipRange;
use super::layout::{KEY_WIDTH, LABEL_SIZE, PANEL_WIDTH, TICK_SIZE, TITLE_HEIGHT, fitting_ticks};
use super::line_chart::LogTicks;
use super::scale::{Ticks, UnitScale};
use super::text::Label;

const TICK_LENGTH: f64 = 5.0;
/// Left of a plot with short tick labels, and room for the name of the vertical axis.
const LEFT: f64 = 84.0;
const NAME_WIDTH: f64 = 46.0;
const RIGHT_MARGIN: f64 = 28.0;
const PLOT_HEIGHT: f64 = 258.0;
/// Most labelled decades of a logarithmic axis.
const MOST_DECADES: usize = 7;

/// One axis with its ticks as fractions of its length.
pub(super) struct SlipAxis {
    range: SlipRange,
    label: Label,
    scale: UnitScale,
}

impl SlipAxis {
    /// An axis over slips in `units`, named by a symbol.
    pub(super) fn new(range: SlipRange, symbol: &Label, units: Units) -> Self {
        let unit = units.of(Dimension::LENGTH);
        let scale = match range {
            SlipRange::Linear(high) => UnitScale::new(high, &unit),
            SlipRange::Logarithmic(..) => UnitScale::new(1.0, &unit),
        };
        Self {
            range,
            label: scale.title(symbol),
            scale,
        }
    }

    /// Where a slip lies on the axis, from 0 to 1.
    fn fraction(&self, slip: f64) -> f64 {
        let fraction = match self.range {
            SlipRange::Linear(high) => slip / high,
            SlipRange::Logarithmic(low, high) => (slip / low).ln() / (high / low).ln(),
        };
        fraction.clamp(0.0, 1.0)
    }

    fn ticks(&self, pixels: f64) -> Vec<(f64, Label)> {
        match self.range {
            SlipRange::Linear(high) => {
                let scaled = self.scale.scaled(high);
                let ticks = fitting_ticks(0.0, scaled, pixels);
                let label = |&value: &f64| (value / scaled, Label::plain(ticks.text(value)));
                ticks.values.iter().map(label).collect()
            }
            SlipRange::Logarithmic(low, high) => {
                let major = LogTicks::new(low, high, MOST_DECADES).major;
                let label = |value: f64| (self.fraction(value), LogTicks::label(value));
                major.into_iter().map(label).collect()
            }
        }
    }
}

/// What the vertical axis of a frame shows.
enum Vertical {
    Slip(SlipAxis),
    /// Coefficients between two values.
    Coefficient {
        low: f64,
        high: f64,
        symbol: Label,
    },
}

/// The frame of a drawing over slips.
pub(super) struct LawFrame {
    pub(super) corner: Point,
    pub(super) size: Point,
    horizontal: SlipAxis,
    vertical: Vertical,
}

impl LawFrame {
    /// A chart of coefficients; the range of values gets a margin, and a constant a little room.
    pub(super) fn chart(horizontal: SlipAxis, values: ValueRange, symbol: &Label) -> Self {
        let (low, high) = match values {
            ValueRange::Interval(low, high) => (low, high),
            ValueRange::Constant(value) => (0.5 * value, 1.5 * value),
            ValueRange::Nothing => (0.0, 1.0),
        };
        let margin = 0.06 * (high - low);
        let vertical = Vertical::Coefficient {
            low: (low - margin).max(0.0),
            high: high + margin,
            symbol: symbol.clone(),
        };
        Self::new(horizontal, vertical, PLOT_HEIGHT, RIGHT_MARGIN)
    }

    /// A map over both slips, with room for a colour bar at its right.
    pub(super) fn map(horizontal: SlipAxis, vertical: SlipAxis) -> Self {
        let right = RIGHT_MARGIN + KEY_WIDTH;
        Self::new(
            horizontal,
            Vertical::Slip(vertical),
            PLOT_HEIGHT + 40.0,
            right,
        )
    }

    /// A frame of a height and a margin at its right; the one at its left fits its tick labels.
    fn new(horizontal: SlipAxis, vertical: Vertical, height: f64, right: f64) -> Self {
        let mut frame = Self {
            corner: [LEFT, TITLE_HEIGHT],
            size: [0.0, height],
            horizontal,
            vertical,
        };
        let left = LEFT.max(NAME_WIDTH + widest(&frame.vertical_ticks().1));
        frame.corner[0] = left;
        frame.size[0] = PANEL_WIDTH - left - right;
        frame
    }

    /// Pixel of a slip and a coefficient.
    pub(super) fn point(&self, [slip, value]: [f64; 2]) -> Point {
        let right = self.horizontal.fraction(slip);
        let up = match &self.vertical {
            Vertical::Slip(axis) => axis.fraction(value),
            Vertical::Coefficient { low, high, .. } => (value - low) / (high - low),
        };
        [
            self.corner[0] + right * self.size[0],
            self.corner[1] + (1.0 - up) * self.size[1],
        ]
    }

    fn vertical_ticks(&self) -> (Label, Vec<(f64, Label)>) {
        match &self.vertical {
            Vertical::Slip(axis) => (axis.label.clone(), axis.ticks(self.size[1])),
            Vertical::Coefficient { low, high, symbol } => {
                let scale = UnitScale::new(*high, &Unit::none());
                let [low, high] = [low, high].map(|&value| scale.scaled(value));
                let ticks = Ticks::new(low, high, 7);
                let label = |&value: &f64| {
                    let fraction = (value - low) / (high - low);
                    (fraction, Label::plain(ticks.text(value)))
                };
                (
                    scale.title(symbol),
                    ticks.values.iter().map(label).collect(),
                )
            }
        }
    }

    /// Draws frame, ticks and labels.
    pub(super) fn draw(&self, canvas: &mut Canvas) {
        let [left, top] = self.corner;
        let [width, height] = self.size;
        let bottom = top + height;
        let frame = Stroke::solid(Colour::BLACK, 0.8);
        canvas.rectangle(self.corner, self.size, Fill::Empty, Some(frame));
        for (fraction, label) in self.horizontal.ticks(width) {
            let x = left + fraction * width;
            canvas.line([x, bottom], [x, bottom + TICK_LENGTH], frame);
            canvas.text([x, bottom + 21.0], &label, TICK_SIZE, Anchor::Middle);
        }
        let (name, ticks) = self.vertical_ticks();
        for (fraction, label) in &ticks {
            let y = bottom - fraction * height;
            canvas.line([left, y], [left - TICK_LENGTH, y], frame);
            let position = [left - TICK_LENGTH - 4.0, y + 0.36 * TICK_SIZE];
            canvas.text(position, label, TICK_SIZE, Anchor::End);
        }
        let position = [left + width / 2.0, bottom + 42.0];
        canvas.text(position, &self.horizontal.label, LABEL_SIZE, Anchor::Middle);
        let position = [
            left - TICK_LENGTH - 16.0 - widest(&ticks),
            top + height / 2.0,
        ];
        canvas.vertical_text(position, &name, LABEL_SIZE);
    }

    /// Draws the strokes of two curves with their names above the plot, at its right.
    pub(super) fn draw_legend(&self, canvas: &mut Canvas, names: &[Label], strokes: &[Stroke]) {
        let baseline = self.corner[1] - 12.0;
        let right = self.corner[0] + self.size[0];
        for (index, (name, stroke)) in names.iter().zip(strokes).enumerate() {
            let x = right - 70.0 * (names.len() - index) as f64;
            let y = baseline - 4.0;
            canvas.line([x, y], [x + 34.0, y], *stroke);
            canvas.text([x + 40.0, baseline], name, LABEL_SIZE, Anchor::Start);
        }
    }
}

/// Width of the widest tick label.
fn widest(ticks: &[(f64, Label)]) -> f64 {
    let widths = ticks.iter().map(|(_, label)| label.width(TICK_SIZE));
    widths.fold(0.0, f64::max)
}

//! From values to colours and hatches, and the bars that explain them.

use units::Unit;

use super::{
    canvas::{Anchor, Canvas, Colour, Fill, Stroke},
    layout::{LABEL_SIZE, PANEL_WIDTH, RIGHT_MARGIN, TICK_SIZE, fitting_ticks},
    scale::{Ticks, UnitScale, bounds},
    text::Label,
};

/// Perceptually uniform colour maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColourMap {
    Viridis,
    Plasma,
    Cividis,
}

impl ColourMap {
    /// The colour at `fraction` of the map.
    pub(super) fn at(self, fraction: f64) -> Colour {
        let gradient = match self {
            Self::Viridis => colorous::VIRIDIS,
            Self::Plasma => colorous::PLASMA,
            Self::Cividis => colorous::CIVIDIS,
        };
        let colour = gradient.eval_continuous(fraction.clamp(0.0, 1.0));
        Colour(colour.r, colour.g, colour.b)
    }
}

/// The interval of values that a colour map covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ValueRange {
    /// No finite value at all.
    Nothing,
    /// All finite values agree up to rounding.
    Constant(f64),
    /// From the smallest to the largest value.
    Interval(f64, f64),
}

impl ValueRange {
    /// The range of the finite ones among `values`.
    pub(super) fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let mut finite = values.filter(|value| value.is_finite()).peekable();
        if finite.peek().is_none() {
            return Self::Nothing;
        }
        let (low, high) = bounds(finite);
        // Differences below 10⁻⁹ of the values are rounding, not a field; halves avoid overflow.
        if high / 2.0 - low / 2.0 <= 0.5e-9 * low.abs().max(high.abs()) {
            return Self::Constant(low);
        }
        // The span of values near the largest number must stay finite.
        Self::Interval(low.max(-8e307), high.min(8e307))
    }

    /// Two ranges as their union, unless it would hide the variation of one of them.
    pub(super) fn shared(own: [Self; 2]) -> [Self; 2] {
        let [Self::Interval(a, b), Self::Interval(c, d)] = own else {
            return own;
        };
        let (low, high) = (a.min(c), b.max(d));
        if (b - a).min(d - c) >= 0.2 * (high - low) {
            [Self::Interval(low, high); 2]
        } else {
            own
        }
    }

    /// Position of a value in the range, from 0 to 1; one half in a constant field, `None` when it
    /// is not finite.
    pub(super) fn fraction(self, value: f64) -> Option<f64> {
        if !value.is_finite() {
            return None;
        }
        match self {
            Self::Interval(low, high) => Some(((value - low) / (high - low)).clamp(0.0, 1.0)),
            Self::Nothing | Self::Constant(_) => Some(0.5),
        }
    }

    /// How to fill the pane of a value.
    pub(super) fn fill(self, map: ColourMap, value: f64) -> Fill {
        self.fraction(value)
            .map_or(Fill::NoValue, |fraction| Fill::Plain(map.at(fraction)))
    }
}

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

    /// Draws the bar from a point to the margin at the right, with its title below it.
    pub(super) fn draw(&self, canvas: &mut Canvas, [left, top]: [f64; 2]) {
        let length = PANEL_WIDTH - RIGHT_MARGIN - left;
        let slices = match self.range {
            ValueRange::Interval(..) => SLICES,
            ValueRange::Nothing | ValueRange::Constant(_) => 1,
        };
        // Each colour over the rest of those before it.
        for slice in 0..slices {
            let share = slice as f64 / SLICES as f64;
            let fill = match self.range {
                ValueRange::Nothing => Fill::NoValue,
                ValueRange::Constant(value) => self.fill(value),
                ValueRange::Interval(..) => Fill::Plain(self.map.at(share + 0.5 / SLICES as f64)),
            };
            let corner = [left + length * share, top];
            canvas.rectangle(corner, [length * (1.0 - share), THICKNESS], fill, None);
        }
        let frame = Stroke::solid(Colour::BLACK, 0.8);
        canvas.rectangle([left, top], [length, THICKNESS], Fill::Empty, Some(frame));
        for (fraction, label) in self.ticks(length) {
            let (x, bottom) = (left + fraction * length, top + THICKNESS);
            canvas.line([x, bottom], [x, bottom + 4.0], frame);
            canvas.text([x, bottom + 16.5], &label, TICK_SIZE, Anchor::Middle);
        }
        let baseline = top + THICKNESS + 35.0;
        let title = match self.remark {
            "" => self.title.clone(),
            remark => self.title.clone().upright(format!(" {remark}")),
        };
        let centre = [left + length / 2.0, baseline];
        canvas.text(centre, &title, LABEL_SIZE, Anchor::Middle);
        if self.has_gaps {
            draw_gap_swatch(canvas, [left + length - 78.0, baseline - 11.0]);
        }
    }

    /// Positions on the bar from 0 to 1, with their labels.
    fn ticks(&self, length: f64) -> Vec<(f64, Label)> {
        let (low, high) = match self.range {
            ValueRange::Nothing => return Vec::new(),
            ValueRange::Constant(value) => {
                let value = self.scale.scaled(value);
                return vec![(0.5, Label::plain(Ticks::single(value).text(value)))];
            }
            ValueRange::Interval(low, high) => (self.scale.scaled(low), self.scale.scaled(high)),
        };
        let ticks = fitting_ticks(low, high, length);
        let tick = |&value: &f64| {
            let fraction = ((value - low) / (high - low)).clamp(0.0, 1.0);
            (fraction, Label::plain(ticks.text(value)))
        };
        ticks.values.iter().map(tick).collect()
    }
}

/// The explanation of hatched panes.
fn draw_gap_swatch(canvas: &mut Canvas, corner: [f64; 2]) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_ignore_what_is_not_finite() {
        let range = ValueRange::of([f64::NAN, 1.0, f64::INFINITY, 3.0].into_iter());
        assert_eq!(range, ValueRange::Interval(1.0, 3.0));
        assert_eq!(range.fill(ColourMap::Viridis, f64::NAN), Fill::NoValue);
    }

    #[test]
    fn rounding_noise_is_a_constant() {
        let range = ValueRange::of([0.3, 0.3 + 1e-15].into_iter());
        assert_eq!(range, ValueRange::Constant(0.3));
        assert_eq!(range.fraction(0.3), Some(0.5));
    }

    #[test]
    fn a_shared_range_never_hides_a_field() {
        let narrow = ValueRange::Interval(0.2, 0.3);
        let apart = [narrow, ValueRange::Interval(1.0, 1e6)];
        assert_eq!(ValueRange::shared(apart), apart);
        let close = [narrow, ValueRange::Interval(0.25, 0.35)];
        assert_eq!(
            ValueRange::shared(close),
            [ValueRange::Interval(0.2, 0.35); 2]
        );
    }
}

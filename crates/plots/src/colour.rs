//! From values to colours and hatches.

use units::Unit;

use super::{
    canvas::{Canvas, Colour, Fill, Point},
    colour_bar::ColourKey,
    layout::{KeySide, PictureLayout},
    line_chart::{draw_axes, draw_panes},
    panes::PaneShape,
    svg::bounds,
    text::Label,
};

/// Perceptually uniform colour maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColourMap {
    Viridis,
    /// From bright to dark, for values that are zero where nothing happens and negative elsewhere.
    ReversedViridis,
    Plasma,
    Cividis,
}

impl ColourMap {
    /// The colour at `fraction` of the map.
    pub(super) fn at(self, fraction: f64) -> Colour {
        let fraction = match self {
            Self::ReversedViridis => 1.0 - fraction,
            Self::Viridis | Self::Plasma | Self::Cividis => fraction,
        };
        let gradient = match self {
            Self::Viridis | Self::ReversedViridis => colorous::VIRIDIS,
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

    /// The union of two ranges, unless it would hide the variation of one of them.
    pub(super) fn shared(self, other: Self) -> Option<Self> {
        let (Self::Interval(a, b), Self::Interval(c, d)) = (self, other) else {
            return None;
        };
        let (low, high) = (a.min(c), b.max(d));
        ((b - a).min(d - c) >= 0.2 * (high - low)).then_some(Self::Interval(low, high))
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

/// A square tile with lines from lower left to upper right, continued by its neighbours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hatch {
    /// Identifier within an SVG document.
    pub(super) name: &'static str,
    /// Side of the tile in pixels.
    pub(super) period: f64,
    pub(super) background: Colour,
    pub(super) lines: Colour,
    /// Width of the lines in pixels.
    pub(super) width: f64,
}

impl Hatch {
    /// A value that is not a number.
    pub(super) const NO_VALUE: Self = Self {
        name: "no-value",
        period: 6.0,
        background: Colour(0xd8, 0xd8, 0xd8),
        lines: Colour(0x8a, 0x8a, 0x8a),
        width: 1.0,
    };

    /// A pane that is out of contact.
    pub(super) const OPEN: Self = Self {
        name: "open",
        period: 5.0,
        background: Colour::WHITE,
        lines: Colour(0xc4, 0xc4, 0xc4),
        width: 0.7,
    };

    /// The diagonal of the tile, and the corners of those of its neighbours.
    pub(super) fn segments(&self) -> [[Point; 2]; 3] {
        let side = self.period;
        [
            [[-1.0, 1.0], [1.0, -1.0]],
            [[0.0, side], [side, 0.0]],
            [[side - 1.0, side + 1.0], [side + 1.0, side - 1.0]],
        ]
    }
}

/// A map of one value per pane in `unit`, with axes and colour bar.
pub(super) fn map_panel(
    layout: &PictureLayout,
    shapes: &[PaneShape],
    title: &Label,
    key: &ColourKey,
    unit: &Unit,
    value: impl Fn(usize) -> f64,
) -> Canvas {
    let mut canvas = layout.panel(title);
    let fill = |pane: usize| key.fill(value(pane));
    let hover = |pane: usize| format!("pane {pane}: {:.4e}{}", value(pane), unit.beside());
    draw_panes(&mut canvas, layout, shapes, Colour::WHITE, fill, hover);
    draw_axes(&mut canvas, layout);
    let [left, top] = layout.corner;
    let [width, height] = layout.size;
    match layout.key {
        KeySide::Below => {
            let corner = [left, top + height + 50.0];
            key.draw(&mut canvas, layout.key, corner, width);
        }
        KeySide::Right => {
            let corner = [left + width + 28.0, top];
            key.draw(&mut canvas, layout.key, corner, height);
        }
    }
    canvas
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
        assert!(narrow.shared(ValueRange::Interval(1.0, 1e6)).is_none());
        let other = ValueRange::Interval(0.25, 0.35);
        assert_eq!(narrow.shared(other), Some(ValueRange::Interval(0.2, 0.35)));
    }
}

//! Axes with ticks, in proportion or by powers of ten, and the frames around plots.

use units::Unit;

use super::{
    canvas::{Anchor, Canvas, Colour, Fill, Point, Stroke},
    layout::{LABEL_SIZE, TICK_SIZE, fitting_ticks},
    scale::{Ticks, UnitScale},
    text::Label,
};

/// How values are placed along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisScale {
    /// In proportion.
    Linear,
    /// By their logarithm; values that are not positive are left out.
    Logarithmic,
}

/// An axis with its title and its ticks, whose places are fractions of its length.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    scale: AxisScale,
    interval: [f64; 2],
    title: Label,
    ticks: Vec<(f64, Label)>,
    /// Places of ticks without a label.
    minor: Vec<f64>,
}

impl Axis {
    /// An axis in proportion with given ticks, in the unit of these.
    pub(super) fn linear(title: Label, ticks: &Ticks, interval: [f64; 2]) -> Self {
        let axis = Self::bare(AxisScale::Linear, interval, title);
        let tick = |&value: &f64| (axis.fraction(value), Label::plain(ticks.text(value)));
        Self {
            ticks: ticks.values.iter().map(tick).collect(),
            ..axis
        }
    }

    /// An axis over values of a quantity with round ticks, as many as fit its length in pixels, with at most `decades` powers of ten.
    pub(super) fn new(
        scale: AxisScale,
        interval: [f64; 2],
        (symbol, unit): (&Label, &Unit),
        pixels: f64,
        decades: usize,
    ) -> Self {
        let [low, high] = interval;
        match scale {
            AxisScale::Linear => {
                let unit = UnitScale::new(high.abs().max(low.abs()), unit);
                let scaled = interval.map(|value| unit.scaled(value));
                let ticks = fitting_ticks(scaled[0], scaled[1], pixels);
                Self {
                    interval,
                    ..Self::linear(unit.title(symbol), &ticks, scaled)
                }
            }
            AxisScale::Logarithmic => {
                let (ticks, minor) = log_ticks(low, high, decades);
                let axis = Self::bare(scale, interval, UnitScale::new(1.0, unit).title(symbol));
                let minor = minor
                    .into_iter()
                    .map(|value| axis.fraction(value))
                    .collect();
                Self { minor, ..axis }.with_ticks(&ticks)
            }
        }
    }

    /// The axis with these values labelled.
    pub(super) fn with_ticks(self, values: &[f64]) -> Self {
        let tick = |&value: &f64| (self.fraction(value), log_label(value));
        Self {
            ticks: values.iter().map(tick).collect(),
            ..self
        }
    }

    fn bare(scale: AxisScale, interval: [f64; 2], title: Label) -> Self {
        Self {
            scale,
            interval,
            title,
            ticks: Vec::new(),
            minor: Vec::new(),
        }
    }

    /// Where a value lies, from 0 at the beginning to 1 at the end.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        let [low, high] = self.interval;
        match self.scale {
            AxisScale::Linear => (value - low) / (high - low),
            AxisScale::Logarithmic => (value / low).ln() / (high / low).ln(),
        }
    }

    /// Width of the widest tick label.
    pub(super) fn widest(&self) -> f64 {
        let widths = self.ticks.iter().map(|(_, label)| label.width(TICK_SIZE));
        widths.fold(0.0, f64::max)
    }
}

/// A plot with its axes.
#[derive(Clone, Debug)]
pub(super) struct PlotFrame {
    /// Upper left corner.
    pub(super) corner: Point,
    pub(super) size: Point,
    /// The horizontal and the vertical axis.
    pub(super) axes: [Axis; 2],
    /// Whether lines cross it at all ticks, in place of ticks outside.
    pub(super) has_grid: bool,
}

impl PlotFrame {
    /// Pixel of a pair of values.
    pub(super) fn pixel(&self, [x, y]: [f64; 2]) -> Point {
        let [right, up] = [self.axes[0].fraction(x), self.axes[1].fraction(y)];
        [
            self.corner[0] + right * self.size[0],
            self.corner[1] + (1.0 - up) * self.size[1],
        ]
    }

    /// Where the name of the vertical axis is, `gap` pixels beside its ticks.
    pub(super) fn name_x(&self, gap: f64) -> f64 {
        self.corner[0] - TICK_LENGTH - gap - self.axes[1].widest()
    }

    /// Draws the frame with its ticks; `below` it are the baselines of the horizontal axis's tick labels and name, and the name of the
    /// vertical axis is at `name_x`.
    pub(super) fn draw(&self, canvas: &mut Canvas, below: [f64; 2], name_x: f64) {
        let ([left, top], [width, height]) = (self.corner, self.size);
        let bottom = top + height;
        let frame = Stroke::solid(Colour::BLACK, 0.8);
        let (labelled, [right, upper], gap) = if self.has_grid {
            let line = Stroke::solid(Colour(0xdd, 0xdd, 0xdd), 0.7);
            (line, [left + width, top], 8.0)
        } else {
            (frame, [left - TICK_LENGTH, bottom + TICK_LENGTH], 9.0)
        };
        let faint = Stroke::solid(Colour(0xf0, 0xf0, 0xf0), 0.6);
        let [horizontal, vertical] = &self.axes;
        let x = |place: f64| left + place * width;
        let y = |place: f64| bottom - place * height;
        if self.has_grid {
            for place in &horizontal.minor {
                canvas.line([x(*place), bottom], [x(*place), upper], faint);
            }
            for place in &vertical.minor {
                canvas.line([left, y(*place)], [right, y(*place)], faint);
            }
        }
        for (place, label) in &horizontal.ticks {
            let x = x(*place);
            canvas.line([x, bottom], [x, upper], labelled);
            canvas.text([x, bottom + below[0]], label, TICK_SIZE, Anchor::Middle);
        }
        for (place, label) in &vertical.ticks {
            let y = y(*place);
            canvas.line([left, y], [right, y], labelled);
            let position = [left - gap, y + 0.36 * TICK_SIZE];
            canvas.text(position, label, TICK_SIZE, Anchor::End);
        }
        canvas.rectangle(self.corner, self.size, Fill::Empty, Some(frame));
        let position = [left + width / 2.0, bottom + below[1]];
        canvas.text(position, &horizontal.title, LABEL_SIZE, Anchor::Middle);
        canvas.vertical_text([name_x, top + height / 2.0], &vertical.title, LABEL_SIZE);
    }
}

/// Pixels of a tick outside a frame.
const TICK_LENGTH: f64 = 5.0;

/// Values with a label, at most `most` powers of ten at equal distances, and values without one; where fewer than three powers
/// fit, also their doubles and fivefolds have labels.
fn log_ticks(low: f64, high: f64, most: usize) -> (Vec<f64>, Vec<f64>) {
    let (first, last) = (decade(low), decade(high) + 1);
    let decades: Vec<f64> = (first..=last).map(|k| 10_f64.powi(k)).collect();
    let inside = |v: &f64| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9);
    let within = |values: Vec<f64>| values.into_iter().filter(inside).collect::<Vec<f64>>();
    let powers = within(decades.clone());
    if powers.len() >= 3 {
        let stride = i32::try_from(powers.len().div_ceil(most.max(2))).unwrap_or(1);
        let is_labelled = |v: &f64| decade(*v).rem_euclid(stride) == 0;
        return powers.into_iter().partition(is_labelled);
    }
    let times = |factors: &[f64]| {
        let products = decades
            .iter()
            .flat_map(|d| factors.iter().map(move |f| f * d));
        within(products.collect())
    };
    let minor = times(&[3.0, 4.0, 6.0, 7.0, 8.0, 9.0]);
    (times(&[1.0, 2.0, 5.0]), minor)
}

/// The printed form of a tick: plain from 10⁻² to 10⁴, else with a power of ten.
fn log_label(value: f64) -> Label {
    if (0.99e-2..1.01e4).contains(&value) {
        let text = format!("{value:.4}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        return Label::plain(text);
    }
    let exponent = decade(value);
    let mantissa = value / 10_f64.powi(exponent);
    let digits = exponent.to_string().replace('-', "−");
    let factor = if (mantissa - 1.0).abs() < 1e-6 {
        Label::plain("10")
    } else {
        Label::plain(format!("{mantissa:.0}·10"))
    };
    factor.superscript(digits)
}

/// ⌊log₁₀ v⌋, a hair of rounding allowed.
fn decade(value: f64) -> i32 {
    (value.log10() + 1e-9).floor() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_decades_are_thinned_and_few_are_divided() {
        let (major, minor) = log_ticks(1e-13, 1.0, 7);
        assert!((3..=7).contains(&major.len()), "{major:?}");
        assert_eq!(major.len() + minor.len(), 14);
        let (major, minor) = log_ticks(3.0, 40.0, 7);
        assert_eq!(major, [5.0, 10.0, 20.0]);
        assert_eq!(minor, [3.0, 4.0, 6.0, 7.0, 8.0, 9.0, 30.0, 40.0]);
    }

    #[test]
    fn labels_are_plain_or_powers_of_ten() {
        assert_eq!(log_label(0.05), Label::plain("0.05"));
        assert_eq!(log_label(1e-6), Label::plain("10").superscript("−6"));
        let label = Label::plain("2·10").superscript("5");
        assert_eq!(log_label(2e5), label);
    }
}

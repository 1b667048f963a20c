//! Nice ticks and SI prefixes.

use units::Unit;

use super::text::Label;

/// Magnitudes below this count as zero: no power of ten that scales them is a normal number.
const SMALLEST_MAGNITUDE: f64 = 1e-299;

/// How the values of one quantity are printed: divided by 10^`exponent`, with this unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct UnitScale {
    exponent: i32,
    /// Bracketed unit, such as `[MPa]`; empty for a number of ordinary size without unit.
    pub(super) unit: Label,
}

impl UnitScale {
    /// The prefix that suits a magnitude, as [`Unit::prefixed`] chooses it; a power of 1000 for numbers, and units without prefixes, below
    /// 10⁻² and from 10⁴ on.
    pub(super) fn new(magnitude: f64, unit: &Unit) -> Self {
        let magnitude = if magnitude <= SMALLEST_MAGNITUDE {
            0.0
        } else {
            magnitude
        };
        let (exponent, word) = unit.prefixed(magnitude);
        let scaled = magnitude / 10f64.powi(exponent);
        if magnitude == 0.0 || (1e-2..1e4).contains(&scaled) {
            let unit = match unit.is_none() {
                true => Label::default(),
                false => Label::plain(format!("[{word}]")),
            };
            return Self { exponent, unit };
        }
        Self::by_power_of_ten(engineering_exponent(magnitude), unit)
    }

    fn by_power_of_ten(exponent: i32, unit: &Unit) -> Self {
        let decades = power_of_ten(exponent);
        Self {
            exponent,
            unit: if unit.is_none() {
                decades.upright("]")
            } else {
                decades.upright(format!(" {}]", unit.word()))
            },
        }
    }

    /// The number to print for `value`.
    pub(super) fn scaled(&self, value: f64) -> f64 {
        value / 10f64.powi(self.exponent)
    }

    /// `value` with its power of ten, without unit.
    pub(super) fn number(&self, value: f64) -> Label {
        let scaled = self.scaled(value);
        let label = Label::plain(Ticks::single(scaled).text(scaled));
        if self.exponent == 0 {
            return label;
        }
        let digits = self.exponent.to_string().replace('-', "−");
        label.upright("·10").superscript(digits)
    }

    /// `symbol` followed by the unit.
    pub(super) fn title(&self, symbol: &Label) -> Label {
        if self.unit == Label::default() {
            symbol.clone()
        } else {
            symbol.clone().upright(" ").then(&self.unit)
        }
    }
}

fn power_of_ten(exponent: i32) -> Label {
    let digits = exponent.to_string().replace('-', "−");
    Label::plain("[10").superscript(digits)
}

fn engineering_exponent(magnitude: f64) -> i32 {
    if !magnitude.is_finite() || magnitude <= SMALLEST_MAGNITUDE {
        return 0;
    }
    // The shift by one part in 10⁹ keeps 0.9999999999e3 together with 1e3.
    let decades = (magnitude * (1.0 + 1e-9)).min(f64::MAX).log10() / 3.0;
    3 * decades.floor() as i32
}

/// Equidistant round numbers inside an interval and how to print them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ticks {
    /// Increasing values.
    pub(super) values: Vec<f64>,
    decimals: usize,
}

impl Ticks {
    /// At most `most` multiples of 1, 2, 2.5 or 5 times a power of ten in [`low`, `high`], but one
    /// at least.
    pub(super) fn new(low: f64, high: f64, most: usize) -> Self {
        let span = high - low;
        if !span.is_finite() || span <= 0.0 {
            return Self::single(low);
        }
        let most = most.max(2);
        let coarsest = 10f64.powf(span.log10().ceil());
        let mut found = Vec::new();
        let mut decimals = 0;
        'search: for decade in 0..4 {
            for mantissa in [1.0, 0.5, 0.25, 0.2] {
                let step = mantissa * coarsest / 10f64.powi(decade);
                let values = multiples(low, high, step);
                if values.len() > most {
                    break 'search;
                }
                found = values;
                decimals = decimals_of(step);
            }
        }
        if found.is_empty() {
            return Self::single(low);
        }
        Self {
            values: found,
            decimals,
        }
    }

    /// The one tick of a constant field.
    pub(super) fn single(value: f64) -> Self {
        let decimals = (0..6)
            .find(|&d| {
                let factor = 10f64.powi(d);
                ((value * factor).round() / factor - value).abs() <= 1e-4 * value.abs()
            })
            .unwrap_or(6);
        Self {
            values: vec![value],
            decimals: decimals as usize,
        }
    }

    /// The printed form of a tick value.
    pub(super) fn text(&self, value: f64) -> String {
        let text = format!("{value:.*}", self.decimals);
        match text.strip_prefix('-') {
            Some(digits) if digits.chars().all(|c| c == '0' || c == '.') => digits.to_owned(),
            Some(digits) => format!("−{digits}"),
            None => text,
        }
    }

    /// Width of the widest printed tick at font size `size`.
    pub(super) fn widest(&self, size: f64) -> f64 {
        let width = |&value: &f64| Label::plain(self.text(value)).width(size);
        self.values.iter().map(width).fold(0.0, f64::max)
    }
}

/// The multiples of `step` in the interval, a hair of rounding allowed at its ends; none when they
/// are too many.
fn multiples(low: f64, high: f64, step: f64) -> Vec<f64> {
    let first = (low / step - 1e-6).ceil();
    let last = (high / step + 1e-6).floor();
    if last - first > 1000.0 {
        return vec![0.0; 1001];
    }
    let mut values = Vec::new();
    let mut index = first;
    while index <= last {
        values.push(index * step);
        if index + 1.0 == index {
            break;
        }
        index += 1.0;
    }
    values
}

/// The decimals needed to print multiples of `step` exactly.
fn decimals_of(step: f64) -> usize {
    (0..12)
        .find(|&d| {
            let scaled = step * 10f64.powi(d);
            (scaled - scaled.round()).abs() < 1e-6 * scaled
        })
        .map_or(12, |d| d as usize)
}

/// The round number 1, 2 or 5 times a power of ten that is closest to `value` from below.
pub(super) fn round_down(value: f64) -> f64 {
    let decade = 10f64.powf(value.log10().floor());
    let mantissa = value / decade;
    let rounded = [5.0, 2.0, 1.0]
        .into_iter()
        .find(|&candidate| candidate <= mantissa * (1.0 + 1e-9));
    rounded.unwrap_or(1.0) * decade
}

/// A factor ≥ 1 for print: one decimal below 100, digits grouped from 10 000, a power of ten from
/// 10⁹.
pub(super) fn factor_label(factor: f64) -> Label {
    if factor >= 1e9 {
        let decade = factor.log10().floor();
        return Label::plain(format!("{:.0}·10", factor / 10f64.powf(decade)))
            .superscript(format!("{decade:.0}"));
    }
    if factor < 100.0 {
        let text = format!("{factor:.1}");
        return Label::plain(text.strip_suffix(".0").unwrap_or(&text));
    }
    let digits = format!("{factor:.0}");
    if digits.len() <= 4 {
        return Label::plain(digits);
    }
    let mut grouped = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push('\u{a0}');
        }
        grouped.push(digit);
    }
    Label::plain(grouped)
}

/// Smallest and largest value; (0, 0) when there is none.
pub(super) fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use units::{Dimension, Units};

    #[test]
    fn megapascals_are_chosen_for_a_contact_stress() {
        let scale = UnitScale::new(3.75e7, &Units::SI.of(Dimension::STRESS));
        assert_eq!(scale.unit, Label::plain("[MPa]"));
        // One rounding of a division.
        assert!((scale.scaled(3.75e7) - 37.5).abs() < 1e-12);
    }

    #[test]
    fn ordinary_coefficients_stay_unscaled_and_huge_ones_do_not() {
        assert_eq!(UnitScale::new(0.3, &Unit::none()).unit, Label::default());
        let huge = Label::plain("[10").superscript("6").upright("]");
        assert_eq!(UnitScale::new(1e6, &Unit::none()).unit, huge);
    }

    #[test]
    fn units_of_a_users_choice_stay_as_long_as_numbers_are_ordinary() {
        let title = |text: &str, magnitude: f64, dimension: Dimension| {
            let units: Units = text.parse().unwrap();
            let scale = UnitScale::new(magnitude, &units.of(dimension));
            (scale.unit.clone(), scale.scaled(magnitude))
        };
        let millimetres = |magnitude| title("mm, N", magnitude, Dimension::LENGTH);
        assert_eq!(millimetres(3000.0), (Label::plain("[mm]"), 3000.0));
        assert_eq!(millimetres(0.357), (Label::plain("[mm]"), 0.357));
        assert_eq!(millimetres(2.5e5), (Label::plain("[m]"), 250.0));
        let (unit, small) = millimetres(2.5e-5);
        assert_eq!(unit, Label::plain("[nm]"));
        // One rounding of a division.
        assert!((small - 25.0).abs() < 1e-13);
        let stress = |text, magnitude| title(text, magnitude, Dimension::STRESS);
        assert_eq!(stress("mm, N", 37.5), (Label::plain("[MPa]"), 37.5));
        assert_eq!(stress("m, kN", 37500.0), (Label::plain("[MPa]"), 37.5));
        assert_eq!(stress("in, lbf", 5439.0), (Label::plain("[psi]"), 5439.0));
        let thousands = Label::plain("[10").superscript("3").upright(" psi]");
        assert_eq!(stress("in, lbf", 54390.0), (thousands, 54.39));
    }

    #[test]
    fn ticks_are_round_and_printed_exactly() {
        let ticks = Ticks::new(0.2, 0.3, 6);
        let texts: Vec<String> = ticks.values.iter().map(|&v| ticks.text(v)).collect();
        assert_eq!(texts, ["0.20", "0.22", "0.24", "0.26", "0.28", "0.30"]);
        let ticks = Ticks::new(-37.0, 0.4, 6);
        let texts: Vec<String> = ticks.values.iter().map(|&v| ticks.text(v)).collect();
        assert_eq!(texts, ["−30", "−20", "−10", "0"]);
    }

    #[test]
    fn factors_are_rounded_down_to_1_2_5() {
        assert_eq!(round_down(999.0), 500.0);
        assert_eq!(round_down(1000.0), 1000.0);
        assert_eq!(factor_label(20000.0), Label::plain("20\u{a0}000"));
        assert_eq!(factor_label(2.5), Label::plain("2.5"));
    }

    proptest! {
        #[test]
        fn ticks_lie_in_the_interval(low in -1e6..1e6f64, decade in -3..6i32, most in 2..9usize) {
            let span = 10f64.powi(decade);
            let ticks = Ticks::new(low, low + span, most);
            prop_assert!(!ticks.values.is_empty() && ticks.values.len() <= most);
            // The hair of one millionth of a step that `multiples` allows.
            let slack = 1e-5 * span;
            prop_assert!(ticks.values.iter().all(|&v| v >= low - slack && v <= low + span + slack));
        }
    }
}

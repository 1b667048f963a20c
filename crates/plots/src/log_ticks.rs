//! Ticks of a logarithmic axis.

use super::text::Label;

/// The positions of labelled and of unlabelled ticks.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LogTicks {
    /// Values with a label.
    pub(super) major: Vec<f64>,
    /// Values without one.
    pub(super) minor: Vec<f64>,
}

impl LogTicks {
    /// At most `most` powers of ten at equal distances; where fewer than three fit, also their
    /// doubles and fivefolds.
    pub(super) fn new(low: f64, high: f64, most: usize) -> Self {
        let (first, last) = (decade(low), decade(high) + 1);
        let decades: Vec<f64> = (first..=last).map(|k| 10_f64.powi(k)).collect();
        let inside = |v: &f64| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9);
        let within = |values: Vec<f64>| values.into_iter().filter(inside).collect::<Vec<f64>>();
        let powers = within(decades.clone());
        if powers.len() >= 3 {
            let stride = i32::try_from(powers.len().div_ceil(most.max(2))).unwrap_or(1);
            let is_labelled = |v: &f64| decade(*v).rem_euclid(stride) == 0;
            let (major, minor) = powers.into_iter().partition(is_labelled);
            return Self { major, minor };
        }
        let times = |factors: &[f64]| {
            let products = decades
                .iter()
                .flat_map(|d| factors.iter().map(move |f| f * d));
            within(products.collect())
        };
        Self {
            major: times(&[1.0, 2.0, 5.0]),
            minor: times(&[3.0, 4.0, 6.0, 7.0, 8.0, 9.0]),
        }
    }

    /// The printed form of a tick: plain from 10⁻² to 10⁴, else with a power of ten.
    pub(super) fn label(value: f64) -> Label {
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
}

/// ⌊log₁₀ v⌋, a hair of rounding allowed.
fn decade(value: f64) -> i32 {
    #[expect(clippy::cast_possible_truncation, reason = "at most 324 in size")]
    let decade = (value.log10() + 1e-9).floor() as i32;
    decade
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_decades_are_thinned_and_few_are_divided() {
        let ticks = LogTicks::new(1e-13, 1.0, 7);
        assert!((3..=7).contains(&ticks.major.len()), "{ticks:?}");
        assert_eq!(ticks.major.len() + ticks.minor.len(), 14);
        let ticks = LogTicks::new(3.0, 40.0, 7);
        assert_eq!(ticks.major, [5.0, 10.0, 20.0]);
        assert_eq!(ticks.minor, [3.0, 4.0, 6.0, 7.0, 8.0, 9.0, 30.0, 40.0]);
    }

    #[test]
    fn labels_are_plain_or_powers_of_ten() {
        assert_eq!(LogTicks::label(0.05), Label::plain("0.05"));
        assert_eq!(LogTicks::label(1e-6), Label::plain("10").superscript("−6"));
        let label = Label::plain("2·10").superscript("5");
        assert_eq!(LogTicks::label(2e5), label);
    }
}

//! The unit of one quantity: its word, and the named SI unit it is a multiple of.

use std::ops::RangeInclusive;

use super::{Dimension, ForceUnit, LengthUnit, Units};

/// SI prefixes by powers of ten, as people read them.
const PREFIXES: [(i32, &str); 8] = [
    (-9, "n"),
    (-6, "µ"),
    (-3, "m"),
    (0, ""),
    (3, "k"),
    (6, "M"),
    (9, "G"),
    (12, "T"),
];

/// The unit of a quantity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unit {
    word: String,
    multiple: Option<(&'static str, i32)>,
    /// For an area in squares of a multiple of the metre: the power of ten of that.
    area: Option<i32>,
}

impl Unit {
    /// A number without unit.
    #[must_use]
    pub fn none() -> Self {
        Self::fixed("1".to_owned())
    }

    pub(super) fn new(units: Units, dimension: Dimension) -> Self {
        match dimension {
            Dimension::Number => Self::none(),
            Dimension::Time => Self::si("s", 0, "s".to_owned()),
            Dimension::Memory => Self::fixed("B".to_owned()),
            Dimension::Energy => named_energy(units)
                .unwrap_or_else(|| Self::fixed(format!("{} {}", units.force(), units.length()))),
            Dimension::Product { force, length } => Self::of_product(units, force, length),
            Dimension::Root { force, length } => {
                let below = Self::of_product(units, force, length).word;
                Self::fixed(format!("({below})^(1/2)"))
            }
        }
    }

    fn of_product(units: Units, force: i8, length: i8) -> Self {
        match (force, length) {
            (0, 1) => match units.length.metres() {
                Some(exponent) => Self::si("m", exponent, units.length().to_owned()),
                None => Self::fixed(units.length().to_owned()),
            },
            (1, 0) => match units.force.newtons() {
                Some(exponent) => Self::si("N", exponent, units.force().to_owned()),
                None => Self::fixed(units.force().to_owned()),
            },
            (1, -2) => named_stress(units)
                .unwrap_or_else(|| Self::fixed(format!("{}/{}^2", units.force(), units.length()))),
            (0, 2) => Self {
                area: units.length.metres(),
                ..Self::fixed(composite(units, force, length))
            },
            _ => Self::fixed(composite(units, force, length)),
        }
    }

    fn fixed(word: String) -> Self {
        Self {
            word,
            multiple: None,
            area: None,
        }
    }

    fn si(base: &'static str, exponent: i32, word: String) -> Self {
        Self {
            word,
            multiple: Some((base, exponent)),
            area: None,
        }
    }

    /// The word, `1` for a number without unit.
    #[must_use]
    pub fn word(&self) -> &str {
        &self.word
    }

    /// The word with a space before it, to stand beside a number; empty for no unit.
    #[must_use]
    pub fn beside(&self) -> String {
        if self.is_none() {
            String::new()
        } else {
            format!(" {}", self.word)
        }
    }

    /// Whether there is no unit.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.word == "1"
    }

    /// Values for people, each a text, and their unit: four digits of the largest, the SI prefix that suits it.
    #[must_use]
    pub fn parts(&self, values: &[f64]) -> (Vec<String>, String) {
        let largest = values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let (power, word) = self.prefixed(largest);
        let digits = digits_after_point(largest * 10f64.powi(-power));
        let told = values.iter().map(|value| {
            let value = value * 10f64.powi(-power);
            match digits {
                Some(digits) => trimmed(format!("{value:.digits$}")),
                None => format!("{value:.3e}"),
            }
        });
        (told.collect(), word)
    }

    /// The same with the unit behind them; several stand in brackets.
    #[must_use]
    pub fn told(&self, values: &[f64]) -> String {
        let (told, word) = self.parts(values);
        let numbers = match &told[..] {
            [one] => one.clone(),
            several => format!("({})", several.join(", ")),
        };
        if word == "1" {
            numbers
        } else {
            format!("{numbers} {word}")
        }
    }

    /// The power of ten of this unit that suits a magnitude, and its word for people: the unit itself where none does.
    #[must_use]
    pub fn prefixed(&self, magnitude: f64) -> (i32, String) {
        let (base, of_base, times) = match (self.multiple, &self.area) {
            (Some((base, power)), _) => (base.to_owned(), power, 1),
            (None, Some(power)) => ("m²".to_owned(), *power, 2),
            (None, None) => return (0, self.word.clone()),
        };
        // Who writes millimetres thinks in them.
        if magnitude == 0.0 || of_base != 0 && (1e-2..1e4).contains(&magnitude) {
            return (0, self.word.replace("^2", "²"));
        }
        let in_base = magnitude * 10f64.powi(times * of_base);
        // Squares grow by a million from prefix to prefix: 0.01 m² are told rather than 10,000 mm².
        let least = if times == 1 { 0.999_95 } else { 0.01 };
        let fits = |(exponent, _): &&(i32, &str)| in_base >= 10f64.powi(times * exponent) * least;
        let (exponent, prefix) = match PREFIXES.iter().rev().find(fits) {
            Some(found) => *found,
            None => return (0, self.word.replace("^2", "²")),
        };
        (times * (exponent - of_base), format!("{prefix}{base}"))
    }
}

fn named_stress(units: Units) -> Option<Unit> {
    if (units.length, units.force) == (LengthUnit::Inch, ForceUnit::PoundForce) {
        return Some(Unit::fixed("psi".to_owned()));
    }
    let exponent = units.force.newtons()? - 2 * units.length.metres()?;
    named("Pa", exponent, -3..=12)
}

fn named_energy(units: Units) -> Option<Unit> {
    let exponent = units.force.newtons()? + units.length.metres()?;
    named("J", exponent, -9..=9)
}

/// A multiple of an SI unit with a prefix, in letters of ASCII.
fn named(base: &'static str, exponent: i32, range: RangeInclusive<i32>) -> Option<Unit> {
    let mut prefixes = PREFIXES.iter().filter(|_| range.contains(&exponent));
    let (_, prefix) = prefixes.find(|(of, _)| *of == exponent)?;
    let word = format!("{prefix}{base}").replace('µ', "u");
    Some(Unit::si(base, exponent, word))
}

/// A number rounded to some significant digits.
#[must_use]
pub fn rounded(value: f64, digits: usize) -> f64 {
    let scientific = format!("{value:.0$e}", digits - 1);
    scientific.parse().unwrap_or(value)
}

/// A number in one line with some significant digits, without zeros that end them: plain from 10⁻³ to a limit.
#[must_use]
pub fn in_digits(value: f64, digits: usize, limit: f64) -> String {
    let rounded = rounded(value, digits);
    if rounded == 0.0 || (1e-3..limit).contains(&rounded.abs()) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

/// Digits after the point where the largest of some numbers is told with four; `None` where a power of ten tells it better.
fn digits_after_point(largest: f64) -> Option<usize> {
    match largest {
        0.0 => Some(0),
        1e6.. => None,
        1e3.. => Some(0),
        100.0.. => Some(1),
        10.0.. => Some(2),
        1.0.. => Some(3),
        0.1.. => Some(4),
        1e-3.. => Some(5),
        _ => None,
    }
}

/// A number without zeros that end its digits after the point, and zero without a sign.
fn trimmed(number: String) -> String {
    let number = match number.split_once('.') {
        Some(_) => number
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned(),
        None => number,
    };
    if number == "-0" {
        "0".to_owned()
    } else {
        number
    }
}

/// A product of powers. Two lengths on the other side of a force are taken for a stress where that
/// has a name, m/Pa rather than m^3/N, but a force per volume is one.
fn composite(units: Units, force: i8, length: i8) -> String {
    let stress = named_stress(units).filter(|_| force * length <= -2 && (force, length) != (1, -3));
    let (force_word, length) = match &stress {
        Some(stress) => (stress.word(), length + 2 * force),
        None => (units.force(), length),
    };
    let power = |word: &str, exponent: i8| match exponent.abs() {
        1 => word.to_owned(),
        exponent => format!("{word}^{exponent}"),
    };
    let factors = [(force_word, force), (units.length(), length)];
    let side = |sign: i8| -> Vec<String> {
        let there = factors.iter().filter(|(_, e)| e.signum() == sign);
        there.map(|(word, e)| power(word, *e)).collect()
    };
    let over = match side(1) {
        none if none.is_empty() => "1".to_owned(),
        factors => factors.join(" "),
    };
    match side(-1) {
        none if none.is_empty() => over,
        factors => format!("{over}/{}", factors.join("/")),
    }
}

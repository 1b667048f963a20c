//! The constants of a law of friction that HKL §3 uses: bounds, Lipschitz modulus, anisotropy.

use super::{FaceLaw, law_search::Sweep};
use crate::scene::{
    Coefficient, FrictionLaw, InvalidValue, LEAST_COEFFICIENT, Warning, Written, is_coefficient,
    place_words,
};

/// Steps in each decade, and halvings of one, that find where a law leaves its range.
const STEPS: i32 = 16;
const HALVINGS: usize = 40;

/// The constants of a law of friction that HKL §3 is stated in, over slips from 0 to the extent of
/// the body and over the contact nodes.
///
/// Constants, ramps, tables and grids are bounded exactly. For expressions the values are
/// estimates: the law is sampled at zero slip at all contact nodes, at a geometric series of slips
/// from 1e-12 of the extent on at some hundred nodes, and improved around the extremes found.
#[derive(Debug, Clone, PartialEq)]
pub struct LawBounds {
    /// F_min, the smallest coefficient.
    pub smallest: LawExtreme,
    /// F_max, the largest coefficient.
    pub largest: LawExtreme,
    /// Lipschitz modulus L in 1/m: the largest Euclidean norm of a gradient of F_i by
    /// (|u_t1|, |u_t2|); infinite where a gradient is.
    pub lipschitz: LawExtreme,
    /// κ(F) = sup max(F₁, F₂)/min(F₁, F₂), 1 for an isotropic law.
    pub anisotropy: LawExtreme,
    /// The largest slip considered, in m.
    pub largest_slip: f64,
    /// Whether the bounds are estimates, because a coefficient is an expression.
    pub estimated: bool,
}

/// An extreme value of a law and a point where it is attained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawExtreme {
    /// The value.
    pub value: f64,
    /// The coefficient: 0 for F₁ (or F of an isotropic law), 1 for F₂; of a ratio the larger one.
    pub coefficient: usize,
    /// The place in m; `None` where the law is the same everywhere.
    pub position: Option<[f64; 3]>,
    /// (|u_t1|, |u_t2|) in m, or (|u_t|, 0) of an isotropic law. A gradient may be that on the
    /// right of this slip.
    pub slip: [f64; 2],
}

impl LawBounds {
    /// Bounds a law over slips from 0 to `largest_slip`.
    #[must_use]
    pub fn new(law: &FaceLaw, largest_slip: f64) -> Self {
        let extreme_of = |measure| extreme_of(law, largest_slip, measure);
        let smallest = extreme_of(|f, x, s| -f.value(x, s));
        Self {
            smallest: LawExtreme {
                value: -smallest.value,
                ..smallest
            },
            largest: extreme_of(Sampled::value),
            lipschitz: extreme_of(Sampled::slope),
            anisotropy: anisotropy(law, largest_slip),
            largest_slip,
            estimated: law.coefficients().iter().any(Coefficient::is_searched),
        }
    }
}

/// What is maximised over places and slips.
type Measure<'a> = fn(&Sampled<'a>, [f64; 3], [f64; 2]) -> f64;

/// The largest value of a measure over all coefficients; the first of equal ones.
fn extreme_of<'a>(law: &'a FaceLaw, largest_slip: f64, measure: Measure<'a>) -> LawExtreme {
    let extremes = (0..law.coefficients().len()).map(|axis| {
        let sampled = Sampled::new(law, axis);
        let sweep = Sweep::new(law, &[axis], largest_slip);
        sweep.maximise(axis, |x, s| measure(&sampled, x, s))
    });
    let larger = |a: LawExtreme, b: LawExtreme| if b.value > a.value { b } else { a };
    extremes.reduce(larger).expect("a law has a coefficient")
}

/// κ(F). Between kinks the ratio of two functions that are linear in each slip is monotone in
/// each, so that kinks decide.
fn anisotropy(law: &FaceLaw, largest_slip: f64) -> LawExtreme {
    let axes: Vec<usize> = (0..law.coefficients().len()).collect();
    let sweep = Sweep::new(law, &axes, largest_slip);
    let values = |x, s| law.law().evaluate(x, s);
    let peak = sweep.maximise(0, |x, s| {
        let [first, second] = values(x, s);
        first.max(second) / first.min(second)
    });
    let [first, second] = values(peak.position.unwrap_or_default(), peak.slip);
    LawExtreme {
        coefficient: usize::from(second > first),
        ..peak
    }
}

/// One coefficient of a law as a function of place and slips.
struct Sampled<'a> {
    law: &'a FrictionLaw,
    axis: usize,
}

impl<'a> Sampled<'a> {
    fn new(law: &'a FaceLaw, axis: usize) -> Self {
        let law = law.law();
        Self { law, axis }
    }

    fn value(&self, position: [f64; 3], slip: [f64; 2]) -> f64 {
        let at = self.law.point(self.axis, position, slip);
        self.law.coefficients()[self.axis].evaluate(&at)
    }

    /// The norm of the gradient by the slips.
    fn slope(&self, position: [f64; 3], slip: [f64; 2]) -> f64 {
        let at = self.law.point(self.axis, position, slip);
        let derivative = self.law.coefficients()[self.axis].derivative(&at);
        let mut gradient = derivative.pair;
        gradient[self.axis] += derivative.own;
        gradient[0].hypot(gradient[1])
    }
}

/// Refuses a law with a coefficient that is not positive and finite at zero slip somewhere on the
/// face, in the unit of length called `length`; other kinds than expressions are checked with the scene.
pub(super) fn refuse_unusable(law: &FaceLaw, length: &str) -> Result<(), InvalidValue> {
    match worst_values(law, 0.0, length).next() {
        None => Ok(()),
        Some(worst) => Err(InvalidValue {
            key: key(law, worst.peak.coefficient),
            expected: format!("0 < F < infinity without slip, {LEAST_COEFFICIENT:e} at least, on the whole contact face"),
            found: format!("{} at {}", Written(&worst.value), worst.place),
            help: "F at zero slip decides what sticks: correct the formula there, such as 0.3 + 0.1*x; frictionless contact has no [friction]".into(),
        }),
    }
}

/// Where coefficients are not positive and finite at slips up to `largest_slip`. Whether a solution
/// has such slips is not known before it is found.
pub(super) fn warnings(law: &FaceLaw, largest_slip: f64, length: &str) -> Vec<Warning> {
    let words = |worst: Worst| Warning::LawLeavesRange {
        key: key(law, worst.peak.coefficient),
        onset: worst.onset(law, length),
        value: worst.value,
        place: worst.place,
    };
    worst_values(law, largest_slip, length).map(words).collect()
}

fn key(law: &FaceLaw, axis: usize) -> String {
    let (table, kind) = (&law.key, law.coefficients()[axis].kind());
    match law.coefficients().len() {
        1 => format!("{table}.coefficient.{kind}"),
        _ => format!("{table}.coefficient_{}.{kind}", axis + 1),
    }
}

/// A value of a coefficient that is not positive and finite.
struct Worst {
    value: f64,
    peak: LawExtreme,
    /// Slips and place in words.
    place: String,
}

impl Worst {
    /// The first slips in words at which the coefficient is not usable, on the way from zero slip to
    /// the worst one.
    fn onset(&self, law: &FaceLaw, length: &str) -> String {
        let axis = self.peak.coefficient;
        let sampled = Sampled::new(law, axis);
        let position = self.peak.position.unwrap_or_default();
        let at = |share: f64| self.peak.slip.map(|slip| share * slip);
        let is_usable = |share: f64| is_coefficient(sampled.value(position, at(share)));
        let shares = (0..=12 * STEPS).rev();
        let shares = shares.map(|k| 10f64.powf(-f64::from(k) / f64::from(STEPS)));
        let mut good = 0.0;
        let mut bad = 1.0;
        for share in shares {
            if !is_usable(share) {
                bad = share;
                break;
            }
            good = share;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (good + bad);
            if is_usable(middle) {
                good = middle;
            } else {
                bad = middle;
            }
        }
        let peak = LawExtreme {
            position: None,
            slip: at(bad),
            ..self.peak
        };
        let coefficient = &law.coefficients()[axis];
        let isotropic = law.coefficients().len() == 1;
        point_words(&peak, isotropic, coefficient.slips_used(axis), length)
    }
}

/// For every formula that is not positive and finite everywhere at slips from 0 to `largest_slip`
/// one such value: the least one, or one that is not finite.
fn worst_values(law: &FaceLaw, largest_slip: f64, length: &str) -> impl Iterator<Item = Worst> {
    let coefficients = law.coefficients();
    let formulas = coefficients
        .iter()
        .enumerate()
        .filter(|(_, coefficient)| coefficient.is_searched());
    formulas.filter_map(move |(axis, coefficient)| {
        let sampled = Sampled::new(law, axis);
        let sweep = Sweep::new(law, &[axis], largest_slip);
        let peak = sweep.maximise(axis, |x, s| {
            let value = sampled.value(x, s);
            if value.is_finite() {
                -value
            } else {
                f64::INFINITY
            }
        });
        let uses = coefficient.slips_used(axis);
        let value = sampled.value(peak.position.unwrap_or_default(), peak.slip);
        (!is_coefficient(value)).then(|| Worst {
            value,
            place: point_words(&peak, coefficients.len() == 1, uses, length),
            peak,
        })
    })
}

/// A point of a law in words, as far as the coefficient depends on it.
fn point_words(peak: &LawExtreme, isotropic: bool, uses: [bool; 2], length: &str) -> String {
    let names = if isotropic {
        ["|u_t|", ""]
    } else {
        ["|u_t1|", "|u_t2|"]
    };
    let mut words: Vec<String> = (0..2)
        .filter(|&k| uses[k])
        .map(|k| format!("{} = {:.4e} {length}", names[k], peak.slip[k]))
        .collect();
    if let Some(place) = peak.position {
        words.push(place_words(place));
    }
    if words.is_empty() {
        words.push("every slip".into());
    }
    words.join(", ")
}

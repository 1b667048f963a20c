//! The constants of a law of friction that HKL §3 uses: bounds, Lipschitz modulus, anisotropy.

use super::FaceLaw;
use crate::scene::{
    Coefficient, InvalidValue, LEAST_COEFFICIENT, Warning, Written, is_coefficient, place_words,
};

/// The constants of a law of friction that HKL §3 is stated in, over slips from 0 to the extent of
/// the body and over the contact nodes.
///
/// Constants, ramps, tables and grids are bounded exactly. For expressions the values are
/// estimates: the law is sampled at zero slip at all contact nodes, at a geometric series of slips
/// from 1e-12 of the extent on at some of them, and improved around the extremes found.
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
        let smallest = extreme_of(|law, axis, x, s| -law.value(axis, x, s));
        Self {
            smallest: LawExtreme {
                value: -smallest.value,
                ..smallest
            },
            largest: extreme_of(FaceLaw::value),
            lipschitz: extreme_of(FaceLaw::slope),
            anisotropy: anisotropy(law, largest_slip),
            estimated: law.coefficients().iter().any(Coefficient::is_searched),
        }
    }
}

/// The largest value of a measure of a coefficient over all coefficients, places and slips; the first of equal ones.
fn extreme_of(
    law: &FaceLaw,
    largest_slip: f64,
    measure: fn(&FaceLaw, usize, [f64; 3], [f64; 2]) -> f64,
) -> LawExtreme {
    let extremes = (0..law.coefficients().len()).map(|axis| {
        let sweep = Sweep::new(law, &[axis], largest_slip);
        sweep.maximise(axis, |x, s| measure(law, axis, x, s))
    });
    let larger = |a: LawExtreme, b: LawExtreme| if b.value > a.value { b } else { a };
    extremes.reduce(larger).expect("a law has a coefficient")
}

/// κ(F). Between kinks the ratio of two functions that are linear in each slip is monotone in
/// each, so that kinks decide.
fn anisotropy(law: &FaceLaw, largest_slip: f64) -> LawExtreme {
    let axes: Vec<usize> = (0..law.coefficients().len()).collect();
    let sweep = Sweep::new(law, &axes, largest_slip);
    let values = |x, s| law.law.evaluate([0.0; 3], x, s);
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

impl FaceLaw {
    /// One coefficient at a place for some slips.
    fn value(&self, axis: usize, position: [f64; 3], slip: [f64; 2]) -> f64 {
        let at = self.law.point([0.0; 3], axis, position, slip);
        self.coefficients()[axis].evaluate(&at)
    }

    /// The norm of its gradient by the slips.
    fn slope(&self, axis: usize, position: [f64; 3], slip: [f64; 2]) -> f64 {
        let at = self.law.point([0.0; 3], axis, position, slip);
        let derivative = self.coefficients()[axis].derivative(&at);
        let mut gradient = derivative.pair;
        gradient[axis] += derivative.own;
        gradient[0].hypot(gradient[1])
    }
}

/// Refuses a law with a coefficient that is not positive and finite at zero slip somewhere on the
/// face, in the unit of length called `length`; other kinds than expressions are checked with the scene.
pub(super) fn refuse_unusable(law: &FaceLaw, length: &str) -> Result<(), InvalidValue> {
    let refuse = |(key, value, place)| {
        Err(InvalidValue {
            key,
            expected: format!("0 < F < infinity without slip, {LEAST_COEFFICIENT:e} at least, on the whole contact face"),
            found: format!("{} at {place}", Written(&value)),
            help: "F at zero slip decides what sticks: correct the formula there, such as 0.3 + 0.1*x; frictionless contact has no [friction]".into(),
        })
    };
    worst_values(law, 0.0, length).next().map_or(Ok(()), refuse)
}

/// Where coefficients are not positive and finite at slips up to `largest_slip`. Whether a solution
/// has such slips is not known before it is found.
pub(super) fn warnings(law: &FaceLaw, largest_slip: f64, length: &str) -> Vec<Warning> {
    worst_values(law, largest_slip, length)
        .map(|(key, value, place)| Warning::LawLeavesRange { key, value, place })
        .collect()
}

/// The key of every formula that is not positive and finite everywhere at slips from 0 to `largest_slip`, with one such value, the
/// least one or one that is not finite, and its slips and place in words.
fn worst_values(
    law: &FaceLaw,
    largest_slip: f64,
    length: &str,
) -> impl Iterator<Item = (String, f64, String)> {
    let coefficients = law.coefficients();
    let isotropic = coefficients.len() == 1;
    let formulas = coefficients
        .iter()
        .enumerate()
        .filter(|(_, coefficient)| coefficient.is_searched());
    formulas.filter_map(move |(axis, coefficient)| {
        let sweep = Sweep::new(law, &[axis], largest_slip);
        let peak = sweep.maximise(axis, |x, s| {
            let value = law.value(axis, x, s);
            if value.is_finite() {
                -value
            } else {
                f64::INFINITY
            }
        });
        let value = law.value(axis, peak.position.unwrap_or_default(), peak.slip);
        let (table, kind) = (&law.key, coefficient.kind());
        let key = if isotropic {
            format!("{table}.coefficient.{kind}")
        } else {
            format!("{table}.coefficient_{}.{kind}", axis + 1)
        };
        let place = point_words(&peak, isotropic, coefficient.slips_used(axis), length);
        (!is_coefficient(value)).then_some((key, value, place))
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

/// Where some coefficients of a law are looked at: places on the contact face and slips.
///
/// Without formulas the slips are the kinks, each also one rounding to its right, where one-sided
/// derivatives differ, and the ends of the range: what is monotone in each slip between kinks has
/// its extremes there. With formulas a geometric series is added, and extremes are improved.
struct Sweep<'a> {
    places: &'a [[f64; 3]],
    slips: [Vec<f64>; 2],
    search: bool,
    depends_on_place: bool,
}

impl<'a> Sweep<'a> {
    /// A sweep for the given coefficients, numbered 0 and 1, over slips from 0 to `largest_slip`.
    fn new(law: &'a FaceLaw, axes: &[usize], largest_slip: f64) -> Self {
        let coefficients = law.coefficients();
        let chosen: Vec<(usize, &Coefficient)> =
            axes.iter().map(|&i| (i, &coefficients[i])).collect();
        let depends_on_place = chosen.iter().any(|(_, c)| c.depends_on_place());
        let positions = &law.positions;
        let places = if depends_on_place {
            positions
        } else {
            &positions[..1.min(positions.len())]
        };
        let searched = [0, 1].map(|k| {
            let mut formulas = chosen.iter().filter(|(_, c)| c.is_searched());
            formulas.any(|(i, c)| c.slips_used(*i)[k])
        });
        let per_decade = match (searched, depends_on_place) {
            ([true, true], true) => 4,
            ([true, true], false) => 16,
            _ => 32,
        };
        let slips = [0, 1].map(|k| {
            let used = chosen.iter().any(|(i, c)| c.slips_used(*i)[k]);
            let kinks = chosen.iter().flat_map(|(i, c)| c.kinks(*i)[k].clone());
            let mut slips = vec![0.0];
            if used {
                slips.push(largest_slip);
                slips.extend(kinks.flat_map(|kink| [kink, kink.next_up()]));
            }
            if searched[k] {
                slips.extend(series(largest_slip, per_decade));
            }
            slips.retain(|slip| *slip <= largest_slip);
            slips.sort_by(f64::total_cmp);
            slips.dedup();
            slips
        });
        Self {
            places,
            slips,
            search: searched != [false; 2],
            depends_on_place,
        }
    }

    /// The largest value of a function of place and slip that a coefficient gives; values that are no numbers are passed
    /// over.
    fn maximise(
        &self,
        coefficient: usize,
        function: impl Fn([f64; 3], [f64; 2]) -> f64,
    ) -> LawExtreme {
        let mut best = Best {
            place: 0,
            slip: [0.0; 2],
            value: f64::NEG_INFINITY,
        };
        for place in 0..self.places.len() {
            best.offer(place, [0.0; 2], function(self.places[place], [0.0; 2]));
        }
        // Places that see all slips: so many of all, and the one that is highest at zero slip.
        let stride = self.places.len().div_ceil(256).max(1);
        let seen = (0..self.places.len()).step_by(stride);
        for place in seen.chain([best.place]) {
            for &first in &self.slips[0] {
                for &second in &self.slips[1] {
                    let slip = [first, second];
                    best.offer(place, slip, function(self.places[place], slip));
                }
            }
        }
        if self.search {
            self.improve(&mut best, &function);
        }
        LawExtreme {
            value: best.value,
            coefficient,
            position: self.depends_on_place.then(|| self.places[best.place]),
            slip: [0, 1].map(|k| self.without_side(k, best.slip[k])),
        }
    }

    /// Improves an extreme in each slip between its neighbours in the sweep, then over all places.
    fn improve(&self, best: &mut Best, function: &impl Fn([f64; 3], [f64; 2]) -> f64) {
        for _ in 0..3 {
            for k in 0..2 {
                let slips = &self.slips[k];
                let above = slips.partition_point(|slip| *slip <= best.slip[k]);
                let below = slips.partition_point(|slip| *slip < best.slip[k]);
                let interval = [
                    slips[below.saturating_sub(1)],
                    slips[above.min(slips.len() - 1)],
                ];
                let (place, mut slip) = (best.place, best.slip);
                golden_sections(interval, |value| {
                    slip[k] = value;
                    let found = function(self.places[place], slip);
                    best.offer(place, slip, found);
                    found
                });
            }
            for place in 0..self.places.len() {
                best.offer(place, best.slip, function(self.places[place], best.slip));
            }
        }
    }

    /// A slip one rounding to the right of a kink stands for the kink.
    fn without_side(&self, k: usize, slip: f64) -> f64 {
        let kink = slip.next_down();
        if self.slips[k].contains(&kink) {
            kink
        } else {
            slip
        }
    }
}

/// The largest value so far.
struct Best {
    place: usize,
    slip: [f64; 2],
    value: f64,
}

impl Best {
    fn offer(&mut self, place: usize, slip: [f64; 2], value: f64) {
        if value > self.value {
            *self = Self { place, slip, value };
        }
    }
}

/// A geometric series up to the largest slip, over twelve decades.
fn series(largest: f64, per_decade: u32) -> impl Iterator<Item = f64> {
    let count = f64::from(per_decade);
    (0..=12 * per_decade).map(move |k| largest * 10f64.powf(-f64::from(k) / count))
}

/// Golden section search for a maximum; the function keeps what it finds.
fn golden_sections([mut low, mut high]: [f64; 2], mut function: impl FnMut(f64) -> f64) {
    let ratio = (5f64.sqrt() - 1.0) / 2.0;
    let inner = |low: f64, high: f64| [high - ratio * (high - low), low + ratio * (high - low)];
    let [mut left, mut right] = inner(low, high);
    let [mut at_left, mut at_right] = [function(left), function(right)];
    // 0.618⁴⁰ is 4e-9 of the interval, and values are flat at extremes.
    for _ in 0..40 {
        if at_left > at_right {
            (high, right, at_right) = (right, left, at_left);
            left = inner(low, high)[0];
            at_left = function(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = inner(low, high)[1];
            at_right = function(right);
        }
    }
}

//! Extreme values of a law given by formulas, searched over slips and places.

use std::collections::BTreeMap;

use super::{FaceLaw, LawExtreme};
use crate::scene::Coefficient;

/// Smallest slip of a sweep over formulas, relative to the largest.
const SMALLEST_SLIP: f64 = 1e-12;

/// Intervals along each coordinate that spread places over the face.
const INTERVALS: f64 = 16.0;

/// Rounds of improving an extreme of a formula, one variable at a time.
const ROUNDS: usize = 3;

/// Golden sections of an interval: 0.618⁴⁰ is 4e-9 of it, and values are flat at extremes.
const SECTIONS: usize = 40;

/// Where some coefficients of a law are looked at: places on the contact face and slips.
///
/// Without formulas the slips are the kinks, each also one rounding to its right, where one-sided
/// derivatives differ, and the ends of the range: what is monotone in each slip between kinks has
/// its extremes there. With formulas a geometric series is added, and extremes are improved.
pub(super) struct Sweep<'a> {
    places: &'a [[f64; 3]],
    /// Places that see all slips; the others see zero slip only.
    spread: Vec<usize>,
    slips: [Vec<f64>; 2],
    search: bool,
    depends_on_place: bool,
}

impl<'a> Sweep<'a> {
    /// A sweep for the given coefficients, numbered 0 and 1, over slips from 0 to `largest_slip`.
    pub(super) fn new(law: &'a FaceLaw, axes: &[usize], largest_slip: f64) -> Self {
        let coefficients = law.coefficients();
        let chosen: Vec<(usize, &Coefficient)> =
            axes.iter().map(|&i| (i, &coefficients[i])).collect();
        let depends_on_place = chosen.iter().any(|(_, c)| c.depends_on_place());
        let positions = law.positions();
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
            spread: spread(places),
            places,
            slips,
            search: searched != [false; 2],
            depends_on_place,
        }
    }

    /// The largest value of a function of place and slip that a coefficient gives; values that are no numbers are passed
    /// over.
    pub(super) fn maximise(
        &self,
        coefficient: usize,
        function: impl Fn([f64; 3], [f64; 2]) -> f64,
    ) -> LawExtreme {
        let mut best = Best::default();
        for place in 0..self.places.len() {
            best.offer(place, [0.0; 2], function(self.places[place], [0.0; 2]));
        }
        let highest_at_rest = best.place;
        for place in self.spread.iter().copied().chain([highest_at_rest]) {
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
        for _ in 0..ROUNDS {
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

impl Default for Best {
    fn default() -> Self {
        Self {
            place: 0,
            slip: [0.0; 2],
            value: f64::NEG_INFINITY,
        }
    }
}

impl Best {
    fn offer(&mut self, place: usize, slip: [f64; 2], value: f64) {
        if value > self.value {
            *self = Self { place, slip, value };
        }
    }
}

/// A geometric series up to the largest slip.
fn series(largest: f64, per_decade: u32) -> impl Iterator<Item = f64> {
    let steps = f64::from(per_decade) * -SMALLEST_SLIP.log10();
    let count = f64::from(per_decade);
    (0..)
        .map(f64::from)
        .take_while(move |k: &f64| *k <= steps)
        .map(move |k| largest * 10f64.powf(-k / count))
}

/// One place in each box of a coarse grid around all places, so that they spread over the face.
fn spread(places: &[[f64; 3]]) -> Vec<usize> {
    let bounds = [0, 1, 2].map(|c| {
        let along = places.iter().map(|x| x[c]);
        let low = along.clone().fold(f64::INFINITY, f64::min);
        (low, along.fold(f64::NEG_INFINITY, f64::max) - low)
    });
    let mut boxes = BTreeMap::new();
    for (place, x) in places.iter().enumerate() {
        #[expect(clippy::cast_possible_truncation, reason = "from 0 to 16")]
        let key = [0, 1, 2].map(|c| {
            let (low, extent) = bounds[c];
            let share = (x[c] - low) / extent.max(f64::MIN_POSITIVE);
            (share * INTERVALS) as i32
        });
        boxes.entry(key).or_insert(place);
    }
    boxes.into_values().collect()
}

/// Golden section search for a maximum; the function keeps what it finds.
fn golden_sections([mut low, mut high]: [f64; 2], mut function: impl FnMut(f64) -> f64) {
    let ratio = (5f64.sqrt() - 1.0) / 2.0;
    let inner = |low: f64, high: f64| [high - ratio * (high - low), low + ratio * (high - low)];
    let [mut left, mut right] = inner(low, high);
    let [mut at_left, mut at_right] = [function(left), function(right)];
    for _ in 0..SECTIONS {
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

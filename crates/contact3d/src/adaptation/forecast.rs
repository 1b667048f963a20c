//! What the next level of an adaptive computation is expected to come to.

use std::time::{Duration, Instant};

use super::AdaptiveLevel;
use crate::post::LARGEST_TOLD;

/// Seconds of a level grow with this power of its unknowns where one level is all that is known: between that of writing (1) and that
/// of factorising (2).
const USUAL_POWER: f64 = 1.5;

/// The error falls with this power of the unknowns where one level is all that is known: what cells of equal shape reach at edges.
const USUAL_RATE: f64 = 0.5;

/// The power of levels that go well: a target is called out of reach after one level only where it is so with this one.
const BEST_RATE: f64 = 1.0;

/// What a level is expected to come to before it is assembled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelForecast {
    /// Free degrees of freedom.
    pub n_free: usize,
    /// Seconds of mesh, assembly, solve and evaluation.
    pub seconds: f64,
    /// Estimated error over ‖u_h‖_A at the rate so far.
    pub estimated_error: f64,
    /// Free degrees of freedom with which the target would be met at the rate so far; after one level at the best rate
    /// that levels have; `None` while the error is more than half of the solution, and has no rate.
    pub n_free_of_target: Option<f64>,
    /// Graded cells of a brick that is meshed anew; `None` where the level before is cut.
    pub cells: Option<[usize; 3]>,
}

impl LevelForecast {
    /// For a level with `growth` times the nodes of the last one that is done, on the way to a relative error.
    pub(super) fn new(levels: &[AdaptiveLevel], growth: f64, target: f64) -> Self {
        let last = levels.last().copied().unwrap_or_default();
        let before = levels.len().checked_sub(2).map(|k| levels[k]);
        let n_free = last.n_free as f64 * growth;
        let power = |usual: f64, quotient: fn(&AdaptiveLevel) -> f64, range: [f64; 2]| {
            let Some(before) = before else { return usual };
            let unknowns = (last.n_free as f64 / before.n_free as f64).ln();
            let power = (quotient(&last) / quotient(&before)).ln() / unknowns;
            if power.is_finite() {
                power.clamp(range[0], range[1])
            } else {
                usual
            }
        };
        let cost = power(USUAL_POWER, |level| level.seconds, [1.0, 2.0]);
        // Coarse meshes tell little of it.
        let rate = power(USUAL_RATE, |level| 1.0 / level.estimated_error, [0.4, 2.0]);
        let rate_to_target = if before.is_some() { rate } else { BEST_RATE };
        let to_go = (last.estimated_error / target).max(1.0);
        Self {
            n_free: n_free as usize,
            seconds: last.seconds * growth.powf(cost),
            estimated_error: last.estimated_error * growth.powf(-rate),
            n_free_of_target: (last.estimated_error < LARGEST_TOLD)
                .then(|| last.n_free as f64 * to_go.powf(1.0 / rate_to_target)),
            cells: None,
        }
    }

    /// Whether the level ends after some time, if it is begun now.
    pub(super) fn ends_after(&self, end: Instant) -> bool {
        let seconds = Duration::try_from_secs_f64(self.seconds).unwrap_or(Duration::MAX);
        Instant::now()
            .checked_add(seconds)
            .is_none_or(|ended| ended > end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(n_free: usize, estimated_error: f64, seconds: f64) -> AdaptiveLevel {
        AdaptiveLevel {
            n_free,
            estimated_error,
            seconds,
            ..AdaptiveLevel::default()
        }
    }

    /// Levels whose error halves and whose time grows eightfold where the unknowns grow fourfold go on so.
    #[test]
    fn rates_of_the_last_levels_go_on() {
        let levels = [level(100, 0.4, 1.0), level(400, 0.2, 8.0)];
        let forecast = LevelForecast::new(&levels, 4.0, 0.05);
        assert_eq!(forecast.n_free, 1600);
        // Logarithms and powers of exact numbers: some roundings.
        assert!((forecast.seconds - 64.0).abs() < 1e-9, "{forecast:?}");
        let of_target = forecast.n_free_of_target.expect("a rate");
        assert!((of_target - 6400.0).abs() < 1e-6);
        let alone = LevelForecast::new(&levels[..1], 4.0, 0.05);
        assert!((alone.seconds - 8.0).abs() < 1e-12, "{alone:?}");
    }
}

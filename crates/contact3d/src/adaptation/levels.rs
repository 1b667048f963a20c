//! What adaptive levels came to, and what the next one is expected to come to.

use std::time::{Duration, Instant};

use crate::{mesh::RefinedLevel, post::MAX_RELIABLE_ESTIMATE, scene::Functional, solver::Status};

/// One mesh of an adaptive computation, solved.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AdaptiveLevel {
    /// Tetrahedra.
    pub n_tetrahedra: usize,
    /// Free degrees of freedom.
    pub n_free: usize,
    /// Multipliers.
    pub n_multipliers: usize,
    /// Panes in contact, of a load history in its last increment.
    pub n_closed: usize,
    /// Estimated error over ‖u_h‖_A; see [`ErrorEstimate::relative`](crate::post::ErrorEstimate::relative). Of a load history the largest
    /// of its increments, as [`HistoryErrors`](crate::history::HistoryErrors) measures them; NaN where it ended early, and without a solution, and 1 where the panes of the mesh alone cannot hold the body.
    pub estimated_error: f64,
    /// Value of the quantity that the mesh is refined for; `None` of the energy norm and of a load history.
    pub value: Option<f64>,
    /// How the solve ended.
    pub status: Status,
    /// Seconds of mesh, assembly, solve and evaluation.
    pub seconds: f64,
}

units::worded! {
    /// How an adaptive computation ended.
    pub enum AdaptiveStatus {
        /// There are levels to come.
        Refining = "refining",
        /// The estimate meets the target.
        Met = "met",
        /// A level did not converge.
        NotConverged = "not_converged",
        /// The next level does not fit into memory or on the disk.
        TooLarge = "too_large",
        /// Cutting makes the estimate no smaller.
        Stalled = "stalled",
        /// The largest pressure or stress has no limit, as at a sharp edge: it grew from level to level.
        Unbounded = "unbounded",
        /// The quantity that the mesh is refined for became zero, or has no estimate on the next level.
        NotEstimated = "not_estimated",
        /// The next level is forecast to end later than allowed.
        OverBudget = "over_budget",
    }
}

/// Levels that are done, with what the next one is made of.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Adaptation {
    /// The levels, coarse to fine, `[n_levels]`.
    pub levels: Vec<AdaptiveLevel>,
    /// How each level follows from the one before, one that is not done included.
    pub refinement: Vec<RefinedLevel>,
    /// Multipliers in Pa that each refined level starts from, one list for each level of the
    /// refinement.
    pub starts: Vec<Vec<f64>>,
}

impl Adaptation {
    /// The first level that meets a target; none with an error as large as the solution does.
    #[must_use]
    pub fn level_that_meets(&self, target: f64) -> Option<usize> {
        let is_met = |error: f64| error <= target && error < 1.0;
        let meets = |l: &AdaptiveLevel| l.status.is_solved() && is_met(l.estimated_error);
        self.levels.iter().position(meets)
    }

    /// The level on which contact first appears, if coarser ones have none: their errors are those of a body that nothing touches.
    #[must_use]
    pub fn first_in_contact(&self) -> Option<usize> {
        let first = self.levels.iter().position(|level| level.n_closed > 0);
        let is_solved = |level: &AdaptiveLevel| level.status.is_solved();
        first.filter(|first| *first > 0 && self.levels[..*first].iter().all(is_solved))
    }

    /// Whether the quantity grew by more than a tenth on each of three levels, and hardly less on the last: on levels that cut the panes at
    /// its place, what converges grows by less and less.
    fn grows_without_limit(&self) -> bool {
        let growth = |pair: &[AdaptiveLevel]| Some(pair[1].value? / pair[0].value? - 1.0);
        let growths: Option<Vec<f64>> = self.levels.windows(2).map(growth).collect();
        match growths.as_deref() {
            Some([.., first, second, third]) => {
                [first, second, third].iter().all(|growth| **growth > 0.1) && *third > 0.5 * first
            }
            _ => false,
        }
    }

    /// How the levels stand with a target for a quantity, or for the energy norm; that nothing larger fits is for the caller to say.
    #[must_use]
    pub fn status(&self, target: f64, of: Option<Functional>) -> AdaptiveStatus {
        if self.level_that_meets(target).is_some() {
            return AdaptiveStatus::Met;
        }
        let Some(last) = self.levels.last() else {
            return AdaptiveStatus::Refining;
        };
        let is_of_mesh = last.status == Status::NoEquilibrium;
        if !(last.status.is_solved() || is_of_mesh) || last.estimated_error.is_nan() {
            return AdaptiveStatus::NotConverged;
        }
        // What only grows on the way to its limit, as stress at a hole with few sides, has a finite bar.
        let may_grow = match of {
            Some(Functional::LargestVonMises) => last.estimated_error.is_infinite(),
            _ => of == Some(Functional::LargestPressure),
        };
        if may_grow && self.grows_without_limit() {
            return AdaptiveStatus::Unbounded;
        }
        // Three levels in a row have to make the estimate smaller between them, over a halving of all edges: it also rises where a level
        // finds contact. One larger than the solution tells where a coarse mesh misses contact, and does not fall before that is found,
        // with far fewer unknowns: it has two halvings.
        let before = self.levels.len().saturating_sub(3);
        let growth = if last.estimated_error >= 1.0 { 64 } else { 8 };
        let coarser = |l: &&AdaptiveLevel| growth * l.n_free <= last.n_free;
        let earlier = self.levels[..before].iter().rfind(coarser);
        let is_no_less = |earlier: &AdaptiveLevel| last.estimated_error >= earlier.estimated_error;
        let falls = self
            .levels
            .iter()
            .nth_back(1)
            .is_some_and(|one| !is_no_less(one));
        if earlier.is_some_and(is_no_less) && !falls {
            AdaptiveStatus::Stalled
        } else {
            AdaptiveStatus::Refining
        }
    }
}

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
        // Where one level is all that is known, seconds grow with a power between that of writing and that of factorising, and the error
        // falls as it does on cells of equal shape at edges; coarse meshes tell little of its rate. A target is called out of reach after
        // one level only where it is so at the rate of levels that go well.
        let cost = power(1.5, |level| level.seconds, [1.0, 2.0]);
        let rate = power(0.5, |level| 1.0 / level.estimated_error, [0.4, 2.0]);
        let rate_to_target = if before.is_some() { rate } else { 1.0 };
        let to_go = (last.estimated_error / target).max(1.0);
        Self {
            n_free: n_free as usize,
            seconds: last.seconds * growth.powf(cost),
            estimated_error: last.estimated_error * growth.powf(-rate),
            n_free_of_target: (last.estimated_error < MAX_RELIABLE_ESTIMATE)
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
            status: Status::Converged,
            n_free,
            estimated_error,
            seconds,
            ..AdaptiveLevel::default()
        }
    }

    /// Panes that cannot hold the body are refined away; a body that nothing holds is not.
    #[test]
    fn a_mechanism_of_the_mesh_alone_is_refined() {
        let status = |estimated_error: f64| {
            let unheld = AdaptiveLevel {
                status: Status::NoEquilibrium,
                ..level(100, estimated_error, 1.0)
            };
            let adaptation = Adaptation {
                levels: vec![unheld],
                ..Adaptation::default()
            };
            adaptation.status(0.2, None)
        };
        assert_eq!(status(1.0), AdaptiveStatus::Refining);
        assert_eq!(status(f64::NAN), AdaptiveStatus::NotConverged);
    }

    #[test]
    fn contact_that_coarse_meshes_miss_appears_on_a_level() {
        let first = |closed: &[usize], coarsest: Status| {
            let of = |n_closed: &usize| AdaptiveLevel {
                n_closed: *n_closed,
                ..level(100, 0.5, 1.0)
            };
            let mut levels: Vec<AdaptiveLevel> = closed.iter().map(of).collect();
            levels[0].status = coarsest;
            let adaptation = Adaptation {
                levels,
                ..Adaptation::default()
            };
            adaptation.first_in_contact()
        };
        assert_eq!(first(&[0, 0, 3, 5], Status::Converged), Some(2));
        assert_eq!(first(&[1, 4], Status::Converged), None);
        assert_eq!(first(&[0, 0], Status::Converged), None);
        // Panes that hold no body touch all the same.
        assert_eq!(first(&[0, 4], Status::NoEquilibrium), None);
    }

    #[test]
    fn what_grows_by_less_and_less_has_a_limit() {
        let ends = |values: &[f64], error: f64, of: Functional| {
            let levels = values.iter().map(|value| AdaptiveLevel {
                value: Some(*value),
                ..level(100, error, 1.0)
            });
            let adaptation = Adaptation {
                levels: levels.collect(),
                ..Adaptation::default()
            };
            adaptation.status(0.01, Some(of)) == AdaptiveStatus::Unbounded
        };
        let grows = |values: &[f64]| ends(values, 1.0, Functional::LargestPressure);
        assert!(grows(&[1.0, 1.25, 1.6, 2.0]));
        // A stress has no bound only where something is named that it grows at.
        for error in [1.0, f64::INFINITY] {
            let grows = ends(&[1.0, 1.25, 1.6, 2.0], error, Functional::LargestVonMises);
            assert_eq!(grows, error.is_infinite());
        }
        assert!(!grows(&[1.0, 1.4, 1.7, 1.85]));
        assert!(!grows(&[1.0, 1.25, 1.6]));
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

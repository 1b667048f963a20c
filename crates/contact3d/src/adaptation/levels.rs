//! What adaptive levels came to.

use crate::{mesh::Refinement, solver::Status};

/// One mesh of an adaptive computation, solved.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AdaptiveLevel {
    /// Tetrahedra.
    pub n_tetrahedra: usize,
    /// Free degrees of freedom.
    pub n_free: usize,
    /// Multipliers.
    pub n_multipliers: usize,
    /// Estimated error over ‖u_h‖_A; see [`ErrorEstimate::relative`](crate::post::ErrorEstimate::relative). Of a load history the largest
    /// of its increments, as [`HistoryErrors`](crate::history::HistoryErrors) measures them; NaN where it ended early.
    pub estimated_error: f64,
    /// Smallest eigenvalue of S scaled to a unit diagonal: what keeps the multipliers of a mesh
    /// apart; `None` without contact or where S is not held.
    pub stability: Option<f64>,
    /// How the solve ended.
    pub status: Status,
    /// Seconds of mesh, assembly, solve and evaluation.
    pub seconds: f64,
}

/// How an adaptive computation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdaptiveStatus {
    /// There are levels to come.
    Refining,
    /// The estimate meets the target.
    Met,
    /// A level did not converge.
    NotConverged,
    /// The next level does not fit into memory or on the disk.
    TooLarge,
    /// Cutting makes the estimate no smaller.
    Stalled,
    /// The quantity that the mesh is refined for became zero, or has no estimate on the next level.
    NotEstimated,
    /// The next level is forecast to end later than allowed.
    OverBudget,
}

/// Levels that are done, with what the next one is made of.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Adaptation {
    /// The levels, coarse to fine, `[n_levels]`.
    pub levels: Vec<AdaptiveLevel>,
    /// How each level follows from the one before, one that is not done included.
    pub refinement: Refinement,
    /// Multipliers in Pa that each refined level starts from, one list for each level of the
    /// refinement.
    pub starts: Vec<Vec<f64>>,
}

/// Levels in a row that have to make the estimate smaller between them.
const PATIENCE: usize = 3;

/// Growth of the unknowns over which the estimate has to fall: that of a halving of all edges. It also rises where a level finds contact.
const GROWTH: usize = 8;

/// Growth of the unknowns over which an estimate larger than the solution has to fall: that of two halvings of all edges. It tells where
/// a coarse mesh misses contact, and does not fall before that is found, with far fewer unknowns.
const GROWTH_OF_SEARCH: usize = 64;

impl Adaptation {
    /// The first level that meets a target; none with an error as large as the solution does.
    #[must_use]
    pub fn level_that_meets(&self, target: f64) -> Option<usize> {
        let is_met = |error: f64| error <= target && error < 1.0;
        let meets = |l: &AdaptiveLevel| l.status.is_solved() && is_met(l.estimated_error);
        self.levels.iter().position(meets)
    }

    /// How the levels stand with a target; that nothing larger fits is for the caller to say.
    #[must_use]
    pub fn status(&self, target: f64) -> AdaptiveStatus {
        if self.level_that_meets(target).is_some() {
            return AdaptiveStatus::Met;
        }
        let Some(last) = self.levels.last() else {
            return AdaptiveStatus::Refining;
        };
        if !last.status.is_solved() || last.estimated_error.is_nan() {
            return AdaptiveStatus::NotConverged;
        }
        let before = self.levels.len().saturating_sub(PATIENCE);
        let searches = last.estimated_error >= 1.0;
        let growth = if searches { GROWTH_OF_SEARCH } else { GROWTH };
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

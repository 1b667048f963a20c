use std::fmt;

use super::problem::{Problem, difference};
use crate::{
    accuracy::AccuracyError,
    scene::{InnerSolver, Method, PrecisionControl, SolveSettings},
    solver::{Linearisation, Solution, Status},
};

/// Accuracy asked of all.
const TO_ROUNDING: f64 = 1e-12;

/// Actions of S that GPCG may take in one inner problem; a solve that needs more is told as such.
const MOST_ACTIONS: usize = 100_000;

/// An algorithm that shares with the others only S and h.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rival {
    /// The semismooth Newton method for slip bound and friction at once.
    Newton,
    /// Successive approximations with Newton's method inside; one minimisation without Coulomb's
    /// law.
    FixedPointNewton,
    /// The same with GPCG inside.
    FixedPointGpcg,
}

impl Rival {
    /// All rivals.
    pub const ALL: [Self; 3] = [Self::Newton, Self::FixedPointNewton, Self::FixedPointGpcg];

    fn settings(self) -> SolveSettings {
        let (method, inner) = match self {
            Self::Newton => (Method::Newton, InnerSolver::default()),
            Self::FixedPointNewton => (Method::FixedPoint, InnerSolver::Newton),
            Self::FixedPointGpcg => (Method::FixedPoint, InnerSolver::Gpcg),
        };
        SolveSettings {
            method,
            inner,
            epsilon: Some(TO_ROUNDING),
            precision: PrecisionControl::Fixed,
            max_inner_actions: MOST_ACTIONS,
            ..SolveSettings::default()
        }
    }
}

impl fmt::Display for Rival {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Newton => "Newton",
            Self::FixedPointNewton => "fixed point with Newton",
            Self::FixedPointGpcg => "fixed point with GPCG",
        })
    }
}

/// What a rival found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RivalResult {
    /// The algorithm.
    pub rival: Rival,
    /// How it ended.
    pub status: Status,
    /// Steps of Newton's method, or of successive approximations.
    pub steps: usize,
    /// ‖λ − λ*‖ / ‖λ*‖ for the answer λ* of the program.
    pub disagreement: f64,
    /// ‖R(λ)‖ / ‖λ‖ of the natural map, the same yardstick for all.
    pub residual: f64,
}

impl RivalResult {
    /// Whether the algorithm says that it has found a solution.
    #[must_use]
    pub fn is_solution(&self) -> bool {
        matches!(self.status, Status::Converged | Status::RoundingLimit)
    }
}

/// Solves by every rival.
pub(super) fn compare(
    problem: &Problem,
    answer: &Solution,
) -> Result<Vec<RivalResult>, AccuracyError> {
    let run = |rival: Rival| {
        let solution = problem.solve(&rival.settings())?;
        let contact = problem.contact();
        let residual = Linearisation::residual_of(problem.dual(), &contact, &solution.multiplier);
        Ok(RivalResult {
            rival,
            status: solution.status,
            steps: solution.newton.len().max(solution.history.len()),
            disagreement: difference(&solution.multiplier, &answer.multiplier),
            residual,
        })
    };
    Rival::ALL.into_iter().map(run).collect()
}

//! What a measured error makes of a solution: the one place where the status of a solve is decided.
//!
//! Each method stops by a rule of its own, and says why ([`StopReason`]). The error of λ is then measured by one more solve with refined
//! residuals ([`super::accuracy`]), and the residuals of the report are held against it ([`crate::post::ContactReport::classify`]). An
//! error is relative: 1 means that no digit is known.
//!
//! | status | of |
//! |---|---|
//! | `Converged`, `MachinePrecision` | a refined solution ([`Assessment::of_refined`]), a method that kept its promise ([`Assessment::of_method`]) |
//! | `ReducedAccuracy` | a method that missed it by a measured error of at most 5 % |
//! | `Inaccurate` | a larger error, above 10⁻³ where Algorithm 4.1 is a strategy, a residual of the report that contradicts, or nothing measured yet |
//! | `MaxNewtonSteps` | strategies that led nowhere or kept more than 10⁻³ of error ([`Assessment::of_unsolved`]), or an inner problem of Algorithm 4.1 |
//! | `MaxOuterSteps`, `MaxOperatorApplications`, `Cycling` | Algorithm 4.1, as the method or as a strategy, or a minimisation |
//! | `NumericalError` | a number out of range, of the method (as a strategy it is `MaxNewtonSteps`), the solution or the report |
//! | `NoEquilibrium` | a mechanism ([`Assessment::of_mechanism`]) |

use super::{
    MethodResult, PaneLaws, Solution, Status, StopReason, Trace, tolerances::REFINEMENT_TARGET,
};

/// A method that stops by its own rule keeps its promise with an error of at most this many times ε: its rule measures steps, and at a
/// contraction of 0.9 the distance to the solution is nine times the last step.
const ACCEPT_FACTOR: f64 = 10.0;

/// A solution with a larger relative error than 5 % has no digit to rely on: it is none.
const MAX_ERROR: f64 = 0.05;

/// A status with the accuracy that belongs to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Assessment {
    pub(crate) status: Status,
    pub(crate) accuracy: f64,
}

impl Assessment {
    /// Of a refined solution with a measured error, where ε was asked for and rounding forbids less than `attainable`.
    pub(in crate::solver) fn of_refined(error: f64, epsilon: f64, attainable: f64) -> Self {
        if error <= epsilon && epsilon >= attainable {
            return Self {
                status: Status::Converged,
                accuracy: error,
            };
        }
        Self {
            status: Status::MachinePrecision,
            accuracy: error.max(attainable),
        }
    }

    /// Of what came nearest to a solution, where no strategy led to one; how Algorithm 4.1 stopped says more than that
    /// Newton's method found nothing.
    pub(in crate::solver) fn of_unsolved(error: f64, approximations: Option<StopReason>) -> Self {
        Self {
            status: match approximations {
                // It may leave the range of numbers where Newton's method only finds nothing.
                None | Some(StopReason::NumericalError) => Status::MaxNewtonSteps,
                Some(stop) if stop.is_solution() => Status::Inaccurate,
                Some(stop) => Self::status_of(stop),
            },
            accuracy: error.min(1.0),
        }
    }

    /// Of what a method found by its own rule, with a measured error: `converged` stays only where that is about ε.
    pub(in crate::solver) fn of_method(found: &MethodResult, error: f64, epsilon: f64) -> Self {
        let own = Self::status_of(found.stop);
        if !own.is_solved() {
            return Self {
                status: own,
                accuracy: found.measure,
            };
        }
        let error = if error <= 1.0 { error } else { 1.0 };
        let status = match own {
            _ if error > MAX_ERROR => Status::Inaccurate,
            Status::Converged if error > ACCEPT_FACTOR * epsilon => Status::ReducedAccuracy,
            Status::MachinePrecision if error > REFINEMENT_TARGET => Status::ReducedAccuracy,
            status => status,
        };
        let accuracy = match status {
            Status::MachinePrecision => error.max(found.measure),
            _ => error,
        };
        Self { status, accuracy }
    }

    /// Of u = A⁻¹l, which has no contact stresses to measure.
    pub(in crate::solver) fn of_direct() -> Self {
        Self {
            status: Status::Converged,
            accuracy: 0.0,
        }
    }

    /// Of a body for which a mechanism proves that there is no equilibrium.
    pub(in crate::solver) fn of_mechanism() -> Self {
        Self::unknown(Status::NoEquilibrium)
    }

    /// Of something that nobody has measured, or of no solution: no digit is known.
    pub(crate) fn unknown(status: Status) -> Self {
        Self {
            status,
            accuracy: 1.0,
        }
    }

    /// The status of a method whose rule is all that is known.
    fn status_of(stop: StopReason) -> Status {
        match stop {
            StopReason::Converged => Status::Converged,
            StopReason::RoundingLimit => Status::MachinePrecision,
            StopReason::MaxSteps => Status::MaxNewtonSteps,
            StopReason::MaxOuterSteps => Status::MaxOuterSteps,
            StopReason::MaxOperatorApplications => Status::MaxOperatorApplications,
            StopReason::Cycling => Status::Cycling,
            StopReason::NumericalError => Status::NumericalError,
        }
    }

    /// Where a number is not finite, or out of the range in which double precision can compute.
    pub(crate) fn out_of_range(self) -> Self {
        Self {
            status: Status::NumericalError,
            ..self
        }
    }

    /// Where a residual of the report may contradict the accuracy, and is so large that there is no solution or not.
    pub(crate) fn with_residual(self, value: f64, is_broken: bool) -> Self {
        if !self.status.is_solved() {
            return self;
        }
        Self {
            status: match self.status {
                _ if is_broken => Status::Inaccurate,
                Status::Converged => Status::MachinePrecision,
                status => status,
            },
            accuracy: self.accuracy.max(value).min(1.0),
        }
    }

    /// A solution with this assessment.
    pub(crate) fn solution(
        self,
        multiplier: Vec<f64>,
        displacement: Vec<f64>,
        trace: Trace,
    ) -> Solution {
        Solution {
            status: self.status,
            accuracy: self.accuracy,
            multiplier,
            displacement,
            rigid: None,
            friction: None,
            trace,
        }
    }
}

impl Solution {
    /// A solution that nobody has assessed: it claims nothing.
    pub(crate) fn unassessed(multiplier: Vec<f64>, displacement: Vec<f64>, trace: Trace) -> Self {
        Assessment::unknown(Status::default()).solution(multiplier, displacement, trace)
    }

    /// Gives the solution an assessment.
    pub(crate) fn assess(&mut self, Assessment { status, accuracy }: Assessment) {
        (self.status, self.accuracy) = (status, accuracy);
    }

    /// What the solution claims.
    pub(crate) fn assessment(&self) -> Assessment {
        Assessment {
            status: self.status,
            accuracy: self.accuracy,
        }
    }
}

/// Whether a body was moved further than so many times the width of its contact faces: further than once, nothing of what
/// failed is worth showing; 1/√ε_M times, gaps and slips, differences of places, have less than half of their digits.
pub(in crate::solver) fn is_far(displacement: &[f64], laws: &PaneLaws, widths: f64) -> bool {
    let width = laws.area.iter().sum::<f64>().sqrt();
    !displacement.iter().all(|u| u.abs() <= widths * width)
}

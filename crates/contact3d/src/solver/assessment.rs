//! What a measured error makes of a solution: the one place where the status of a solve is decided.
//!
//! Each method ends by a rule of its own, and says how ([`Ending`]). The error of λ is then measured by one more solve with exact
//! residuals ([`super::accuracy`]), and the residuals of the report are held against it ([`crate::post::ContactReport::assess`]). An
//! error is relative: 1 means that no digit is known.

use super::{PaneLaws, Solution, Status};

/// A method that stops by its own rule keeps its promise with an error of at most this many times ε.
const ACCEPT_FACTOR: f64 = 10.0;

/// A solution with a larger error has no digit to rely on: it is none.
const MAX_ERROR: f64 = 0.05;

/// The largest error of a refined solution: above, its contact zones are not known.
pub(in crate::solver) const REFINEMENT_TARGET: f64 = 1e-3;

/// What a solve may know of its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::solver) struct Ending {
    /// How the method ended by its own rule.
    pub(in crate::solver) by_rule: Status,
    /// What its rule measures: the last change of successive approximations, or a residual.
    pub(in crate::solver) measure: f64,
}

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

    /// Of what came nearest to a solution, where no strategy led to one.
    pub(in crate::solver) fn of_no_solution(error: f64) -> Self {
        Self {
            status: Status::MaxNewtonSteps,
            accuracy: error.min(1.0),
        }
    }

    /// Of what a method found by its own rule, with a measured error: `converged` stays only where that is about ε.
    pub(in crate::solver) fn of_measured(ending: Ending, error: f64, epsilon: f64) -> Self {
        let error = if error <= 1.0 { error } else { 1.0 };
        let status = match ending.by_rule {
            status if !status.is_solved() => {
                return Self {
                    status,
                    accuracy: ending.measure,
                };
            }
            _ if error > MAX_ERROR => Status::Inaccurate,
            Status::Converged if error > ACCEPT_FACTOR * epsilon => Status::ReducedAccuracy,
            Status::MachinePrecision if error > REFINEMENT_TARGET => Status::ReducedAccuracy,
            status => status,
        };
        Self {
            status,
            accuracy: match status {
                Status::MachinePrecision => error.max(ending.measure),
                _ => error,
            },
        }
    }

    /// Of successive approximations that met their rule without a solution nearby.
    pub(in crate::solver) fn of_lost_fixed_point(ending: Ending, error: f64) -> Self {
        if ending.by_rule.is_solved() {
            Self {
                status: Status::Inaccurate,
                accuracy: error.min(1.0),
            }
        } else {
            Self {
                status: ending.by_rule,
                accuracy: ending.measure,
            }
        }
    }

    /// With a residual of the report that contradicts the accuracy, so large that there is no solution or not.
    pub(crate) fn contradicted_by(self, residual: f64, is_broken: bool) -> Self {
        if !self.status.is_solved() {
            return self;
        }
        Self {
            status: match self.status {
                _ if is_broken => Status::Inaccurate,
                Status::Converged => Status::MachinePrecision,
                status => status,
            },
            accuracy: self.accuracy.max(residual).min(1.0),
        }
    }

    /// With a number that is not finite, or out of the range in which double precision can compute.
    pub(crate) fn out_of_range(self) -> Self {
        Self {
            status: Status::NumericalError,
            ..self
        }
    }
}

impl Solution {
    /// How the solve ended by its own rule.
    pub(in crate::solver) fn ending(&self) -> Ending {
        Ending {
            by_rule: self.status,
            measure: self.accuracy,
        }
    }

    /// The solution with its status.
    pub(in crate::solver) fn assessed(self, assessment: Assessment) -> Self {
        Self {
            status: assessment.status,
            accuracy: assessment.accuracy,
            ..self
        }
    }

    /// What the solution claims.
    pub(crate) fn assessment(&self) -> Assessment {
        Assessment {
            status: self.status,
            accuracy: self.accuracy,
        }
    }
}

/// Whether a body that floats was moved further than its contact faces are wide, as Newton's method does where no contact forces
/// stop it: nothing of that is a solution.
pub(in crate::solver) fn has_diverged(displacement: &[f64], laws: &PaneLaws) -> bool {
    let width = laws.area.iter().sum::<f64>().sqrt();
    !displacement.iter().all(|u| u.abs() <= width)
}

/// Whether a body was moved so far that gaps and slips, differences of places, have less than half of their digits.
pub(in crate::solver) fn has_lost_its_gaps(displacement: &[f64], laws: &PaneLaws) -> bool {
    let reach = laws.area.iter().sum::<f64>().sqrt() / f64::EPSILON.sqrt();
    !displacement.iter().all(|u| u.abs() <= reach)
}

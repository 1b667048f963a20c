//! What a measured error makes of a solution: the one place where the status of a solve is decided.
//!
//! Each method stops by a rule of its own, and says why ([`StopReason`]). The error of λ is then measured by one more solve with refined
//! residuals ([`super::accuracy`]), and the residuals of the report are held against it ([`crate::post::ContactReport::assess`]). An
//! error is relative: 1 means that no digit is known.

use super::{MethodResult, PaneLaws, Solution, Status, StopReason};

/// A method that stops by its own rule keeps its promise with an error of at most this many times ε.
const ACCEPT_FACTOR: f64 = 10.0;

/// A solution with a larger error has no digit to rely on: it is none.
const MAX_ERROR: f64 = 0.05;

/// The largest error of a refined solution: above, its contact zones are not known.
pub(in crate::solver) const REFINEMENT_TARGET: f64 = 1e-3;

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
    pub(in crate::solver) fn of_method(found: &MethodResult, error: f64, epsilon: f64) -> Self {
        let own = Self::by_rule(found);
        if !own.status.is_solved() {
            return own;
        }
        let error = if error <= 1.0 { error } else { 1.0 };
        let status = match own.status {
            _ if error > MAX_ERROR => Status::Inaccurate,
            Status::Converged if error > ACCEPT_FACTOR * epsilon => Status::ReducedAccuracy,
            Status::MachinePrecision if error > REFINEMENT_TARGET => Status::ReducedAccuracy,
            status => status,
        };
        let accuracy = match status {
            Status::MachinePrecision => error.max(own.accuracy),
            _ => error,
        };
        Self { status, accuracy }
    }

    /// Of successive approximations without a solution nearby, whether they met their rule or not.
    pub(in crate::solver) fn of_lost_fixed_point(found: &MethodResult, error: f64) -> Self {
        if !found.stop.is_solution() {
            return Self::by_rule(found);
        }
        Self {
            status: Status::Inaccurate,
            accuracy: error.min(1.0),
        }
    }

    /// Of a method whose error is not known.
    pub(in crate::solver) fn by_rule(found: &MethodResult) -> Self {
        Self {
            status: match found.stop {
                StopReason::Converged => Status::Converged,
                StopReason::RoundingLimit => Status::MachinePrecision,
                StopReason::MaxSteps => Status::MaxNewtonSteps,
                StopReason::MaxOuterSteps => Status::MaxOuterSteps,
                StopReason::MaxOperatorApplications => Status::MaxOperatorApplications,
                StopReason::Cycling => Status::Cycling,
                StopReason::NumericalError => Status::NumericalError,
            },
            accuracy: found.measure,
        }
    }

    /// Of a body that a rigid-body motion proves a mechanism.
    pub(in crate::solver) fn of_mechanism() -> Self {
        Self {
            status: Status::NoEquilibrium,
            accuracy: 1.0,
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
    /// The solution with its status.
    pub(crate) fn assessed(self, assessment: Assessment) -> Self {
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

/// Whether a body was moved further than so many times the width of its contact faces: further than once, nothing of that is a solution;
/// 1/√ε times, gaps and slips, differences of places, have less than half of their digits.
pub(in crate::solver) fn is_far(displacement: &[f64], laws: &PaneLaws, widths: f64) -> bool {
    let width = laws.area.iter().sum::<f64>().sqrt();
    !displacement.iter().all(|u| u.abs() <= widths * width)
}

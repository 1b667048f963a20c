//! One minimisation: frictionless contact and Tresca's law.

use std::time::Instant;

use super::{
    Inner, Kprgp, MethodResult, OuterStep, PaneLaws, Solution, SolvedBy, StopReason, Trace,
    inner::projected_gradient_steplength, tolerances::rounding_of_products,
};
use crate::{dual::BodyOperator, scene::SolveSettings};

/// Solves frictionless contact, or friction with a given slip bound: one minimisation of
/// ½ λᵀSλ − λᵀh over a fixed admissible set, to the accuracy r_tol ε of an inner problem.
pub(super) fn minimise(
    inner: Inner<'_>,
    operator: &mut BodyOperator<'_, '_>,
    laws: &PaneLaws,
    settings: &SolveSettings,
    start: Option<&[f64]>,
    mut observe: impl FnMut(usize, &OuterStep),
) -> MethodResult {
    let started = Instant::now();
    let kprgp = Kprgp {
        steplength: projected_gradient_steplength(operator.as_dual()),
        gamma: settings.gamma,
        max_applications: settings.max_operator_applications,
    };
    let dimension = laws.layout.n_multipliers();
    let mut multiplier = start.map_or_else(|| vec![0.0; dimension], <[f64]>::to_vec);
    let tolerance = settings.r_tol * settings.epsilon();
    let set = laws.feasible_set(None);
    let summary = inner.minimise(operator, &kprgp, &set, &mut multiplier, tolerance);
    // The rounding of S λ, below which no residual says anything.
    let attainable = rounding_of_products(dimension);
    let displacement = operator.as_primal().to_primal(&multiplier);
    let step = OuterStep {
        change: 0.0,
        inner_tolerance: tolerance,
        inner_residual: summary.residual,
        steps: summary.steps,
        applications: operator.as_dual().applications() + summary.applications,
        seconds: started.elapsed().as_secs_f64(),
    };
    observe(0, &step);
    let trace = Trace {
        solved_by: SolvedBy::Minimisation,
        steplength: kprgp.steplength,
        applications: step.applications,
        history: vec![step],
        newton: summary.newton,
        ..Trace::default()
    };
    MethodResult {
        stop: match summary.failure {
            _ if !summary.residual.is_finite() => StopReason::NumericalError,
            None if summary.residual.max(attainable) > settings.epsilon() => {
                StopReason::RoundingLimit
            }
            None => StopReason::Converged,
            Some(failure) => failure,
        },
        measure: summary.residual,
        solution: Solution::unassessed(multiplier, displacement, trace),
    }
}

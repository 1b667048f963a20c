use super::{
    FeasibleSet, Gpcg, InnerOutcome, Kprgp, NewtonSettings, NewtonStatus, NewtonStep, StepCounts,
    minimise_frozen,
};
use crate::{
    dual::{DualOperator, ExplicitDual},
    linalg::norm,
};

/// What solves the problems with a frozen admissible set.
#[derive(Debug, Clone, Copy)]
pub enum Inner<'a> {
    /// KPRGP, as in the paper.
    Kprgp,
    /// GPCG, which moves along the ellipses' boundaries too.
    Gpcg,
    /// Newton's method on the dense dual problem, which reaches rounding in a few steps.
    Newton(&'a ExplicitDual),
}

/// What an inner solver did.
pub(super) struct InnerSummary {
    pub(super) converged: bool,
    /// Final residual, relative as the tolerance is.
    pub(super) residual: f64,
    pub(super) steps: StepCounts,
    /// Whether rounding forbids a smaller residual.
    pub(super) at_rounding: bool,
    /// Actions of S that the operator did not count.
    pub(super) actions: usize,
    /// Steps of Newton's method.
    pub(super) newton: Vec<NewtonStep>,
}

impl Inner<'_> {
    /// Improves a multiplier on a frozen admissible set to a tolerance relative to ‖h‖ for KPRGP
    /// and GPCG, and to ‖λ‖ for Newton's method.
    pub(super) fn minimise(
        self,
        operator: &mut dyn DualOperator,
        kprgp: &Kprgp,
        set: &FeasibleSet<'_>,
        multiplier: &mut Vec<f64>,
        tolerance: f64,
    ) -> InnerSummary {
        match self {
            Self::Kprgp | Self::Gpcg => {
                let rhs_norm = norm(operator.rhs());
                set.project(multiplier);
                // The rounding n ε (‖S‖ ‖λ‖ + ‖h‖) of r = S λ − h with ‖S‖ < 2/ᾱ.
                let size = 2.0 / kprgp.steplength * norm(multiplier) + rhs_norm;
                let rounding = operator.dimension() as f64 * f64::EPSILON * size;
                let asked = tolerance * rhs_norm;
                let reachable = asked.max(rounding);
                let InnerOutcome {
                    converged,
                    reduced_gradient,
                    steps,
                } = match self {
                    Self::Gpcg => Gpcg {
                        steplength: kprgp.steplength,
                        max_actions: kprgp.max_actions,
                    }
                    .minimise(operator, set, multiplier, reachable),
                    _ => kprgp.minimise(operator, set, multiplier, reachable),
                };
                let relative = reduced_gradient / rhs_norm;
                InnerSummary {
                    converged,
                    residual: if rhs_norm > 0.0 { relative } else { 0.0 },
                    steps,
                    at_rounding: asked < rounding,
                    actions: 0,
                    newton: Vec::new(),
                }
            }
            Self::Newton(dual) => {
                let settings = NewtonSettings {
                    tolerance: tolerance.max(dual.rounding()),
                    ..NewtonSettings::default()
                };
                let outcome = minimise_frozen(dual, set, multiplier, &settings);
                *multiplier = outcome.multiplier;
                InnerSummary {
                    converged: matches!(
                        outcome.status,
                        NewtonStatus::Converged | NewtonStatus::RoundingLimit
                    ),
                    residual: outcome.residual,
                    steps: StepCounts::default(),
                    at_rounding: outcome.status == NewtonStatus::RoundingLimit
                        || outcome.residual <= dual.rounding(),
                    actions: outcome.evaluations,
                    newton: outcome.history,
                }
            }
        }
    }
}

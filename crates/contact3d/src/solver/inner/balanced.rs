//! Minimisation for a body that floats, under the condition that contact forces balance the load.

use super::{Inner, InnerSummary, Kprgp};
use crate::{
    dual::{BalancedOperator, DualOperator},
    solver::{FeasibleSet, StopReason, tolerances::rounding_of_products},
};

/// Most steps of the method of multipliers.
const BALANCE_MAX_STEPS: usize = 200;

/// What an inner minimisation may leave, as a share of the imbalance before it: imbalance and residual fall together.
const BALANCE_REDUCTION: f64 = 0.1;

impl Inner<'_> {
    /// Minimises ½ λᵀSλ − λᵀh under Gᵀλ = e by the method of multipliers (SMALSE-M: Z. Dostál, *Optimal Quadratic Programming
    /// Algorithms*, Springer 2009, ch. 8, with a constant penalty).
    ///
    /// What is minimised each time is the augmented Lagrangian of [`crate::dual::BalancedOperator`], as accurately as the balance
    /// is met.
    pub(super) fn minimise_balanced(
        self,
        operator: &mut BalancedOperator<'_>,
        kprgp: &Kprgp,
        set: &FeasibleSet,
        multiplier: &mut [f64],
        tolerance: f64,
    ) -> InnerSummary {
        let attainable = rounding_of_products(operator.dimension());
        let first_application = operator.applications();
        // The first step shall find the zones, no more.
        let mut imbalance = 1e-2_f64;
        let mut total: Option<InnerSummary> = None;
        for _ in 0..BALANCE_MAX_STEPS {
            let used = operator.applications() - first_application;
            let left = Kprgp {
                max_applications: kprgp.max_applications.saturating_sub(used),
                ..*kprgp
            };
            // A residual within the tolerance leaves an imbalance of the same size, give or take a factor.
            let asked = BALANCE_REDUCTION * imbalance.max(tolerance);
            let mut summary = self.minimise_at(operator, &left, set, multiplier, asked);
            if let Some(before) = &total {
                summary.steps += before.steps;
            }
            let next = operator.balance().relative_equilibrium_residual(multiplier);
            summary.residual = summary.residual.max(next);
            let done = next <= tolerance.max(attainable) && asked <= tolerance;
            if done || summary.failure.is_some() || !next.is_finite() {
                return summary;
            }
            operator.rebalance(multiplier);
            imbalance = next;
            total = Some(summary);
        }
        let mut summary = total.expect("one step at least");
        summary.failure = Some(StopReason::MaxOperatorApplications);
        summary
    }
}

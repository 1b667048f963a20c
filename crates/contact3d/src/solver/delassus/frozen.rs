//! Successive approximations of the slip bounds on the matrix as it is.

use std::sync::atomic::AtomicUsize;

use super::{
    Found,
    scaled::{Scaled, SparseOperator, relative_change},
};
use crate::{
    dual::DualOperator,
    linalg::norm,
    solver::{FeasibleSet, Gpcg, inner::projected_gradient_steplength},
};

/// Most outer steps, and most products with W altogether.
const MOST_STEPS: usize = 1000;
const MOST_APPLICATIONS: usize = 400_000;

/// Loosest and tightest tolerance of an inner problem, relative to ‖h‖, and its share of the last error.
const LOOSEST: f64 = 1e-2;
const TIGHTEST: f64 = 1e-14;
const SHARE: f64 = 0.1;

/// Outer steps in which the error must halve.
const PATIENCE: usize = 100;

/// Minimises ½ λᵀSλ − λᵀh over λ_N ≥ 0 and ‖λ_T‖ ≤ g with GPCG for the slip bounds g = λ_N of the last minimiser, again and again
/// (HKL Algorithm 4.1 at constant F). Each of these problems is convex, so a singular W needs nothing else; whether their sequence
/// converges depends on μ.
pub(super) fn solve(scaled: &Scaled<'_>, tolerance: f64) -> Found {
    let size = norm(&scaled.rhs);
    if size == 0.0 {
        return Found::zero(scaled);
    }
    let mut operator = SparseOperator::new(scaled);
    let projections = AtomicUsize::new(0);
    let steplength = projected_gradient_steplength(&mut operator);
    let mut multiplier = vec![0.0; scaled.rhs.len()];
    let mut best = (f64::INFINITY, multiplier.clone());
    let mut errors: Vec<f64> = Vec::new();
    let mut inner_tolerance = LOOSEST;
    let mut outer_steps = 0;
    while outer_steps < MOST_STEPS {
        let left = MOST_APPLICATIONS.saturating_sub(operator.applications());
        if left == 0 {
            break;
        }
        let (normal, _) = scaled.layout.split(&multiplier);
        let bounds = normal.iter().take(scaled.layout.n_pairs());
        let set = FeasibleSet::new(
            scaled.layout.n_panes(),
            bounds.map(|g| [*g; 2]).collect(),
            &projections,
        );
        let mut next = multiplier.clone();
        set.project(&mut next);
        let gpcg = Gpcg {
            steplength,
            max_applications: left,
        };
        // The rounding n ε (‖S‖ ‖λ‖ + ‖h‖) of r = S λ − h with ‖S‖ < 2/ᾱ.
        let rounding =
            scaled.rhs.len() as f64 * f64::EPSILON * (2.0 / steplength * norm(&next) + size);
        gpcg.minimise(
            &mut operator,
            &set,
            &mut next,
            rounding.max(inner_tolerance * size),
        );
        let change = relative_change(&next, &multiplier);
        multiplier = next;
        outer_steps += 1;
        let error = scaled.worst_error(&multiplier);
        if error < best.0 {
            best = (error, multiplier.clone());
        }
        if error <= tolerance || !error.is_finite() {
            break;
        }
        errors.push(best.0);
        let stalled = errors.len() > PATIENCE
            && errors[errors.len() - 1] > 0.5 * errors[errors.len() - 1 - PATIENCE];
        if stalled || (change == 0.0 && inner_tolerance * size <= rounding) {
            break;
        }
        let wanted = SHARE * error.min(change.max(SHARE * error));
        inner_tolerance = wanted.clamp(TIGHTEST, inner_tolerance);
    }
    Found {
        multiplier: best.1,
        newton_steps: 0,
        outer_steps,
        applications: operator.applications(),
    }
}

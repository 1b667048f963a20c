//! Tolerances and limits that several methods share.

/// ‖R‖ / ‖λ‖ at which the zones are found, about √ε_M: a step that squares it is at rounding. Iterative refinement does the rest.
pub(super) const ZONES_TOLERANCE: f64 = 1e-8;

/// The largest relative error of a refined solution: with fewer than three digits of λ, rounding decides about zones, and another start may
/// find better ones.
pub(super) const REFINEMENT_TARGET: f64 = 1e-3;

/// Most steps of Newton's method of the friction graph, of proximal steps and of refinement: of the friction graph those that lead to a solution take a median of 13, refinement one or
/// two, more where the refined residual moves panes between zones.
pub(super) const NEWTON_MAX_STEPS: usize = 40;

/// Most steps of loops that end by a rule of their own: no problem of the campaigns took more than 60.
pub(super) const LOOP_MAX_STEPS: usize = 100;

/// Steps in which the best residual must halve; otherwise Newton's method has stalled, and would win one digit in [`NEWTON_MAX_STEPS`].
pub(super) const STAGNATION_STEPS: usize = 10;

/// Steps without a halved residual that count as rounding, where rounding explains what is left; one fewer where every residual is refined,
/// or a refined residual is measured next.
pub(super) const ROUNDING_STALL_STEPS: usize = 3;

/// Share of the residual that the linear system for an error or an adjoint may leave: estimated errors are good to a tenth at best.
pub(super) const GMRES_TOLERANCE: f64 = 1e-4;

/// Most applications of A⁻¹ for that, as GMRES keeps a vector of each: 0.24 GB with 100,000 multipliers.
pub(super) const GMRES_MAX_APPLICATIONS: usize = 300;

/// u is wanted with this share of rounding, so that the face's own displacement is left where the
/// rigid motion is large.
pub(super) const DISPLACEMENT_TOLERANCE: f64 = 1e-4 * f64::EPSILON;

/// The relative rounding error n ε_M of S λ with n multipliers, below which no residual is worth reducing.
pub(super) fn rounding_of_products(n: usize) -> f64 {
    n as f64 * f64::EPSILON
}

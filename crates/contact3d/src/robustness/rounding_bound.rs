//! What rounding alone makes of the certificate and the multipliers, from measured condition numbers.

use super::{Conditioning, explicit_problem::ExplicitProblem};
use crate::{
    linalg::dot,
    post::ContactReport,
    solver::{Linearisation, Solution},
};

/// Roundings of a sum of some hundred terms add up to about this many, as the root of their number.
const ROUNDINGS: f64 = 16.0;

/// What double precision allows for one problem, known from its conditioning alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundingBound {
    /// Relative error of λ that rounding of A, S and h alone makes: with the backward error
    /// 16 ε of a factorisation, S and h are those of another A within 16 ε κ(A) of their own size, and
    /// ‖R'⁻¹‖ carries that to λ: 16 ε (κ(A) + n) ‖ρS‖ ‖R'⁻¹‖.
    pub multiplier: f64,
    /// Size of the certificate's figures at the best double λ and u: 16 ε times the largest of the
    /// cancellation ‖|A||u| + |Bᵀ||λ| + |l|‖ / ‖l‖ in the equilibrium, and of what rounding of λ and u
    /// moves the panes, |S||λ| + |R| max |u|, as a stress over the largest by local stiffness, and as a
    /// work over Σ λ²/ρ.
    pub certificate: f64,
}

impl RoundingBound {
    pub(super) fn of(
        problem: &ExplicitProblem,
        solution: &Solution,
        report: &ContactReport,
        conditioning: &Conditioning,
        linearisation: &Linearisation,
    ) -> Self {
        let n = solution.multiplier.len() as f64;
        let of_matrices = (conditioning.stiffness + n) * conditioning.dual_by_diagonal;
        let dual = problem.dual();
        let size = |x: &[f64]| -> Vec<f64> { x.iter().map(|v| v.abs()).collect() };
        let sizes = size(&solution.multiplier);
        let moved: Vec<f64> = (0..sizes.len())
            .map(|j| dot(&size(dual.column(j)), &sizes))
            .collect();
        let rounding = problem.assembled.rounding_of(solution, report, &moved);
        Self {
            multiplier: ROUNDINGS * f64::EPSILON * of_matrices * linearisation.sensitivity,
            certificate: rounding.worst(),
        }
    }
}

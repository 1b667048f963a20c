//! What rounding alone makes of the certificate and the multipliers, from measured condition numbers.

use super::{Conditioning, explicit_problem::ExplicitProblem};
use crate::{
    linalg::{dot, norm},
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
        let [equilibrium, displacement, work] = amplifications(problem, solution, report);
        let largest = equilibrium.max(displacement).max(work);
        Self {
            multiplier: ROUNDINGS * f64::EPSILON * of_matrices * linearisation.sensitivity,
            certificate: ROUNDINGS * f64::EPSILON * largest,
        }
    }
}

/// How much larger the terms are than what they are measured against: in the equilibrium, in the
/// displacement of the contact face, in the work of the contact stresses; 0 where nothing is loaded.
fn amplifications(
    problem: &ExplicitProblem,
    solution: &Solution,
    report: &ContactReport,
) -> [f64; 3] {
    let primal = &problem.assembled.system().assembly.primal;
    let size = |x: &[f64]| -> Vec<f64> { x.iter().map(|v| v.abs()).collect() };
    let (u, lambda, load) = (
        size(&solution.displacement),
        size(&solution.multiplier),
        size(&primal.load),
    );
    let mut forces = load.clone();
    for (matrix, x) in [
        (Some(&*primal.stiffness), &u),
        (
            problem
                .assembled
                .system()
                .contact
                .as_ref()
                .map(|c| &c.coupling.transposed),
            &lambda,
        ),
    ] {
        let Some(matrix) = matrix else { continue };
        for (j, x) in x.iter().enumerate() {
            for k in matrix.indptr[j]..matrix.indptr[j + 1] {
                forces[matrix.indices[k]] += matrix.data[k].abs() * x;
            }
        }
    }
    let dual = problem.dual();
    let moved: Vec<f64> = (0..lambda.len())
        .map(|j| dot(&size(dual.column(j)), &lambda))
        .collect();
    let area = &problem.surface().pane_area;
    let layout = dual.layout;
    let largest = u.iter().copied().fold(0.0, f64::max);
    let stiffness = &solution.local_stiffness;
    let rounded = |j: usize| moved[j] + area[layout.pane_of(j)] * largest;
    let strength: Vec<f64> = (0..lambda.len())
        .map(|j| match layout.normals().contains(&j) {
            true => lambda[j],
            false => report.panes[layout.pane_of(j)]
                .friction
                .map_or(0.0, |f| f.semi_axes[0].max(f.semi_axes[1])),
        })
        .collect();
    let parts = [layout.normals(), layout.tangentials()];
    let by_stress = parts.clone().map(|part| {
        let pushed = part.clone().map(|j| stiffness[j] * rounded(j));
        let borne = part.map(|j| strength[j].max(lambda[j]));
        ratio(pushed.fold(0.0, f64::max), borne.fold(0.0, f64::max))
    });
    let by_work = parts.map(|part| {
        let loaded = part.filter(|&j| stiffness[j] > 0.0);
        let works = loaded.map(|j| [strength[j] * rounded(j), lambda[j].powi(2) / stiffness[j]]);
        let [rounding, own] = works.fold([0.0; 2], |sum, w| [sum[0] + w[0], sum[1] + w[1]]);
        ratio(rounding, own)
    });
    [
        ratio(norm(&forces), norm(&load)),
        by_stress[0].max(by_stress[1]),
        by_work[0].max(by_work[1]),
    ]
}

/// The quotient, and 0 for 0/0.
fn ratio(part: f64, whole: f64) -> f64 {
    if whole == 0.0 { 0.0 } else { part / whole }
}

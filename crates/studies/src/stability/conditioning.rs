//! Condition numbers of A and S, and what rounding makes of them.

use faer::{MatRef, Side};

use super::explicit_problem::ExplicitProblem;
use contact3d::{
    dual::ExplicitDual,
    linalg::{dot, largest_eigenvalue},
    post::ContactReport,
    solver::{Linearisation, Solution},
};

/// The extreme eigenvalues of a symmetric matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spectrum {
    /// λ_min.
    pub smallest: f64,
    /// λ_max.
    pub largest: f64,
}

impl Spectrum {
    /// λ_min / λ_max; positive when the matrix is positive definite.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.smallest / self.largest
    }
}

/// How well the matrices of a problem are conditioned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditioning {
    /// S, in m³/Pa. Multipliers whose displacement is held have empty rows and are left out.
    pub dual: Spectrum,
    /// M^{-1/2} S M^{-1/2} with the areas of the panes in M, in m/Pa: the eigenvalues of S over L²
    /// of the contact face, which change of area alone does not spread. (3.1) of HKL holds when the
    /// smaller one is positive.
    pub dual_by_area: Spectrum,
    /// Condition number of D^{-1/2} A D^{-1/2} with the diagonal D of A, dimensionless and the same
    /// in all units: Cholesky's method solves A u = f to the accuracy ε times this (J. W. Demmel,
    /// *Applied Numerical Linear Algebra*, SIAM 1997, theorem 2.9).
    pub stiffness: f64,
    /// Largest eigenvalue of S scaled to the diagonal 1, ‖ρS‖ of the natural map.
    pub dual_by_diagonal: f64,
}

impl Conditioning {
    pub(super) fn of(problem: &ExplicitProblem) -> Self {
        let dual = problem.dual();
        let area = &problem.surface().pane_area;
        let by_area = |j: usize| area[dual.layout.pane_of(j)].sqrt().recip();
        Self {
            dual: spectrum(dual, |_| 1.0),
            dual_by_area: spectrum(dual, by_area),
            stiffness: scaled_condition(problem),
            dual_by_diagonal: spectrum(dual, |j| dual.column(j)[j].sqrt().recip()).largest,
        }
    }
}

/// The eigenvalues of E S E for a diagonal E, without empty rows.
fn spectrum(dual: &ExplicitDual, scale: impl Fn(usize) -> f64) -> Spectrum {
    let moving: Vec<usize> = (0..dual.dimension())
        .filter(|&j| dual.column(j)[j] > 0.0)
        .collect();
    let n = moving.len();
    let factors: Vec<f64> = moving.iter().map(|&j| scale(j)).collect();
    // Eigenvalues below the range of doubles would vanish: the largest entry becomes 1.
    let entry = |i: usize, j: usize| factors[i] * dual.column(moving[j])[moving[i]] * factors[j];
    let size = (0..n).map(|i| entry(i, i)).fold(0.0, f64::max);
    let matrix: Vec<f64> = (0..n * n).map(|k| entry(k % n, k / n) / size).collect();
    let matrix = MatRef::from_column_major_slice(&matrix, n, n);
    let eigenvalues = matrix.self_adjoint_eigenvalues(Side::Lower);
    let eigenvalues = eigenvalues.unwrap_or_default();
    let at = |value: Option<&f64>| value.map_or(f64::NAN, |v| v * size);
    Spectrum {
        smallest: at(eigenvalues.first()),
        largest: at(eigenvalues.last()),
    }
}

/// The condition number of A scaled to the diagonal 1.
fn scaled_condition(problem: &ExplicitProblem) -> f64 {
    let assembly = &problem.assembled.system.assembly;
    let a = assembly.primal.invertible();
    let root: Vec<f64> = (0..a.cols).map(|j| a.diagonal(j).sqrt()).collect();
    let n = root.len();
    let largest = largest_eigenvalue(n, |v| {
        let scaled: Vec<f64> = v.iter().zip(&root).map(|(v, d)| v / d).collect();
        let mut product = vec![0.0; n];
        a.mul(&scaled, &mut product);
        product.iter().zip(&root).map(|(v, d)| v / d).collect()
    });
    let inverse = largest_eigenvalue(n, |v| {
        let scaled: Vec<f64> = v.iter().zip(&root).map(|(v, d)| v * d).collect();
        let solved = assembly.solve(&scaled);
        solved.iter().zip(&root).map(|(v, d)| v * d).collect()
    });
    largest * inverse
}

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
            // Roundings of a sum of some hundred terms add up to about this many, as the root of their number.
            multiplier: 16.0 * f64::EPSILON * of_matrices * linearisation.sensitivity,
            certificate: rounding.worst(),
        }
    }
}

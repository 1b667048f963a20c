//! Dense symmetric matrices of the contact face: factors, roots and extreme eigenvalues, on one thread so that their bits
//! do not depend on how many there are.

use std::sync::OnceLock;

use faer::{Mat, Side, linalg::solvers::Llt, prelude::Solve};
use rayon::ThreadPool;

/// Runs dense algebra on one thread.
pub(super) fn alone<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    static POOL: OnceLock<Option<ThreadPool>> = OnceLock::new();
    let build = || rayon::ThreadPoolBuilder::new().num_threads(1).build().ok();
    match POOL.get_or_init(build) {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// The eigenvalues of a symmetric matrix, increasing; empty where it is not finite.
pub(super) fn eigenvalues(matrix: &Mat<f64>) -> Vec<f64> {
    alone(|| matrix.self_adjoint_eigenvalues(Side::Lower)).unwrap_or_default()
}

/// The largest eigenvalue of a symmetric matrix; 0 for an empty one.
pub(super) fn largest(matrix: &Mat<f64>) -> f64 {
    if matrix.nrows() == 0 {
        return 0.0;
    }
    eigenvalues(matrix).last().copied().unwrap_or(f64::NAN)
}

/// A rectangular R with R Rᵀ = P for a positive semidefinite P, without the directions that rounding alone gives it.
pub(super) fn root(matrix: &Mat<f64>) -> Mat<f64> {
    let n = matrix.nrows();
    let Ok(eigen) = alone(|| matrix.self_adjoint_eigen(Side::Lower)) else {
        return Mat::full(n, n, f64::NAN);
    };
    let values = eigen.S().column_vector();
    let least = n as f64 * f64::EPSILON * values.iter().copied().fold(0.0, f64::max);
    let kept: Vec<usize> = (0..n).filter(|&j| values[j] > least).collect();
    Mat::from_fn(n, kept.len(), |i, j| {
        eigen.U()[(i, kept[j])] * values[kept[j]].sqrt()
    })
}

/// Rᵀ F R.
pub(super) fn congruent(root: &Mat<f64>, form: &Mat<f64>) -> Mat<f64> {
    symmetric(alone(|| root.transpose() * form * root))
}

/// (F + Fᵀ)/2, for what is symmetric but for rounding.
pub(super) fn symmetric(form: Mat<f64>) -> Mat<f64> {
    Mat::from_fn(form.nrows(), form.ncols(), |i, j| {
        0.5 * (form[(i, j)] + form[(j, i)])
    })
}

/// The Cholesky factor of a dense positive definite matrix.
pub(super) struct Factor(Llt<f64>);

impl Factor {
    /// `None` where the matrix is not positive definite in double precision.
    pub(super) fn new(matrix: &Mat<f64>) -> Option<Self> {
        alone(|| matrix.llt(Side::Lower)).ok().map(Self)
    }

    /// The solution of F X = B.
    pub(super) fn solve(&self, rhs: &Mat<f64>) -> Mat<f64> {
        alone(|| self.0.solve(rhs))
    }

    /// The largest eigenvalue of F⁻¹ G for a symmetric G: that of L⁻¹ G L⁻ᵀ.
    pub(super) fn largest_of(&self, form: &Mat<f64>) -> f64 {
        largest(&self.reduced(form))
    }

    /// The smallest one.
    pub(super) fn smallest_of(&self, form: &Mat<f64>) -> f64 {
        eigenvalues(&self.reduced(form))
            .first()
            .copied()
            .unwrap_or(f64::NAN)
    }

    /// L⁻¹ G L⁻ᵀ.
    fn reduced(&self, form: &Mat<f64>) -> Mat<f64> {
        alone(|| {
            let lower = self.0.L();
            let mut half = form.clone();
            lower.solve_lower_triangular_in_place(half.as_mut());
            let mut whole = half.transpose().to_owned();
            lower.solve_lower_triangular_in_place(whole.as_mut());
            symmetric(whole)
        })
    }
}

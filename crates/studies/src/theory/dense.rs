//! Dense symmetric matrices of the contact face: factors, roots and extreme eigenvalues, on one thread so that their bits
//! do not depend on how many there are.

use std::sync::OnceLock;

use faer::{Mat, Side, linalg::solvers::Llt, prelude::Solve};
use rayon::ThreadPool;

use contact3d::linalg::{CholeskyFactor, Workspace, add_scaled, dot, largest_ritz_pair};

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

/// The diagonal matrix of some numbers.
pub(super) fn diagonal(values: &[f64]) -> Mat<f64> {
    Mat::from_fn(values.len(), values.len(), |i, j| {
        if i == j { values[i] } else { 0.0 }
    })
}

/// Products with Y⁻¹ by a sparse factor of Y.
pub(super) fn inverse(factor: &CholeskyFactor) -> impl FnMut(Vec<f64>) -> Vec<f64> + '_ {
    let mut work = Workspace::default();
    move |mut forces| {
        factor.solve_in_place(&mut forces, &mut work);
        forces
    }
}

/// The Cholesky factor of a dense positive definite matrix.
pub(super) struct DenseFactor(Llt<f64>);

impl DenseFactor {
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

/// Most steps; each keeps two vectors.
const MOST_STEPS: usize = 300;

/// Steps between looks at the Ritz values.
const LOOK: usize = 5;

/// The residual of the Ritz value at which the iteration ends, as a share of it; the error of the value is about its
/// square where the eigenvalue is alone.
const RELATIVE_RESIDUAL: f64 = 1e-6;

/// The largest eigenvalue of X v = θ Y v with a positive semidefinite X and a positive definite Y, sup X(v)/Y(v), from the
/// products with X and with Y⁻¹: Lanczos' method for Y⁻¹X in the inner product of X with full orthogonalisation (B. N.
/// Parlett, *The Symmetric Eigenvalue Problem*, SIAM 1998, chapters 13 and 15), from the same start on every machine.
///
/// A Ritz value is a lower bound. Returns 0 for n = 0 and for X = 0.
pub(super) fn largest_ratio(
    n: usize,
    mut form: impl FnMut(&[f64]) -> Vec<f64>,
    mut inverse: impl FnMut(Vec<f64>) -> Vec<f64>,
) -> f64 {
    let mut basis: Vec<[Vec<f64>; 2]> = Vec::new();
    let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
    // One application of Y⁻¹X takes the start out of the kernel of X, where it would grow unseen.
    let mut next = inverse(form(&start(n)));
    loop {
        let image = form(&next);
        let length = dot(&next, &image).max(0.0).sqrt();
        let steps = basis.len();
        let looks = steps.is_multiple_of(LOOK) || steps == MOST_STEPS.min(n) || length == 0.0;
        if steps > 0 && looks {
            let (ritz, last) = largest_ritz_pair(&diagonal, &off_diagonal);
            let done = length * last.abs() <= RELATIVE_RESIDUAL * ritz;
            if done || steps == MOST_STEPS.min(n) {
                return ritz;
            }
        }
        if length == 0.0 || !length.is_finite() {
            return if length == 0.0 { 0.0 } else { f64::NAN };
        }
        if steps > 0 {
            off_diagonal.push(length);
        }
        let unit = |v: Vec<f64>| v.into_iter().map(|x| x / length).collect::<Vec<f64>>();
        let (vector, image) = (unit(next), unit(image));
        next = inverse(image.clone());
        diagonal.push(dot(&next, &image));
        basis.push([vector, image]);
        // Twice, since once leaves what cancelled.
        for _ in 0..2 {
            for [vector, image] in &basis {
                let along = dot(&next, image);
                add_scaled(&mut next, -along, vector);
            }
        }
    }
}

/// A vector with components in every direction, the same on every machine.
fn start(n: usize) -> Vec<f64> {
    let golden = |i: usize| (i as f64 * 0.754_877_666).fract();
    (0..n).map(|i| golden(i) - 0.3).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_of_diagonal_forms_are_found() {
        // x_i = i over y_i = 1 + i²: the largest ratio is 1/2 at i = 1.
        let n = 200;
        let ratio = largest_ratio(
            n,
            |v| v.iter().enumerate().map(|(i, v)| i as f64 * v).collect(),
            |v| {
                let each = v.iter().enumerate();
                each.map(|(i, v)| v / (1.0 + (i * i) as f64)).collect()
            },
        );
        // The square of a residual of 1e-6 over a gap of a fifth.
        assert!((ratio - 0.5).abs() < 1e-10, "{ratio}");
    }

    #[test]
    fn a_form_of_rank_one_ends_the_iteration() {
        let ratio = largest_ratio(3, |v| vec![0.0, 4.0 * v[1], 0.0], |v| v);
        assert!((ratio - 4.0).abs() < 1e-12, "{ratio}");
        assert_eq!(largest_ratio(3, |v| vec![0.0; v.len()], |v| v), 0.0);
        assert_eq!(largest_ratio(0, |v| v.to_vec(), |v| v), 0.0);
    }
}

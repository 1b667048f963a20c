//! The spectral radius of a small matrix.

use faer::{Accum, Mat, MatRef, Par, linalg::matmul::matmul};

/// Squarings: ρ is known to a factor κ^(2⁻ᵏ) where κ is the condition of the eigenvectors, 1e-5 for κ = 1e16.
const SQUARINGS: i32 = 22;

/// ρ(M) = lim ‖M^k‖^(1/k), by squaring.
pub(crate) fn spectral_radius(matrix: &Mat<f64>) -> f64 {
    let mut power = matrix.clone();
    let mut logarithm = 0.0;
    for k in 0..=SQUARINGS {
        let size = power.norm_max();
        if size == 0.0 {
            return 0.0;
        }
        logarithm += size.ln() / 2.0_f64.powi(k);
        let scaled = power * faer::Scale(size.recip());
        power = product(scaled.as_ref(), scaled.as_ref());
    }
    logarithm.exp()
}

/// A B on one thread: the same bits at any number of threads.
pub(crate) fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut c = Mat::zeros(a.nrows(), b.ncols());
    matmul(c.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
    c
}

#[cfg(test)]
mod tests {
    use faer::mat;

    use super::spectral_radius;

    #[test]
    fn spectral_radii_of_small_matrices() {
        // A rotation by 90 degrees scaled by 2, a shear whose powers grow slowly, a nilpotent matrix.
        let radius = spectral_radius(&mat![[0.0, -2.0], [2.0, 0.0]]);
        assert!((radius - 2.0).abs() < 1e-12);
        let radius = spectral_radius(&mat![[0.5, 1e6], [0.0, 0.5]]);
        // ‖M^k‖^(1/k) exceeds ½ by the factor (2e6 k)^(1/k), k = 2^22.
        assert!((radius / 0.5 - 1.0).abs() < 1e-5, "{radius}");
        assert_eq!(spectral_radius(&mat![[0.0, 1.0], [0.0, 0.0]]), 0.0);
    }
}

//! How near 1 is to an eigenvalue of a matrix.

use faer::Mat;

use super::{DenseLu, radius_by_products};

/// The least |1 − μ| over the eigenvalues μ of M: 1 over the spectral radius of (1 − M)⁻¹, 0 where 1 is one of them.
pub(crate) fn distance_to_one(matrix: &Mat<f64>) -> f64 {
    let n = matrix.nrows();
    let entry = |i: usize, j: usize| f64::from(u8::from(i == j)) - matrix[(i, j)];
    let entries: Vec<f64> = (0..n * n).map(|at| entry(at % n, at / n)).collect();
    DenseLu::new(&entries, n).map_or(0.0, |lu| least_modulus(&lu, n))
}

/// The least |μ| over the eigenvalues μ of a factorised matrix of order n.
pub(crate) fn least_modulus(lu: &DenseLu, n: usize) -> f64 {
    let solved = |v: &[f64]| {
        let mut solution = v.to_vec();
        lu.solve(&mut solution);
        solution
    };
    radius_by_products(n, solved).recip()
}

#[cfg(test)]
mod tests {
    use faer::{Mat, mat};

    use super::distance_to_one;

    #[test]
    fn distances_to_one_of_small_matrices() {
        // Eigenvalues 0.9 and −3; ±2 i, both at √5; 1 itself; none.
        let cases = [
            (mat![[0.9, 7.0], [0.0, -3.0]], 0.1),
            (mat![[0.0, -2.0], [2.0, 0.0]], 5.0_f64.sqrt()),
            (mat![[1.0, 2.0], [0.0, 0.5]], 0.0),
            (Mat::zeros(0, 0), f64::INFINITY),
        ];
        for (matrix, expected) in cases {
            let distance = distance_to_one(&matrix);
            // 2^22 squarings: the condition of the eigenvectors to the power 2^-22.
            assert!(
                distance == expected || (distance / expected - 1.0).abs() < 1e-5,
                "{distance} {expected}"
            );
        }
    }
}

//! Eigenvalues of dense matrices and of operators known by their products.

use faer::Mat;

use super::{
    dense::{DenseLu, product},
    vector::{dot, norm, orthogonalise},
};

/// ρ(M) = lim ‖M^k‖^(1/k), by squaring: 22 times, after which it is known to a factor κ^(2⁻²²) where κ is the condition of the
/// eigenvectors, 1e-5 for κ = 1e16.
pub(crate) fn spectral_radius(matrix: &Mat<f64>) -> f64 {
    let mut power = matrix.clone();
    let mut logarithm = 0.0;
    for k in 0..=22 {
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

/// An upper estimate of the largest eigenvalue of a positive semidefinite operator on ℝⁿ: the
/// largest Ritz value plus its residual, at most a hundredth of it unless thirty steps do not suffice.
///
/// Lanczos' method with full orthogonalisation (B. N. Parlett, *The Symmetric Eigenvalue Problem*,
/// SIAM 1998, chapter 13), from the same start on every machine. Returns 0 for n = 0 and for the
/// zero operator.
#[must_use]
pub fn largest_eigenvalue(n: usize, mut apply: impl FnMut(&[f64]) -> Vec<f64>) -> f64 {
    if n == 0 {
        return 0.0;
    }
    let mut basis: Vec<Vec<f64>> = vec![start_vector(n)];
    let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
    loop {
        let k = basis.len() - 1;
        let mut next = apply(&basis[k]);
        diagonal.push(dot(&next, &basis[k]));
        orthogonalise(&mut next, &basis, 1);
        let beta = norm(&next);
        let (ritz, last_component) = largest_ritz_pair(&diagonal, &off_diagonal);
        let residual = beta * last_component.abs();
        if residual <= 0.01 * ritz || basis.len() == n.min(30) {
            return ritz + residual;
        }
        off_diagonal.push(beta);
        basis.push(next.iter().map(|v| v / beta).collect());
    }
}

/// A unit vector with components in every direction, the same on every machine.
fn start_vector(n: usize) -> Vec<f64> {
    let raw: Vec<f64> = (0..n)
        .map(|i| 1.0 + 0.5 * (i as f64 * 0.754_877_666).fract())
        .collect();
    let length = norm(&raw);
    raw.iter().map(|v| v / length).collect()
}

/// Largest eigenvalue of the Lanczos matrix and the last component of its unit eigenvector.
#[must_use]
fn largest_ritz_pair(diagonal: &[f64], off_diagonal: &[f64]) -> (f64, f64) {
    let k = diagonal.len();
    let matrix = nalgebra::DMatrix::from_fn(k, k, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => off_diagonal[i.min(j)],
        _ => 0.0,
    });
    let eigen = matrix.symmetric_eigen();
    let largest = eigen.eigenvalues.imax();
    (
        eigen.eigenvalues[largest],
        eigen.eigenvectors[(k - 1, largest)],
    )
}

/// ρ(M) for an M of order n, by Arnoldi's method with two orthogonalisations; exact after n products at most.
pub(crate) fn radius_by_products(n: usize, product: impl FnMut(&[f64]) -> Vec<f64>) -> f64 {
    let [radius] = figures_by_products(n, product, |hessenberg| [spectral_radius(hessenberg)]);
    radius
}

/// Figures of the outer eigenvalues of an M of order n, made from the Hessenberg matrices of Arnoldi's method after every six products
/// until none changes by more than 1e-8 of itself twice in a row.
pub(crate) fn figures_by_products<const K: usize>(
    n: usize,
    mut product: impl FnMut(&[f64]) -> Vec<f64>,
    figures: impl Fn(&Mat<f64>) -> [f64; K],
) -> [f64; K] {
    let start: Vec<f64> = (0..n).map(|i| 1.0 + 0.5 * (i as f64).sin()).collect();
    let mut basis: Vec<Vec<f64>> = vec![scaled(&start, norm(&start).recip())];
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut looks = [[f64::NAN; K]; 2];
    while columns.len() < n {
        let mut next = product(&basis[columns.len()]);
        let size = norm(&next);
        let mut column = orthogonalise(&mut next, &basis, 2);
        let left = norm(&next);
        column.push(left);
        columns.push(column);
        // Of a vector that is in the space already only rounding is left.
        if left <= 1e-14 * size {
            break;
        }
        if columns.len().is_multiple_of(6) {
            let found = figures(&hessenberg(&columns));
            let is_still = |look: &[f64; K]| {
                let mut both = found.iter().zip(look);
                both.all(|(value, look)| (value - look).abs() <= 1e-8 * value)
            };
            if looks.iter().all(is_still) {
                return found;
            }
            looks = [looks[1], found];
        }
        basis.push(scaled(&next, left.recip()));
    }
    figures(&hessenberg(&columns))
}

fn scaled(vector: &[f64], factor: f64) -> Vec<f64> {
    vector.iter().map(|v| factor * v).collect()
}

/// The square part of a Hessenberg matrix given by its columns.
fn hessenberg(columns: &[Vec<f64>]) -> Mat<f64> {
    let entry = |i: usize, j: usize| columns[j].get(i).copied().unwrap_or(0.0);
    Mat::from_fn(columns.len(), columns.len(), entry)
}

#[cfg(test)]
mod tests {
    use faer::{Mat, mat};

    use super::*;
    use crate::linalg::add_scaled;

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

    /// A block-diagonal matrix: a rotation scaled by 0.9 and eigenvalues −0.8, 0.7, …, turned by a product of reflections.
    #[test]
    fn radii_of_rotations_and_of_many_eigenvalues() {
        let n = 40;
        let reflect = |v: &[f64]| {
            let axis: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
            let share = 2.0 * dot(v, &axis) / dot(&axis, &axis);
            let mut out = v.to_vec();
            add_scaled(&mut out, -share, &axis);
            out
        };
        let product = |v: &[f64]| {
            let x = reflect(v);
            let mut y: Vec<f64> = (0..n)
                .map(|i| {
                    x[i] * 0.8 * (1.0 - i as f64 / n as f64) * if i % 2 == 0 { 1.0 } else { -1.0 }
                })
                .collect();
            // 0.9 times a rotation by one radian.
            y[0] = 0.9 * (1.0_f64.cos() * x[0] - 1.0_f64.sin() * x[1]);
            y[1] = 0.9 * (1.0_f64.sin() * x[0] + 1.0_f64.cos() * x[1]);
            reflect(&y)
        };
        // Settled to 1e-8 over twelve steps; the last of 22 squarings takes the root of a number near one.
        let radius = radius_by_products(n, product);
        assert!((radius - 0.9).abs() < 1e-6, "{radius}");
    }

    #[test]
    fn radii_of_small_and_of_nilpotent_matrices() {
        assert_eq!(radius_by_products(0, |_| unreachable!()), 0.0);
        let radius = radius_by_products(1, |v| vec![-3.0 * v[0]]);
        assert!((radius - 3.0).abs() < 1e-6, "{radius}");
        assert_eq!(radius_by_products(3, |_| vec![0.0; 3]), 0.0);
        let shift = |v: &[f64]| vec![0.0, v[0], v[1]];
        // The powers of a nilpotent matrix vanish but for rounding, of which squarings take the 2^22nd root.
        let radius = radius_by_products(3, shift);
        assert!(radius < 1e-4, "{radius}");
    }
}

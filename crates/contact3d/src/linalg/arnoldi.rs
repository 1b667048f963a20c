//! The spectral radius of an operator known by its products.

use faer::Mat;

use super::{
    spectral_radius::spectral_radius,
    vector::{add_scaled, dot, norm},
};

/// Steps between two looks at the Hessenberg matrix, and the change over them, twice in a row, at which its radius counts as that of
/// the operator.
const LOOK: usize = 6;
const SETTLED: f64 = 1e-8;

/// A vector that the products leave this much of is in the space already.
const EXHAUSTED: f64 = 1e-14;

/// ρ(M) for an M of order n, by Arnoldi's method with two orthogonalisations; exact after n products at most.
pub(crate) fn radius_by_products(n: usize, product: impl FnMut(&[f64]) -> Vec<f64>) -> f64 {
    let [radius] = figures_by_products(n, product, |hessenberg| [spectral_radius(hessenberg)]);
    radius
}

/// Figures of the outer eigenvalues of an M of order n, made from the Hessenberg matrices of Arnoldi's method until they settle.
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
        let mut column = vec![0.0; basis.len()];
        for _ in 0..2 {
            for (coefficient, vector) in column.iter_mut().zip(&basis) {
                let share = dot(&next, vector);
                *coefficient += share;
                add_scaled(&mut next, -share, vector);
            }
        }
        let left = norm(&next);
        column.push(left);
        columns.push(column);
        if left <= EXHAUSTED * size {
            break;
        }
        if columns.len().is_multiple_of(LOOK) {
            let found = figures(&hessenberg(&columns));
            let is_still = |look: &[f64; K]| {
                let mut both = found.iter().zip(look);
                both.all(|(value, look)| (value - look).abs() <= SETTLED * value)
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
    use super::*;

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

//! The dual operator S as a dense matrix, and its correction where the factor is in single precision.
//!
//! Rounding perturbs A by δA, and S by E = B A⁻¹ δA A⁻¹Bᵀ: most of it in the few modes in which the body moves as a whole, which
//! fill S and of which A is nearly free. S is computed anew in those: with V an orthonormal basis of the multipliers that excite
//! them and Q = S V − S̃V from solves in double precision,
//!
//! S̃ + Q Vᵀ + V Qᵀ − V (VᵀQ) Vᵀ
//!
//! is symmetric, equals S on V, and leaves (I − VVᵀ) E (I − VVᵀ). In the same way H̃ + (H V − H̃V) Vᵀ.

use std::ops::Range;

use super::{Assembly, assembly::CG_LEFT};
use crate::{
    contact::Coupling,
    linalg::{CscMatrix, add_scaled, dot, norm, orthogonalise},
};

/// Columns treated together: each entry of y is then loaded once for four coefficients.
const PRODUCT_COLUMNS: usize = 4;

/// Independent partial sums of one dot product.
const PRODUCT_LANES: usize = 4;

/// y = S x for a symmetric S, column-major, `[n, n]`; only its lower triangle is read.
pub(super) fn symmetric_product(matrix: &[f64], x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let mut y = vec![0.0; n];
    let whole = n - n % PRODUCT_COLUMNS;
    for k in (0..whole).step_by(PRODUCT_COLUMNS) {
        let end = k + PRODUCT_COLUMNS;
        add_diagonal_block(matrix, k..end, x, &mut y);
        let below = std::array::from_fn(|c| &matrix[(k + c) * n + end..(k + c + 1) * n]);
        let factors = [x[k], x[k + 1], x[k + 2], x[k + 3]];
        let (solved, rest) = y.split_at_mut(end);
        let dots = add_columns_and_dot(below, factors, &x[end..], rest);
        for (y, dot) in solved[k..].iter_mut().zip(dots) {
            *y += dot;
        }
    }
    add_diagonal_block(matrix, whole..n, x, &mut y);
    y
}

/// y += S x of the rows and columns of a range.
fn add_diagonal_block(matrix: &[f64], range: Range<usize>, x: &[f64], y: &mut [f64]) {
    for j in range.clone() {
        let column = &matrix[j * x.len()..(j + 1) * x.len()];
        y[j] += column[j] * x[j];
        for i in j + 1..range.end {
            y[i] += column[i] * x[j];
            y[j] += column[i] * x[i];
        }
    }
}

/// y += Σ columns[c] factors[c]; returns the products columns[c]ᵀ x.
fn add_columns_and_dot(
    columns: [&[f64]; PRODUCT_COLUMNS],
    factors: [f64; PRODUCT_COLUMNS],
    x: &[f64],
    y: &mut [f64],
) -> [f64; PRODUCT_COLUMNS] {
    let n = y.len();
    let [a, b, c, d] = columns.map(|column| &column[..n]);
    let [fa, fb, fc, fd] = factors;
    let x = &x[..n];
    let mut sums = [[0.0; PRODUCT_LANES]; PRODUCT_COLUMNS];
    let whole = n - n % PRODUCT_LANES;
    for i in (0..whole).step_by(PRODUCT_LANES) {
        for lane in 0..PRODUCT_LANES {
            let at = i + lane;
            y[at] += (a[at] * fa + b[at] * fb) + (c[at] * fc + d[at] * fd);
            sums[0][lane] += a[at] * x[at];
            sums[1][lane] += b[at] * x[at];
            sums[2][lane] += c[at] * x[at];
            sums[3][lane] += d[at] * x[at];
        }
    }
    for at in whole..n {
        y[at] += (a[at] * fa + b[at] * fb) + (c[at] * fc + d[at] * fd);
        for (sum, column) in sums.iter_mut().zip([a, b, c, d]) {
            sum[0] += column[at] * x[at];
        }
    }
    sums.map(|[p, q, r, s]| (p + q) + (r + s))
}

/// y −= M x for a column-major M, `[y.len(), x.len()]`.
pub(super) fn subtract_product(matrix: &[f64], x: &[f64], y: &mut [f64]) {
    let rows = y.len();
    let column = |j: usize| &matrix[j * rows..(j + 1) * rows];
    let whole = x.len() - x.len() % PRODUCT_COLUMNS;
    for k in (0..whole).step_by(PRODUCT_COLUMNS) {
        let [a, b, c, d] = std::array::from_fn(|i| column(k + i));
        let [fa, fb, fc, fd] = [x[k], x[k + 1], x[k + 2], x[k + 3]];
        for i in 0..rows {
            y[i] -= (a[i] * fa + b[i] * fb) + (c[i] * fc + d[i] * fd);
        }
    }
    for j in whole..x.len() {
        y.iter_mut()
            .zip(column(j))
            .for_each(|(y, m)| *y -= m * x[j]);
    }
}

/// Corrects S, `[n, n]`, and H, `[rows of C, n]` for a selection Cᵀ, both column-major.
pub(super) fn correct(
    assembly: &Assembly,
    coupling: &Coupling,
    selection: Option<&CscMatrix>,
    operator: &mut [f64],
    compliance: Option<&mut Vec<f64>>,
) {
    let n = coupling.n_multipliers();
    let modes = largest_modes(operator, n);
    let forces = modes.iter().map(|mode| coupling.nodal_forces(mode));
    let moved = assembly.solve_several(forces.collect(), CG_LEFT);
    let pairs = || modes.iter().zip(&moved);
    if let (Some(selection), Some(compliance)) = (selection, compliance) {
        let rows = selection.cols;
        let error_of = |(mode, moved): (&Vec<f64>, &Vec<f64>)| {
            let mut error = vec![0.0; rows];
            selection.mul_transposed(moved, &mut error);
            for (column, value) in compliance.chunks_exact(rows.max(1)).zip(mode) {
                add_scaled(&mut error, -value, column);
            }
            error
        };
        let errors: Vec<Vec<f64>> = pairs().map(error_of).collect();
        for (j, column) in compliance.chunks_exact_mut(rows.max(1)).enumerate() {
            for (mode, error) in modes.iter().zip(&errors) {
                add_scaled(column, mode[j], error);
            }
        }
    }
    // Q Vᵀ + V Qᵀ − V (VᵀQ) Vᵀ = P Vᵀ + V Pᵀ with P = Q − ½ V VᵀQ.
    let half_of = |(mode, moved): (&Vec<f64>, &Vec<f64>)| {
        let mut error = coupling.integrate(moved);
        add_scaled(&mut error, -1.0, &symmetric_product(operator, mode));
        let mut half = error.clone();
        for mode in &modes {
            add_scaled(&mut half, -0.5 * dot(mode, &error), mode);
        }
        half
    };
    let halves: Vec<Vec<f64>> = pairs().map(half_of).collect();
    for (j, column) in operator.chunks_exact_mut(n).enumerate() {
        for (mode, half) in modes.iter().zip(&halves) {
            add_scaled(column, mode[j], half);
            add_scaled(column, half[j], mode);
        }
    }
    for j in 0..n {
        for i in j + 1..n {
            operator[i * n + j] = operator[j * n + i];
        }
    }
}

/// Orthonormal vectors near the eigenvectors of the largest eigenvalues of S, as many as a rigid body has motions, fewer where S has
/// fewer rows.
fn largest_modes(operator: &[f64], n: usize) -> Vec<Vec<f64>> {
    let count = n.min(6);
    // Any vectors that no symmetry of a face can be orthogonal to.
    let start = |k: usize| {
        (0..n)
            .map(|i| ((i * (k + 2) * (k + 2)) as f64 + k as f64).sin())
            .collect()
    };
    let mut modes: Vec<Vec<f64>> = orthonormal((0..count).map(start).collect());
    // Four subspace iterations: the modes' eigenvalues lie far above the others.
    for _ in 0..4 {
        let product = |mode: &Vec<f64>| symmetric_product(operator, mode);
        modes = orthonormal(modes.iter().map(product).collect());
    }
    modes
}

/// Gram and Schmidt's method, twice; vectors that depend on those before them are left out.
fn orthonormal(vectors: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(vectors.len());
    for mut vector in vectors {
        let length = norm(&vector);
        orthogonalise(&mut vector, &basis, 2);
        let left = norm(&vector);
        if left > 1e-10 * length {
            vector.iter_mut().for_each(|v| *v /= left);
            basis.push(vector);
        }
    }
    basis
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn products_equal_their_definitions(
            n in 1..23_usize, rows in 1..19_usize,
            entries in prop::collection::vec(-1.0..1.0_f64, 23 * 23),
            x in prop::collection::vec(-1.0..1.0_f64, 23),
        ) {
            let x = &x[..n];
            let entry = |i: usize, j: usize| entries[i.max(j) * 23 + i.min(j)];
            let symmetric: Vec<f64> = (0..n * n).map(|k| entry(k % n, k / n)).collect();
            let product = symmetric_product(&symmetric, x);
            let mut difference = vec![0.5; rows];
            subtract_product(&entries, x, &mut difference);
            for i in 0..n {
                let expected: f64 = (0..n).map(|j| entry(i, j) * x[j]).sum();
                // At most 23 products below 1: rounding stays below 23² ε_M.
                prop_assert!((product[i] - expected).abs() < 1e-13);
            }
            for i in 0..rows {
                let expected: f64 = (0..n).map(|j| entries[j * rows + i] * x[j]).sum();
                prop_assert!((difference[i] - (0.5 - expected)).abs() < 1e-13);
            }
        }
    }
}

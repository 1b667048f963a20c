//! The dense operator of a factor in single precision, corrected where rounding hurts most.
//!
//! Rounding perturbs A by δA, and S by E = B A⁻¹ δA A⁻¹Bᵀ: most of it in the few modes in which the body moves as a whole, which
//! fill S and of which A is nearly free. S is computed anew in those: with V an orthonormal basis of the multipliers that excite
//! them and R = S V − S̃V from solves in double precision,
//!
//! S̃ + R Vᵀ + V Rᵀ − V (VᵀR) Vᵀ
//!
//! is symmetric, equals S on V, and leaves (I − VVᵀ) E (I − VVᵀ). In the same way G̃ + (G V − G̃V) Vᵀ.

use super::{Assembly, body_solve::CG_LEFT, dense::symmetric_product};
use crate::{
    contact::Coupling,
    linalg::{CscMatrix, add_scaled, dot, norm, orthogonalise},
};

/// Corrects S, `[n, n]`, and G, `[rows of C, n]` for a selection Cᵀ, both column-major.
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
    let moved = assembly.solve_several(&forces.collect::<Vec<_>>(), CG_LEFT);
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
    // R Vᵀ + V Rᵀ − V (VᵀR) Vᵀ = H Vᵀ + V Hᵀ with H = R − ½ V VᵀR.
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

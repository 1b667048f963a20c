//! The local contraction of the mapping Ψ of HKL at a solution.

use faer::{Mat, MatRef};

use crate::linalg::{DenseLu, product, spectral_radius};

/// The spectral radius of Ψ' at a solution, from the derivatives R_λ of the natural map with frozen friction and R' with friction
/// that follows λ, both column-major, `[n, n]`; `None` where R_λ is singular.
///
/// Ψ freezes the slip bounds and the coefficients that λ makes, and solves for λ: Ψ' = 1 − R_λ⁻¹R'. Only the tangential rows of
/// slipping panes differ, so the eigenvalues other than zero are those of −W R_λ⁻¹E, where E picks these rows and
/// W = Eᵀ(R' − R_λ). Successive approximations converge to the solution from nearby where it is below 1, and at that rate.
pub(crate) fn contraction_of_mapping(frozen: &[f64], followed: &[f64], n: usize) -> Option<f64> {
    moving_part(frozen, followed, n).map(|moving| spectral_radius(&moving))
}

/// −W R_λ⁻¹E, from both derivatives.
pub(super) fn moving_part(frozen: &[f64], followed: &[f64], n: usize) -> Option<Mat<f64>> {
    let differs = |row: usize| (0..n).any(|j| frozen[j * n + row] != followed[j * n + row]);
    let rows: Vec<usize> = (0..n).filter(|row| differs(*row)).collect();
    let lu = DenseLu::new(frozen, n)?;
    let mut picked = vec![0.0; n * rows.len()];
    for (column, row) in picked.chunks_exact_mut(n.max(1)).zip(&rows) {
        column[*row] = 1.0;
    }
    lu.solve(&mut picked);
    let moving = Mat::from_fn(rows.len(), n, |k, j| {
        let at = j * n + rows[k];
        followed[at] - frozen[at]
    });
    let inverse = MatRef::from_column_major_slice(&picked, n, rows.len());
    Some(-product(moving.as_ref(), inverse))
}

//! The local contraction of the mapping Ψ of HKL at a solution.

use faer::{Accum, Mat, MatRef, Par, linalg::matmul::matmul};

use super::{
    bordered::DenseLu,
    corrector::PathState,
    equations::{Equations, Friction},
    piece::Piece,
};
use crate::post::Zone;

/// Squarings of Ψ': ρ is known to a factor κ^(2⁻ᵏ) where κ is the condition of its eigenvectors, 1e-5 for κ = 1e16.
const SQUARINGS: i32 = 22;

impl Equations<'_> {
    /// The spectral radius of Ψ' at a solution; `None` where the minimisation with frozen friction is singular there.
    ///
    /// Ψ freezes the slip bounds and the coefficients that λ makes, and solves for λ. With the derivative R_λ of the equations with
    /// frozen friction and R' with friction that follows, Ψ' = 1 − R_λ⁻¹R'. Only the tangential rows of slipping
    /// panes differ, so the eigenvalues other than zero are those of −W R_λ⁻¹E, where E picks these rows and W = Eᵀ(R' − R_λ).
    pub(super) fn spectral_radius(&self, piece: &Piece, state: &PathState) -> Option<f64> {
        let layout = state.member.dual.layout;
        let n = layout.n_multipliers();
        let slipping = (0..layout.n_panes()).filter(|pane| piece.zones[*pane] == Zone::Slip);
        let rows: Vec<usize> = slipping
            .filter_map(|pane| layout.tangential(pane))
            .flatten()
            .collect();
        if rows.is_empty() {
            return Some(0.0);
        }
        let mut frozen = vec![0.0; n * n];
        let mut moving = Mat::<f64>::zeros(rows.len(), n);
        let mut followed = vec![0.0; n];
        for (j, column) in frozen.chunks_exact_mut(n).enumerate() {
            let at = |friction, out: &mut [f64]| {
                self.column(&state.member, piece, &state.evaluated, j, friction, out);
            };
            at(Friction::Frozen, column);
            at(Friction::Followed, &mut followed);
            for (k, row) in rows.iter().enumerate() {
                moving[(k, j)] = followed[*row] - column[*row];
            }
        }
        let lu = DenseLu::new(&frozen, n)?;
        let mut picked = vec![0.0; n * rows.len()];
        for (column, row) in picked.chunks_exact_mut(n).zip(&rows) {
            column[*row] = 1.0;
        }
        lu.solve(&mut picked);
        let inverse = MatRef::from_column_major_slice(&picked, n, rows.len());
        Some(spectral_radius(&product(moving.as_ref(), inverse)))
    }
}

fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut c = Mat::zeros(a.nrows(), b.ncols());
    matmul(c.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
    c
}

/// ρ(M) = lim ‖M^k‖^(1/k), by squaring.
fn spectral_radius(matrix: &Mat<f64>) -> f64 {
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

//! The local contraction of the mapping Ψ of HKL at a point of a path.

use super::{corrector::PathState, derivative::Friction, equations::Equations, piece::Piece};
use crate::solver::contraction_of_mapping;

impl Equations<'_> {
    /// The spectral radius of Ψ' at a solution; `None` where the minimisation with frozen friction is singular there.
    pub(super) fn spectral_radius(&self, piece: &Piece, state: &PathState) -> Option<f64> {
        let n = state.member.dual.layout.n_multipliers();
        let derivative = |friction| {
            let mut matrix = vec![0.0; n * n];
            for (j, column) in matrix.chunks_exact_mut(n).enumerate() {
                self.column(&state.member, piece, &state.evaluated, j, friction, column);
            }
            matrix
        };
        contraction_of_mapping(
            &derivative(Friction::Frozen),
            &derivative(Friction::Followed),
            n,
        )
    }
}

//! Bodies that float and for which no contact forces were found.

use super::{ContactState, Solution, SolvedBy, Status};
use crate::{
    dual::{ContactSystem, PrimalSystem},
    mesh::ContactSurface,
};

/// Whether a body that floats was moved further than its contact faces are wide, as Newton's method does where no contact forces
/// stop it: nothing of that is an answer.
pub(super) fn has_run_away(solution: &Solution, surface: &ContactSurface) -> bool {
    let width = surface.pane_area.iter().sum::<f64>().sqrt();
    !solution.displacement.iter().all(|u| u.abs() <= width)
}

impl Solution {
    /// What is known of a body that floats and for which no contact forces were found: it rests, without any.
    pub(super) fn without_answer(
        status: Status,
        dual: &ContactSystem,
        primal: &PrimalSystem,
        contact: &ContactState<'_>,
    ) -> Self {
        let n_multipliers = dual.layout().n_multipliers();
        let displacement = vec![0.0; primal.dofs.n_free];
        let law = contact.interface.coulomb();
        Self {
            status,
            solved_by: SolvedBy::Direct,
            accuracy: 1.0,
            coulomb: law.map(|law| contact.unpressed(law, &primal.dofs, &displacement)),
            multiplier: vec![0.0; n_multipliers],
            rigid_motion: vec![0.0; primal.floating.as_ref().map_or(0, |body| body.n_modes())],
            displacement,
            ..Self::default()
        }
    }
}

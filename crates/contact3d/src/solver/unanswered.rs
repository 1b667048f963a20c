//! Bodies that float and for which no contact forces were found.

use super::{PaneLaws, Solution, SolvedBy, Status, problem::DiscreteProblem};
use crate::contact::CoulombLaw;

/// Whether a body that floats was moved further than its contact faces are wide, as Newton's method does where no contact forces
/// stop it: nothing of that is an answer.
pub(super) fn has_run_away(solution: &Solution, laws: &PaneLaws) -> bool {
    let width = laws.area.iter().sum::<f64>().sqrt();
    !solution.displacement.iter().all(|u| u.abs() <= width)
}

impl Solution {
    /// What is known of a body that floats and for which no contact forces were found: it rests, without any.
    pub(super) fn without_answer(status: Status, problem: &DiscreteProblem<'_>) -> Self {
        let (laws, primal) = (problem.laws, &problem.body.assembly.primal);
        let displacement = vec![0.0; primal.dofs.n_free];
        let balance = problem.dual.balance.as_ref();
        let straining = balance
            .filter(|it| it.is_resisted())
            .map(|_| displacement.clone());
        let unpressed = |law: &CoulombLaw| {
            let slip = match law.depends_on_slip() {
                true => laws.slip.slip(&problem.body.tangential(&displacement)),
                false => Vec::new(),
            };
            laws.unpressed(law, &slip)
        };
        Self {
            status,
            solved_by: SolvedBy::Direct,
            accuracy: 1.0,
            coulomb: laws.coulomb().map(unpressed),
            multiplier: vec![0.0; laws.layout.n_multipliers()],
            rigid_motion: vec![0.0; primal.floating.as_ref().map_or(0, |body| body.n_modes())],
            straining: straining.unwrap_or_default(),
            displacement,
            ..Self::default()
        }
    }
}

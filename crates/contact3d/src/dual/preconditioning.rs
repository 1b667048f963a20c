//! Whether a factor in single precision serves a problem: measured, not assumed.

use super::{ContactSystem, DualSystem, ExplicitDual, LocalStiffness};
use crate::linalg::{StoppingRule, difference, norm};

/// The error that one step may leave: of conjugate gradients on A, and of corrections by the dense operator.
const SLOWEST: f64 = 0.1;

/// What S̃ has wrong may move a pane as far as its own stress moves it against its neighbours; Newton's method does not find
/// from the answer of S̃ to that of S where it moves panes further.
const MOST_FELT: f64 = 1.0;

/// What conjugate gradients leave of a probe's displacement.
const LEFT: f64 = 1e-6;

impl DualSystem {
    /// Whether both uses of the factor leave at most a tenth of an error a step: conjugate gradients on A, and, where S̃
    /// was formed from it, λ ← λ − S̃⁻¹(S λ − h), and whether panes feel little of what S̃ has wrong. The second knows what
    /// the first does not: the rigid motion of a body that nearly floats fills S, and its error hides what the panes feel. The
    /// third knows what the second does not: a small share of a motion that all panes take part in is much for one of them.
    #[must_use]
    pub fn is_well_preconditioned(&self) -> bool {
        let contact = self.contact.as_ref();
        match contact.and_then(|contact| Some((contact, contact.explicit()?))) {
            Some((contact, dual)) => self.serves(contact, dual),
            None => self.probe(&or_ones(&self.assembly.primal.load)).1 <= SLOWEST,
        }
    }

    /// On w = S̃⁻¹h, the stresses of a face that is glued to the foundation: conjugate gradients on A, and
    /// ‖S̃⁻¹(S w − h)‖ / ‖w‖ with S w from them; and ‖ρ (S − S̃) e‖ / ‖e‖ on e = ρ (S w − h) with local stiffness ρ, which is rich in
    /// what S̃ has wrong.
    fn serves(&self, contact: &ContactSystem, dual: &ExplicitDual) -> bool {
        let local = LocalStiffness::new(dual);
        let rhs = or_ones(&dual.rhs);
        let glued = local.glued(&rhs);
        let (moved, of_gradients) = self.probe(&contact.coupling.nodal_forces(&glued));
        let excess = difference(&contact.coupling.integrate(&moved), &rhs);
        let felt = |wrong: &[f64]| -> Vec<f64> {
            let panes = local.stiffness.iter().zip(wrong);
            panes.map(|(rho, wrong)| rho * wrong).collect()
        };
        let error = felt(&excess);
        let (moved, _) = self.probe(&contact.coupling.nodal_forces(&error));
        let wrong = difference(&contact.coupling.integrate(&moved), &dual.apply(&error));
        of_gradients <= SLOWEST
            && norm(&local.glued(&excess)) / norm(&glued) <= SLOWEST
            && norm(&felt(&wrong)) / norm(&error) <= MOST_FELT
    }

    /// The displacement that some forces cause, and the contraction of the steps to it.
    fn probe(&self, forces: &[f64]) -> (Vec<f64>, f64) {
        let accuracy = StoppingRule {
            share: LEFT,
            length: 0.0,
        };
        let solved = self.assembly.by_gradients(forces, accuracy);
        let contraction = solved.contraction();
        (solved.solution, contraction)
    }
}

/// A vector, or ones where it vanishes.
fn or_ones(vector: &[f64]) -> Vec<f64> {
    if vector.iter().all(|value| *value == 0.0) {
        vec![1.0; vector.len()]
    } else {
        vector.to_vec()
    }
}

//! Whether a factor in single precision serves a problem: measured, not assumed.

use super::{ContactSystem, DualSystem, ExplicitDual, LocalStiffness};
use crate::linalg::{StoppingRule, Workspace, conjugate_gradients, difference, norm};

/// The error that one step may leave: of conjugate gradients on A, and of corrections by the dense operator.
const SLOWEST: f64 = 0.1;

/// What S̃ has wrong may move a pane as far as its own stress moves it against its neighbours; Newton's method does not find
/// from the answer of S̃ to that of S where it moves panes further.
const MOST_FELT: f64 = 1.0;

/// What conjugate gradients leave of a probe's displacement.
const LEFT: f64 = 1e-6;

/// Mean factors of the error in one step, measured on probes.
#[derive(Debug, Default)]
struct Contraction {
    /// Of conjugate gradients on A.
    of_gradients: f64,
    /// Of λ ← λ − S̃⁻¹(S λ − h); 0 where S is not dense.
    of_corrections: f64,
    /// ‖ρ (S − S̃) e‖ / ‖e‖ for e = ρ (S − S̃) S̃⁻¹h, with local stiffness ρ; 0 where S is not dense.
    felt: f64,
}

impl DualSystem {
    /// Whether both uses of the factor leave at most a tenth of an error a step: conjugate gradients on A, and, where S̃
    /// was formed from it, λ ← λ − S̃⁻¹(S λ − h), and whether panes feel little of what S̃ has wrong. The second knows what
    /// the first does not: the rigid motion of a body that nearly floats fills S, and its error hides what the panes feel. The
    /// third knows what the second does not: a small share of a motion that all panes take part in is much for one of them.
    #[must_use]
    pub fn is_well_preconditioned(&self) -> bool {
        let explicit = self
            .contact
            .as_ref()
            .and_then(|contact| Some((contact, contact.explicit()?)));
        let contraction = match explicit {
            Some((contact, dual)) => self.contraction_with_operator(contact, dual),
            None => self.contraction_without_operator(),
        };
        contraction.of_gradients <= SLOWEST
            && contraction.of_corrections <= SLOWEST
            && contraction.felt <= MOST_FELT
    }

    /// On the load, or on a force of one at each unknown where there is none.
    fn contraction_without_operator(&self) -> Contraction {
        let load = &self.assembly.primal.load;
        let forces = if norm(load) > 0.0 {
            load.clone()
        } else {
            vec![1.0; load.len()]
        };
        Contraction {
            of_gradients: self.probe(&forces).1,
            ..Contraction::default()
        }
    }

    /// On w = S̃⁻¹h, the stresses of a face that is glued to the foundation: ‖S̃⁻¹(S w − h)‖ / ‖w‖ with S w from
    /// conjugate gradients; and on e = ρ (S w − h), which is rich in what S̃ has wrong.
    fn contraction_with_operator(
        &self,
        contact: &ContactSystem,
        dual: &ExplicitDual,
    ) -> Contraction {
        let local = LocalStiffness::new(dual);
        let idle = dual.rhs.iter().all(|h| *h == 0.0);
        let rhs = if idle {
            vec![1.0; dual.dimension()]
        } else {
            dual.rhs.clone()
        };
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
        Contraction {
            of_gradients,
            of_corrections: norm(&local.glued(&excess)) / norm(&glued),
            felt: norm(&felt(&wrong)) / norm(&error),
        }
    }

    /// The displacement that some forces cause, and the contraction of the steps to it.
    fn probe(&self, forces: &[f64]) -> (Vec<f64>, f64) {
        let accuracy = StoppingRule {
            share: LEFT,
            length: 0.0,
        };
        let (a, work) = (self.assembly.primal.invertible(), &mut Workspace::default());
        let mut solved = conjugate_gradients(a, &self.assembly.factor, &[forces], accuracy, work);
        let solved = solved.remove(0);
        let contraction = solved.contraction();
        (solved.solution, contraction)
    }
}

//! Whether a factor in single precision serves a problem: measured, not assumed.

use super::{ContactSystem, DualSystem, ExplicitDual, local_stiffness::DenseFactor};
use crate::linalg::{Accuracy, Workspace, conjugate_gradients, difference, norm};

/// The error that one step may leave: of conjugate gradients on A, and of corrections by the dense operator.
const SLOWEST: f64 = 0.1;

/// What conjugate gradients leave of the probe's displacement.
const LEFT: f64 = 1e-6;

/// Mean factors of the error in one step, measured on one probe.
struct Contraction {
    /// Of conjugate gradients on A.
    of_gradients: f64,
    /// Of λ ← λ − S̃⁻¹(S λ − h); 0 where S is not dense.
    of_corrections: f64,
}

impl DualSystem {
    /// Whether both uses of the factor leave at most a tenth of an error a step: conjugate gradients on A, and, where S̃
    /// was formed from it, λ ← λ − S̃⁻¹(S λ − h). The second knows what the first does not: the rigid motion of a body that
    /// nearly floats fills S, and its error hides what the panes feel.
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
        contraction.of_gradients <= SLOWEST && contraction.of_corrections <= SLOWEST
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
            of_corrections: 0.0,
        }
    }

    /// On w = S̃⁻¹h, the stresses of a face that is glued to the foundation: ‖S̃⁻¹(S w − h)‖ / ‖w‖ with S w from
    /// conjugate gradients.
    fn contraction_with_operator(
        &self,
        contact: &ContactSystem,
        dual: &ExplicitDual,
    ) -> Contraction {
        let factor = DenseFactor::new(dual);
        let idle = dual.rhs.iter().all(|h| *h == 0.0);
        let rhs = if idle {
            vec![1.0; dual.dimension()]
        } else {
            dual.rhs.clone()
        };
        let glued = factor.solve(&rhs);
        let (moved, of_gradients) = self.probe(&contact.coupling.nodal_forces(&glued));
        let excess = difference(&contact.coupling.integrate(&moved), &rhs);
        Contraction {
            of_gradients,
            of_corrections: norm(&factor.solve(&excess)) / norm(&glued),
        }
    }

    /// The displacement that some forces cause, and the contraction of the steps to it.
    fn probe(&self, forces: &[f64]) -> (Vec<f64>, f64) {
        let accuracy = Accuracy {
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

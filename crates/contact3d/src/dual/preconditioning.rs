//! Whether a factor in single precision serves a problem: measured, not assumed.

use super::{DualSystem, ExplicitDual, local_stiffness::DenseFactor};
use crate::linalg::{Workspace, conjugate_gradients, difference, norm};

/// The error that one step may leave: of conjugate gradients on A, and of corrections by the dense operator.
const SLOWEST: f64 = 0.1;

/// Where conjugate gradients on the probe stop.
const TOLERANCE: f64 = 1e-6;

impl DualSystem {
    /// Whether both uses of the factor leave at most a tenth of an error a step: conjugate gradients on A, and, where S̃
    /// was formed from it, λ ← λ − S̃⁻¹(S λ − h). The second knows what the first does not: the rigid motion of a body that
    /// nearly floats fills S, and its error hides what the panes feel.
    #[must_use]
    pub fn is_well_preconditioned(&self) -> bool {
        let load = &self.assembly.primal.load;
        // A scene without loads is held by its gap alone.
        let load = if norm(load) > 0.0 {
            load.clone()
        } else {
            vec![1.0; load.len()]
        };
        let a = &self.assembly.primal.stiffness;
        let work = &mut Workspace::default();
        let solved = conjugate_gradients(a, &self.assembly.factor, &load, TOLERANCE, work);
        let explicit = self.contact.as_ref().and_then(|contact| contact.explicit());
        solved.contraction() <= SLOWEST
            && explicit.is_none_or(|dual| self.contraction_of(dual) <= SLOWEST)
    }

    /// ‖S̃⁻¹(S w − h)‖ / ‖w‖ for w = S̃⁻¹h, the stresses of a face that is glued to the foundation.
    fn contraction_of(&self, dual: &ExplicitDual) -> f64 {
        let Some(contact) = &self.contact else {
            return 0.0;
        };
        let factor = DenseFactor::new(dual);
        let glued = factor.solve(&dual.rhs);
        let size = norm(&glued);
        if size == 0.0 || size.is_nan() {
            return 0.0;
        }
        let forces = contact.coupling.nodal_forces(&glued);
        let a = &self.assembly.primal.stiffness;
        let work = &mut Workspace::default();
        let moved = conjugate_gradients(a, &self.assembly.factor, &forces, TOLERANCE, work);
        let closing = contact.coupling.integrate(&moved.solution);
        norm(&factor.solve(&difference(&closing, &dual.rhs))) / size
    }
}

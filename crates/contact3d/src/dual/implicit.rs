//! The dual operator applied by two triangular solves with the factor of A.

use super::{Assembly, ContactSystem, DualOperator};
use crate::linalg::{Reach, Workspace};

/// S applied as the paper does: one pair of sparse triangular solves with the factor of A each time.
///
/// B touches contact nodes only, so the solves visit just the supernodes between those nodes and
/// the root of the elimination tree; the numbers are those of full solves.
pub struct ImplicitOperator<'a> {
    assembly: &'a Assembly,
    contact: &'a ContactSystem,
    reach: Reach,
    work: Workspace,
    applications: usize,
}

impl<'a> ImplicitOperator<'a> {
    /// Prepares the applications of A⁻¹ on the contact nodes.
    #[must_use]
    pub fn new(assembly: &'a Assembly, contact: &'a ContactSystem) -> Self {
        let touched = contact.coupling.transposed.indices.iter().copied();
        Self {
            assembly,
            contact,
            reach: assembly.factor.reach(touched),
            work: Workspace::default(),
            applications: 0,
        }
    }
}

impl DualOperator for ImplicitOperator<'_> {
    fn dimension(&self) -> usize {
        self.contact.layout().n_multipliers()
    }

    fn rhs(&self) -> &[f64] {
        self.contact.dual_rhs()
    }

    fn apply(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        let mut displacement = self.contact.coupling.nodal_forces(multiplier);
        self.assembly
            .factor
            .solve_reached(&self.reach, &mut displacement, &mut self.work);
        self.contact.coupling.integrate(&displacement)
    }

    fn to_primal(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        self.contact
            .displacement(self.assembly, multiplier, &mut self.work)
    }

    fn applications(&self) -> usize {
        self.applications
    }
}

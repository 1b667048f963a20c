//! The dual operator of a body that its supports hold: through the factor, or as a dense matrix.

use super::{Assembly, ContactSystem, DualOperator, ExplicitDual, PrimalOperator};
use crate::linalg::Factor;

/// S, and the displacements of the body behind it.
///
/// Without a dense matrix S is applied as the paper does: one pair of sparse triangular solves with the factor of A each time. B
/// touches contact nodes only, so the solves visit just the supernodes between those nodes and the root of the elimination tree;
/// the numbers are those of full solves. Through a factor in single precision each application takes
/// conjugate gradients over the whole body.
pub struct ContactOperator<'a> {
    /// A dense S and its h; `None` where S is applied through the factor.
    dual: Option<&'a ExplicitDual>,
    assembly: &'a Assembly,
    contact: &'a ContactSystem,
    /// The supernodes that contact forces reach, without a dense S.
    reach: Vec<usize>,
    applications: usize,
}

impl<'a> ContactOperator<'a> {
    /// S through the factor of A.
    #[must_use]
    pub fn implicit(assembly: &'a Assembly, contact: &'a ContactSystem) -> Self {
        let touched = contact.coupling.transposed.indices.iter().copied();
        Self {
            dual: None,
            assembly,
            contact,
            reach: assembly.factor.structure().reach(touched),
            applications: 0,
        }
    }

    /// A dense S; the factor that it came from is used only for the displacement.
    #[must_use]
    pub fn explicit(
        dual: &'a ExplicitDual,
        assembly: &'a Assembly,
        contact: &'a ContactSystem,
    ) -> Self {
        Self {
            dual: Some(dual),
            assembly,
            contact,
            reach: Vec::new(),
            applications: 0,
        }
    }
}

impl DualOperator for ContactOperator<'_> {
    fn dimension(&self) -> usize {
        self.contact.layout().n_multipliers()
    }

    fn rhs(&self) -> &[f64] {
        self.dual
            .map_or_else(|| self.contact.dual_rhs(), |dual| &dual.rhs)
    }

    fn apply(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        if let Some(dual) = self.dual {
            return dual.apply(multiplier);
        }
        let coupling = &self.contact.coupling;
        let mut moved = coupling.nodal_forces(multiplier);
        match &*self.assembly.factor {
            Factor::Double(factor) => factor.solve_reached(&self.reach, &mut moved),
            Factor::Single(_) | Factor::Remote(_) => moved = self.assembly.solve(&moved),
        }
        coupling.integrate(&moved)
    }

    fn applications(&self) -> usize {
        self.applications
    }
}

impl PrimalOperator for ContactOperator<'_> {
    fn to_primal(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        self.contact.displacement(self.assembly, multiplier)
    }

    fn tangential_displacement(&mut self, multiplier: &[f64]) -> Option<Vec<[f64; 2]>> {
        let dual = self.dual.filter(|dual| dual.compliance.is_some())?;
        Some(dual.tangential_displacement(multiplier))
    }
}

//! The two forms of the dual operator: through the factor, and as a dense matrix.

use super::{Assembly, ContactSystem, DualOperator, ExplicitDual, PrimalOperator};
use crate::linalg::{EliminationPath, Factor, Workspace};

/// S applied as the paper does: one pair of sparse triangular solves with the factor of A each time.
///
/// B touches contact nodes only, so the solves visit just the supernodes between those nodes and
/// the root of the elimination tree; the numbers are those of full solves, up to the order of sums. Through a factor in
/// single precision each application takes conjugate gradients over the whole body.
pub struct ImplicitOperator<'a> {
    assembly: &'a Assembly,
    contact: &'a ContactSystem,
    reach: EliminationPath,
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
            reach: assembly.factor.structure().reach(touched),
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
        let (assembly, coupling) = (self.assembly, &self.contact.coupling);
        let forces = coupling.nodal_forces(multiplier);
        let displacement = match &*assembly.factor {
            Factor::Double(factor) => {
                let mut displacement = forces;
                factor.solve_reached(&self.reach, &mut displacement, &mut self.work);
                displacement
            }
            Factor::Single(_) => assembly.solve(&forces, &mut self.work),
        };
        coupling.integrate(&displacement)
    }

    fn applications(&self) -> usize {
        self.applications
    }
}

impl PrimalOperator for ImplicitOperator<'_> {
    fn to_primal(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        self.contact
            .displacement(self.assembly, multiplier, &mut self.work)
    }

    fn tangential_displacement(&mut self, _multiplier: &[f64]) -> Option<Vec<[f64; 2]>> {
        None
    }
}

/// S applied as a dense symmetric matrix; the factor of A is used only for the displacement.
pub struct ExplicitOperator<'a> {
    dual: &'a ExplicitDual,
    assembly: &'a Assembly,
    contact: &'a ContactSystem,
    work: Workspace,
    applications: usize,
}

impl<'a> ExplicitOperator<'a> {
    /// Joins the dense dual problem and the factor it came from.
    #[must_use]
    pub fn new(dual: &'a ExplicitDual, assembly: &'a Assembly, contact: &'a ContactSystem) -> Self {
        Self {
            dual,
            assembly,
            contact,
            work: Workspace::default(),
            applications: 0,
        }
    }
}

impl DualOperator for ExplicitOperator<'_> {
    fn dimension(&self) -> usize {
        self.dual.dimension()
    }

    fn rhs(&self) -> &[f64] {
        &self.dual.rhs
    }

    fn apply(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        self.dual.apply(multiplier)
    }

    fn applications(&self) -> usize {
        self.applications
    }
}

impl PrimalOperator for ExplicitOperator<'_> {
    fn to_primal(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        self.contact
            .displacement(self.assembly, multiplier, &mut self.work)
    }

    fn tangential_displacement(&mut self, multiplier: &[f64]) -> Option<Vec<[f64; 2]>> {
        self.dual.compliance.as_ref()?;
        Some(self.dual.tangential_displacement(multiplier))
    }
}

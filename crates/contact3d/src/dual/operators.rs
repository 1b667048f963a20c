//! The two forms of the dual operator: through the factor, and as a dense matrix.

use super::{Assembly, Balance, ContactSystem, DualOperator, ExplicitDual};
use crate::linalg::{Factor, Reach, Workspace};

/// S applied as the paper does: one pair of sparse triangular solves with the factor of A each time.
///
/// B touches contact nodes only, so the solves visit just the supernodes between those nodes and
/// the root of the elimination tree; the numbers are those of full solves, up to the order of sums. Through a factor in
/// single precision each application takes conjugate gradients over the whole body.
pub struct ImplicitOperator<'a> {
    assembly: &'a Assembly,
    contact: &'a ContactSystem,
    reach: Reach,
    moved: Moved,
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
            moved: Moved::at_rest(contact),
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
        self.moved.rhs(self.contact)
    }

    fn balance(&self) -> Option<&Balance> {
        self.contact.balance.as_ref()
    }

    fn motion(&self) -> &[f64] {
        &self.moved.motion
    }

    fn set_motion(&mut self, motion: &[f64]) {
        self.moved.set(self.contact, motion);
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

    fn to_primal(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        let unknowns = self.moved.unknowns(multiplier);
        self.contact
            .displacement(self.assembly, &unknowns, &mut self.work)
    }

    fn applications(&self) -> usize {
        self.applications
    }
}

/// S applied as a dense symmetric matrix; the factor of A is used only for the displacement.
pub struct ExplicitOperator<'a> {
    dual: &'a ExplicitDual,
    assembly: &'a Assembly,
    contact: &'a ContactSystem,
    moved: Moved,
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
            moved: Moved::at_rest(contact),
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
        match self.balance() {
            None => &self.dual.rhs,
            Some(_) => self.moved.rhs(self.contact),
        }
    }

    fn balance(&self) -> Option<&Balance> {
        self.contact.balance.as_ref()
    }

    fn motion(&self) -> &[f64] {
        &self.moved.motion
    }

    fn set_motion(&mut self, motion: &[f64]) {
        self.moved.set(self.contact, motion);
    }

    fn apply(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        self.dual.apply(multiplier)
    }

    fn to_primal(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        let unknowns = self.moved.unknowns(multiplier);
        self.contact
            .displacement(self.assembly, &unknowns, &mut self.work)
    }

    fn tangential_displacement(&mut self, multiplier: &[f64]) -> Option<Vec<[f64; 2]>> {
        self.dual.compliance.as_ref()?;
        let unknowns = self.moved.unknowns(multiplier);
        Some(self.dual.tangential_displacement(&unknowns))
    }

    fn applications(&self) -> usize {
        self.applications
    }
}

/// Where a body that floats is, and h + G α there; empty where supports hold it.
struct Moved {
    motion: Vec<f64>,
    rhs: Vec<f64>,
}

impl Moved {
    fn at_rest(contact: &ContactSystem) -> Self {
        let n = contact.balance.as_ref().map_or(0, Balance::n_felt);
        Self {
            motion: vec![0.0; n],
            rhs: contact
                .balance
                .iter()
                .flat_map(|_| contact.dual_rhs())
                .copied()
                .collect(),
        }
    }

    fn set(&mut self, contact: &ContactSystem, motion: &[f64]) {
        if let Some(balance) = &contact.balance {
            self.motion = motion.to_vec();
            let h = contact.dual_rhs();
            let moved = balance.coupling.integrals_of(motion, h.len());
            self.rhs = h.iter().zip(moved).map(|(h, g)| h + g).collect();
        }
    }

    fn rhs<'a>(&'a self, contact: &'a ContactSystem) -> &'a [f64] {
        match contact.balance {
            None => contact.dual_rhs(),
            Some(_) => &self.rhs,
        }
    }

    fn unknowns(&self, multiplier: &[f64]) -> Vec<f64> {
        [multiplier, &self.motion].concat()
    }
}

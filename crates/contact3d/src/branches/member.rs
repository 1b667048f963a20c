//! A contact problem at one value of the parameter.

use std::sync::Arc;

use crate::{
    contact::{CoulombLaw, Interface},
    dual::{ExplicitDual, LocalStiffness},
    mesh::ContactSurface,
    problem::AssembledProblem,
    solver::{ContactState, PaneLaws},
};

/// A contact problem at one value of the parameter.
pub(super) struct Member {
    pub(super) base: Arc<AssembledProblem>,
    pub(super) interface: Arc<Interface>,
    /// S, h and the compliance of the contact nodes.
    pub(super) dual: ExplicitDual,
    /// ρ: the stiffness of each pane while the others do not move, `[n_multipliers]`, in Pa/m³.
    pub(super) local: Arc<LocalStiffness>,
}

impl Member {
    pub(super) fn surface(&self) -> &ContactSurface {
        let surface = self.base.mesh().contact.as_ref();
        surface.expect("a family has contact")
    }

    pub(super) fn law(&self) -> &CoulombLaw {
        self.interface
            .coulomb()
            .expect("a family has Coulomb friction")
    }

    pub(super) fn laws(&self) -> PaneLaws {
        let (surface, interface) = (self.surface(), &*self.interface);
        ContactState { surface, interface }.laws()
    }

    pub(super) fn steplengths(&self) -> &[f64] {
        &self.local.stiffness
    }
}

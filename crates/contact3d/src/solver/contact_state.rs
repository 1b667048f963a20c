//! What the solvers know of the contact face, and the state of friction at a multiplier.

use super::FeasibleSet;
use crate::{
    contact::{CoulombLaw, FrictionField, Interface, InterfaceFriction, MultiplierLayout},
    dual::ExplicitDual,
    elasticity::DofMap,
    mesh::ContactSurface,
};

/// The slip bound and the friction of an inner problem.
#[derive(Debug, Clone, PartialEq)]
pub struct CoulombState {
    /// g of the panes with friction, `[n_friction_panes]`, in Pa.
    pub slip_bound: Vec<f64>,
    /// F and 𝓕⁻¹.
    pub friction: FrictionField,
}

/// What the friction law needs to know of the contact face.
#[derive(Debug, Clone, Copy)]
pub struct ContactState<'a> {
    /// Γ_c and its panes.
    pub surface: &'a ContactSurface,
    /// Its frame, gap and friction law.
    pub interface: &'a Interface,
}

impl<'a> ContactState<'a> {
    /// Number of panes m.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        self.surface.n_panes()
    }

    /// The order of the multipliers.
    #[must_use]
    pub fn layout(&self) -> MultiplierLayout {
        MultiplierLayout::new(self.n_panes(), self.interface.n_friction_panes())
    }

    /// The admissible set of frictionless contact or of Tresca's law; with Coulomb's law that of
    /// a given state.
    #[must_use]
    pub fn feasible_set(&self, coulomb: Option<&CoulombState>) -> FeasibleSet<'a> {
        let semi_axes = match (&self.interface.friction, coulomb) {
            (InterfaceFriction::Tresca(semi_axes), _) => semi_axes.clone(),
            (InterfaceFriction::Coulomb(_), Some(state)) => state.semi_axes(),
            (InterfaceFriction::Frictionless | InterfaceFriction::Coulomb(_), _) => Vec::new(),
        };
        FeasibleSet::new(self.n_panes(), semi_axes, &self.interface.projections)
    }
}

impl ContactState<'_> {
    /// The state of friction without pressures at a displacement over the free degrees of freedom in m.
    pub(super) fn unpressed(
        &self,
        law: &CoulombLaw,
        dofs: &DofMap,
        displacement: &[f64],
    ) -> CoulombState {
        let slip = match law.depends_on_slip() {
            true => self
                .interface
                .slip_of_displacement(self.surface, dofs, displacement),
            false => Vec::new(),
        };
        CoulombState {
            slip_bound: law.slip_bounds(&vec![0.0; self.n_panes()], |l| l),
            friction: FrictionField::new(law, self.surface, &slip),
        }
    }
}

impl CoulombState {
    /// Whether the coefficients are positive and finite wherever panes are pressed; elsewhere they
    /// bound nothing.
    #[must_use]
    pub fn is_admissible(&self, surface: &ContactSurface) -> bool {
        let pressed = |pane: usize| self.slip_bound[pane] > 0.0;
        self.friction.is_admissible(surface, pressed)
    }

    /// Semi-axes g_i / (𝓕_i⁻¹)₁₁ and g_i / (𝓕_i⁻¹)₂₂ of the admissible ellipses in Pa, `[n_friction_panes]`.
    #[must_use]
    pub fn semi_axes(&self) -> Vec<[f64; 2]> {
        let panes = self.slip_bound.iter().zip(&self.friction.pane_inverse);
        panes.map(|(g, inverse)| inverse.map(|f| g / f)).collect()
    }
}

/// φ at the contact nodes for a multiplier; empty unless the law follows the slip.
pub(super) fn slip_of(
    dual: &ExplicitDual,
    contact: &ContactState<'_>,
    multiplier: &[f64],
) -> Vec<[f64; 2]> {
    let displacement = dual.tangential_displacement(multiplier);
    match displacement.is_empty() {
        true => displacement,
        false => contact.interface.slip_of(&displacement),
    }
}

/// The state of friction that a multiplier itself makes: the slip bound g of λ_ν and 𝓕 = 𝓕(u_t(λ)).
#[must_use]
pub fn coulomb_state(
    dual: &ExplicitDual,
    contact: &ContactState<'_>,
    law: &CoulombLaw,
    multiplier: &[f64],
) -> CoulombState {
    let (normal, _) = dual.layout.split(multiplier);
    CoulombState {
        slip_bound: law.slip_bounds(normal, |l| l.max(0.0)),
        friction: FrictionField::new(law, contact.surface, &slip_of(dual, contact, multiplier)),
    }
}

//! The laws of the panes as the solvers see them, and the state of friction at a multiplier.

use super::FeasibleSet;
use crate::{
    contact::{
        CoulombLaw, FrictionField, InterfaceFriction, MultiplierLayout, PreviousIncrement, slips,
    },
    dual::ExplicitDual,
    linalg::CscMatrix,
};

/// The panes and the law of each.
#[derive(Debug)]
pub struct PaneLaws {
    /// The order of the multipliers.
    pub layout: MultiplierLayout,
    /// |Rⁱ| in m², `[n_panes]`.
    pub area: Vec<f64>,
    /// Averaging over panes: column i holds the weights of nodal values on pane i, `[n_contact_nodes, n_panes]`.
    pub average: CscMatrix,
    /// The law of tangential stresses.
    pub friction: InterfaceFriction,
    /// What slips are counted from; `None` for no displacement.
    pub previous: Option<PreviousIncrement>,
}

/// The slip bound and the friction of an inner problem.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CoulombState {
    /// g of the panes with friction, `[n_friction_panes]`, in Pa.
    pub slip_bound: Vec<f64>,
    /// F and 𝓕⁻¹.
    pub friction: FrictionField,
}

impl PaneLaws {
    /// Number of panes m.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        self.layout.n_panes()
    }

    /// The law whose slip bound follows the pressure, where it is the law.
    #[must_use]
    pub fn coulomb(&self) -> Option<&CoulombLaw> {
        self.friction.coulomb()
    }

    /// The admissible set of frictionless contact or of Tresca's law; with Coulomb's law that of
    /// a given state.
    #[must_use]
    pub fn feasible_set(&self, coulomb: Option<&CoulombState>) -> FeasibleSet {
        let semi_axes = match (&self.friction, coulomb) {
            (InterfaceFriction::Tresca(semi_axes), _) => semi_axes.clone(),
            (InterfaceFriction::Coulomb(_), Some(state)) => state.semi_axes(),
            (InterfaceFriction::Frictionless | InterfaceFriction::Coulomb(_), _) => Vec::new(),
        };
        FeasibleSet::new(self.n_panes(), semi_axes)
    }

    /// The state of friction under normal stresses in Pa at slips of the contact nodes in m; no slips mean zero.
    pub(super) fn state(
        &self,
        law: &CoulombLaw,
        normal: &[f64],
        slip: &[[f64; 2]],
    ) -> CoulombState {
        CoulombState {
            slip_bound: law.slip_bounds(normal),
            friction: FrictionField::new(law, &self.average, slip),
        }
    }

    /// The state of friction without pressures.
    pub(super) fn without_pressure(&self, law: &CoulombLaw, slip: &[[f64; 2]]) -> CoulombState {
        self.state(law, &vec![0.0; self.n_panes()], slip)
    }

    /// Evaluations of the friction law at nodes so far.
    pub(super) fn law_evaluations(&self) -> usize {
        self.coulomb().map_or(0, CoulombLaw::evaluations)
    }
}

impl CoulombState {
    /// Whether the coefficients are positive and finite wherever panes are pressed; elsewhere they
    /// bound nothing.
    #[must_use]
    pub fn is_admissible(&self, laws: &PaneLaws) -> bool {
        let pressed = |pane: usize| self.slip_bound[pane] > 0.0;
        self.friction.is_admissible(&laws.average, pressed)
    }

    /// Semi-axes g_i / (𝓕_i⁻¹)₁₁ and g_i / (𝓕_i⁻¹)₂₂ of the admissible ellipses in Pa, `[n_friction_panes]`.
    #[must_use]
    pub fn semi_axes(&self) -> Vec<[f64; 2]> {
        let panes = self.slip_bound.iter().zip(&self.friction.pane_inverse);
        panes.map(|(g, inverse)| inverse.map(|f| g / f)).collect()
    }
}

/// φ at the contact nodes for a multiplier; empty unless the law follows the slip.
pub(super) fn slip_of(dual: &ExplicitDual, laws: &PaneLaws, multiplier: &[f64]) -> Vec<[f64; 2]> {
    let displacement = dual.tangential_displacement(multiplier);
    if displacement.is_empty() {
        displacement
    } else {
        slips(laws.previous.as_ref(), &displacement)
    }
}

/// The state of friction that a multiplier itself makes: the slip bound g of λ_ν and 𝓕 = 𝓕(u_t(λ)).
#[must_use]
pub fn coulomb_state(
    dual: &ExplicitDual,
    laws: &PaneLaws,
    law: &CoulombLaw,
    multiplier: &[f64],
) -> CoulombState {
    let stresses = dual.stresses(multiplier);
    let (normal, _) = dual.layout.split(&stresses);
    let slip = slip_of(dual, laws, multiplier);
    laws.state(law, normal, &slip)
}

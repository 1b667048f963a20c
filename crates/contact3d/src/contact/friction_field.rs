//! Friction coefficients at the contact nodes and their means 𝓕⁻¹ over panes (HKL (4.2)).

use super::CoulombLaw;
use crate::{linalg::CscMatrix, scene::is_coefficient};

/// Friction coefficients on the contact face at one state of slip.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrictionField {
    /// (F₁, F₂) at the contact nodes of the faces with friction, `[n_friction_nodes]`.
    pub nodal: Vec<[f64; 2]>,
    /// Diagonal of 𝓕_i⁻¹ = (1/|Rⁱ|) ∫_{Rⁱ} r_h F⁻¹ on each pane with friction (HKL (4.2)), `[n_friction_panes]`.
    pub pane_inverse: Vec<[f64; 2]>,
}

impl FrictionField {
    /// Evaluates the law at nodal slips and averages F⁻¹, Lagrange-interpolated, over the panes by
    /// [`pane_average`](crate::mesh::ContactSurface::pane_average).
    #[must_use]
    pub fn new(law: &CoulombLaw, average: &CscMatrix, slip: &[[f64; 2]]) -> Self {
        let nodal = law.at_nodes(slip);
        let pane_inverse = (0..law.n_panes())
            .map(|pane| {
                average.entries(pane).fold([0.0; 2], |sum, (node, weight)| {
                    std::array::from_fn(|i| sum[i] + weight / nodal[node][i])
                })
            })
            .collect();
        Self {
            nodal,
            pane_inverse,
        }
    }

    /// Whether all coefficients that act on some panes are positive and finite, which no theory
    /// does without; formulas may fail at slips that only a solution shows.
    #[must_use]
    pub fn is_admissible(&self, average: &CscMatrix, acts: impl Fn(usize) -> bool) -> bool {
        let panes = (0..self.pane_inverse.len()).filter(|pane| acts(*pane));
        let nodes = panes.flat_map(|pane| average.entries(pane).map(|(node, _)| node));
        let mut coefficients = nodes.flat_map(|node| self.nodal[node]);
        coefficients.all(is_coefficient)
    }

    /// The coefficients (F₁, F₂) that act on a pane: the reciprocals of 𝓕_i⁻¹.
    #[must_use]
    pub fn pane(&self, pane: usize) -> [f64; 2] {
        self.pane_inverse[pane].map(f64::recip)
    }
}

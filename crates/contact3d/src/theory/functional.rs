//! The friction functional of the program beside that of HKL.

use super::{face::Face, quartic::triangle_rule};
use crate::{
    contact::{CoulombLaw, FrictionField},
    mesh::ContactSurface,
};

/// How far the friction functional of the program, Σ g_i |Rⁱ| ‖𝓕_i mean u_t‖ with the mean 𝓕_i⁻¹ of F⁻¹ at the nodes of a pane,
/// is from HKL's j = ∫ g ‖F(φ) u_t‖ at a solution.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FrictionFunctional {
    /// (j_H − j)/j; 0 where j vanishes.
    pub difference: f64,
    /// The largest ‖F⁻¹(φ) λ_t‖/g − 1 at points of pressed panes: the stress bound that holds for the mean fails there by this
    /// share; negative where it fails nowhere.
    pub excess: f64,
}

/// A solution on panes.
pub(super) struct OnPanes<'a> {
    pub(super) face: &'a Face,
    pub(super) surface: &'a ContactSurface,
    pub(super) law: &'a CoulombLaw,
    /// λ_ν in Pa.
    pub(super) normal: &'a [f64],
    /// λ_t in Pa.
    pub(super) pairs: &'a [[f64; 2]],
    /// Signed (u_t1, u_t2) at the contact nodes.
    pub(super) tangential: &'a [[f64; 2]],
    /// φ there.
    pub(super) slip: &'a [[f64; 2]],
}

impl OnPanes<'_> {
    /// By a rule of degree 5 on each triangle; `None` for nodal multipliers, which have no panes.
    pub(super) fn functional(&self) -> Option<FrictionFunctional> {
        if self.surface.is_nodal() {
            return None;
        }
        let bound = self.law.slip_bounds(self.normal, |l| l.max(0.0));
        let (mut exact, mut excess) = (0.0, f64::NEG_INFINITY);
        for (t, &pane) in self.surface.facet_pane.iter().enumerate() {
            for (weight, shape) in triangle_rule() {
                let coefficients = self.coefficients(t, &shape);
                let [first, second] = self.mean(self.tangential, t, &shape);
                let work = (coefficients[0] * first).hypot(coefficients[1] * second);
                exact += bound[pane] * weight * self.face.area(t) * work;
                if bound[pane] > 0.0 {
                    let [first, second] = self.pairs[pane];
                    let size = (first / coefficients[0]).hypot(second / coefficients[1]);
                    excess = f64::max(excess, size / bound[pane] - 1.0);
                }
            }
        }
        let averaged = self.averaged(&bound);
        Some(FrictionFunctional {
            difference: if exact == 0.0 {
                0.0
            } else {
                (averaged - exact) / exact
            },
            excess,
        })
    }

    /// Σ g_i |Rⁱ| ‖𝓕_i mean u_t‖.
    fn averaged(&self, bound: &[f64]) -> f64 {
        let field = FrictionField::new(self.law, &self.surface.pane_average, self.slip);
        let panes = bound.iter().enumerate().map(|(pane, g)| {
            let mean = |k: usize| -> f64 {
                let nodes = self.surface.pane_weights(pane);
                nodes
                    .map(|(node, weight)| weight * self.tangential[node][k])
                    .sum()
            };
            let [first, second] = field.pane(pane);
            g * self.surface.pane_area[pane] * (first * mean(0)).hypot(second * mean(1))
        });
        panes.sum()
    }

    /// F at a point of a triangle.
    fn coefficients(&self, triangle: usize, shape: &[f64; 3]) -> [f64; 2] {
        let corners = self.face.corners(triangle);
        let at = std::array::from_fn(|c| corners.iter().zip(shape).map(|(x, s)| s * x[c]).sum());
        self.law
            .only()
            .law()
            .evaluate(at, self.mean(self.slip, triangle, shape))
    }

    fn mean(&self, nodal: &[[f64; 2]], triangle: usize, shape: &[f64; 3]) -> [f64; 2] {
        let nodes = self.face.triangles[triangle];
        [0, 1].map(|k| nodes.iter().zip(shape).map(|(n, s)| s * nodal[*n][k]).sum())
    }
}

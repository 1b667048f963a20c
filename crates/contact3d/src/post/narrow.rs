//! Contact too narrow for its panes, and how wide it is by Hertz's theory.
//!
//! Where all force is on panes that lie beside open ones, panes tell neither the largest pressure nor the area. The force itself is known,
//! as equilibrium fixes it, and so is the gap before loading, d(s) ≈ d₀ + g·s + ½ s·Ks near the place. With κ₁ ≥ κ₂ ≥ 0 of K and E* of
//! [`super::areas`] the contact under a force F is an ellipse with the semi-axes (K. L. Johnson, Contact Mechanics, 4.2)
//!
//! ```text
//!     c³ = 3F / (4 E* √(κ₁ κ₂)),    b ≈ c (κ₂/κ₁)^(1/3),    a ≈ c (κ₁/κ₂)^(1/3),
//! ```
//!
//! or, of a length L < 2a, a strip with b = (4F / (π E* L κ₁))^(1/2).

use std::{collections::BTreeSet, f64::consts::PI};

use nalgebra::{Matrix2, Matrix3x2, Matrix6, Vector2, Vector3, Vector6};

use super::{ContactReport, Zone, areas::half_space_stiffness};
use crate::{mesh::Mesh, scene::Scene, solver::ContactSide};

/// Contact that is as narrow as one pane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NarrowContact {
    /// The share of the normal force on panes that lie beside an open one.
    pub share: f64,
    /// The width 2b by Hertz's theory in m; `None` where the gap does not open around contact, or more panes span it.
    pub width: Option<f64>,
}

/// The share of the normal force on panes beside open ones from which contact is narrow: all of two panes across, 0.8 of the three across a
/// ball, 0.6 of the three across a strip.
const NARROW: f64 = 0.75;

impl NarrowContact {
    /// Panes across a contact that tell how its pressure falls.
    pub const PANES_ACROSS: f64 = 4.0;
}

impl ContactReport {
    /// Contact that is a single pane, a line of them, or a ring around one node, so that no mesh of panes tells how pressure falls towards its
    /// edge; `None` where panes tell.
    #[must_use]
    pub fn narrow_contact(
        &self,
        scene: &Scene,
        mesh: &Mesh,
        side: ContactSide<'_>,
    ) -> Option<NarrowContact> {
        let surface = side.surface;
        let force = |pane: usize| -self.panes[pane].normal_stress * surface.pane_area[pane];
        let panes = 0..self.panes.len();
        let beside = surface.panes_beside(mesh);
        let is_open = |pane: &usize| self.panes[*pane].zone == Zone::Open;
        let is_at_edge = |pane: &usize| beside[*pane].iter().any(is_open);
        let at_edge: f64 = panes.clone().filter(is_at_edge).map(force).sum();
        let share = at_edge / panes.clone().map(force).sum::<f64>();
        if share.is_nan() || share <= NARROW {
            return None;
        }
        let highest = panes.max_by(|a, b| force(*a).total_cmp(&force(*b)))?;
        let mut patch = BTreeSet::from([highest]);
        let mut ahead = vec![highest];
        while let Some(pane) = ahead.pop() {
            let pressed = beside[pane].iter().filter(|other| !is_open(other));
            ahead.extend(pressed.filter(|other| patch.insert(**other)));
        }
        let load = patch.iter().copied().map(force).sum::<f64>();
        let width = hertz_width((scene, mesh, side), highest, &patch, load);
        let most = NarrowContact::PANES_ACROSS * surface.pane_area[highest].sqrt();
        Some(NarrowContact {
            share,
            width: width.filter(|width| *width < most),
        })
    }
}

/// 2b in m of the contact of some panes around one of them under their force in N; `None` where the gap does not open around it.
fn hertz_width(
    (scene, mesh, side): (&Scene, &Mesh, ContactSide<'_>),
    pane: usize,
    patch: &BTreeSet<usize>,
    force: f64,
) -> Option<f64> {
    let surface = side.surface;
    let pane_width = surface.pane_area[pane].sqrt();
    let stiffness = half_space_stiffness(scene, mesh, surface);
    let load = force / (stiffness[pane] * pane_width / 2.0);

    let centre = Vector3::from(surface.pane_centre(mesh, pane));
    let (nearest, _) = surface.pane_weights(pane).next()?;
    let axes = side.interface.frame.axes_at(nearest).map(Vector3::from);
    let tangent = Matrix3x2::from_columns(&axes).transpose();
    // In widths of the pane.
    let near = |node: usize| {
        let at = Vector3::from(mesh.coordinates[surface.nodes[node]]);
        tangent * (at - centre) / pane_width
    };
    let face = &surface.faces[surface.face_of_pane(pane)];
    let gap = side.interface.gap.as_ref()?;
    // Up to the panes beside it.
    let around = face.nodes.clone().map(|node| (near(node), gap[node]));
    let around = around.filter(|(s, _)| s.amax() < 2.0);
    let curvature = (curvature(around)? / (pane_width * pane_width)).symmetric_eigen();
    let (steep, flat) = (curvature.eigenvalues.imax(), curvature.eigenvalues.imin());
    let along: Vector2<f64> = curvature.eigenvectors.column(flat).into();
    let [steep, flat] = [steep, flat].map(|k| curvature.eigenvalues[k]);
    // A gap that is even to its digits has no width.
    if steep * pane_width < 1e-9 {
        return None;
    }
    let weights = patch.iter().flat_map(|&pane| surface.pane_weights(pane));
    let ends = weights.fold([0.0, 0.0], |[low, high]: [f64; 2], (node, _)| {
        let at = along.dot(&near(node));
        [low.min(at), high.max(at)]
    });
    let length = pane_width * (ends[1] - ends[0]).max(1.0);
    let round = (0.75 * load / (steep * flat.max(0.0)).sqrt()).cbrt();
    let is_strip = flat <= 0.0 || 2.0 * round * (steep / flat).cbrt() > length;
    let half = match is_strip {
        true => (4.0 * load / (PI * length * steep)).sqrt(),
        false => round * (flat / steep).cbrt(),
    };
    Some(2.0 * half)
}

/// K of the quadratic function that is nearest to some values at their places; `None` where they do not tell it.
fn curvature(values: impl Iterator<Item = (Vector2<f64>, f64)>) -> Option<Matrix2<f64>> {
    let (mut normal, mut moments) = (Matrix6::zeros(), Vector6::zeros());
    for (s, value) in values {
        let row = Vector6::new(1.0, s.x, s.y, 0.5 * s.x * s.x, s.x * s.y, 0.5 * s.y * s.y);
        normal += row * row.transpose();
        moments += row * value;
    }
    let fitted = normal.cholesky()?.solve(&moments);
    Some(Matrix2::new(fitted[3], fitted[4], fitted[4], fitted[5]))
}

//! Forces, moments, energies and extreme values of a solution.

use std::ops::Range;

use nalgebra::Vector3;

use super::{PaneState, Solved, SolvedContact, Zone};
use crate::{linalg::dot, mesh::SurfaceFace};

/// A vector in the global axes.
pub type Vector = [f64; 3];

/// Forces, moments about the origin, energies and extreme values of a solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resultants {
    /// Applied loads in N.
    pub applied_force: Vector,
    /// Reaction of the clamps in N.
    pub clamp_force: Vector,
    /// Moments about the origin in N·m, in the same order: contact, applied, clamp.
    pub moments: [Vector; 3],
    /// ‖Σ forces‖ over Σ‖force‖.
    pub force_imbalance: f64,
    /// ‖Σ moments‖ over Σ‖moment‖.
    pub moment_imbalance: f64,
    /// Strain energy ½ uᵀAu in J.
    pub strain_energy: f64,
    /// Work of the loads lᵀu in J.
    pub load_work: f64,
    /// max |u_x|, |u_y|, |u_z| over the nodes in m.
    pub largest_displacement: Vector,
    /// The forces of the foundation; `None` without contact.
    pub contact: Option<ContactResultants>,
}

/// Forces of the foundation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactResultants {
    /// Total normal contact force Σ|Rⁱ|λ_ν in N.
    pub normal_force: f64,
    /// Total tangential multiplier force Σ|Rⁱ|λ_t in N; the foundation acts with its opposite.
    /// `None` without friction, and for several faces together.
    pub tangential_force: Option<[f64; 2]>,
    /// Force of the foundation on the body in N.
    pub contact_force: Vector,
    /// max λ_ν in Pa.
    pub largest_pressure: f64,
}

/// What the foundation of one of several contact faces does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceResultants {
    /// Forces and the largest pressure.
    pub contact: ContactResultants,
    /// Moment of the foundation's force about the origin in N·m.
    pub moment: Vector,
    /// Numbers of open, sticking and slipping panes.
    pub zone_counts: [usize; 3],
}

impl Resultants {
    /// Sums the forces on the body. The reaction at a held component is the internal force there
    /// minus what loads and contact already contribute.
    pub(super) fn new(
        solved: &Solved<'_>,
        displacement: &[Vector],
        applied: &[Vector],
        internal: &[Vector],
    ) -> Self {
        let contact = match &solved.contact {
            Some(contact) => {
                contact_forces(solved, contact, 0..contact.coupling.layout.n_panes())
            }
            None => vec![[0.0; 3]; applied.len()],
        };
        let mut clamp = vec![[0.0; 3]; applied.len()];
        for (node, dofs) in solved.system.dofs.dof.iter().enumerate() {
            for component in (0..3).filter(|&c| dofs[c].is_none()) {
                clamp[node][component] =
                    internal[node][component] - applied[node][component] - contact[node][component];
            }
        }
        let sums = [&contact, applied, &clamp].map(|f| total(solved, f));
        let mut stiffness_u = vec![0.0; solved.solution.displacement.len()];
        solved
            .system
            .stiffness
            .mul(&solved.solution.displacement, &mut stiffness_u);
        Self {
            applied_force: sums[1].0.into(),
            clamp_force: sums[2].0.into(),
            moments: sums.map(|(_, moment)| moment.into()),
            force_imbalance: imbalance(sums.map(|(force, _)| force)),
            moment_imbalance: imbalance(sums.map(|(_, moment)| moment)),
            strain_energy: 0.5 * dot(&solved.solution.displacement, &stiffness_u),
            load_work: dot(&solved.system.load, &solved.solution.displacement),
            largest_displacement: std::array::from_fn(|c| {
                displacement
                    .iter()
                    .fold(0.0, |most: f64, u| most.max(u[c].abs()))
            }),
            contact: solved
                .contact
                .as_ref()
                .map(|c| ContactResultants::new(solved, c, sums[0].0.into())),
        }
    }
}

impl ContactResultants {
    /// Those of all faces; tangential forces of several faces, each in axes of its own, have no sum.
    fn new(solved: &Solved<'_>, contact: &SolvedContact<'_>, contact_force: Vector) -> Self {
        let panes = 0..contact.coupling.layout.n_panes();
        let all = Self::of_panes(solved, contact, panes, contact_force);
        match contact.state.surface.faces.as_slice() {
            [_] => all,
            _ => Self {
                tangential_force: None,
                ..all
            },
        }
    }

    fn of_panes(
        solved: &Solved<'_>,
        contact: &SolvedContact<'_>,
        panes: Range<usize>,
        contact_force: Vector,
    ) -> Self {
        let multiplier = &solved.solution.multiplier;
        let area = &contact.state.surface.pane_area;
        let layout = contact.coupling.layout;
        let (normal, tangential) = layout.split(multiplier);
        let weighted = |stress: &dyn Fn(usize) -> f64| -> f64 {
            panes.clone().map(|i| area[i] * stress(i)).sum()
        };
        let has_friction = panes.end <= layout.n_pairs() && layout.has_friction();
        Self {
            normal_force: weighted(&|i| normal[i]),
            tangential_force: has_friction
                .then(|| [0, 1].map(|k| weighted(&|i| tangential[i][k]))),
            contact_force,
            largest_pressure: normal[panes.clone()].iter().copied().fold(0.0, f64::max),
        }
    }
}

impl FaceResultants {
    /// Those of each of several contact faces; empty for one, whose are those of the whole.
    pub(super) fn of_faces(solved: &Solved<'_>, panes: &[PaneState]) -> Vec<Self> {
        let Some(contact) = &solved.contact else {
            return Vec::new();
        };
        let faces = &contact.state.surface.faces;
        if faces.len() == 1 {
            return Vec::new();
        }
        let of_face = |face: &SurfaceFace| {
            let forces = contact_forces(solved, contact, face.panes.clone());
            let (force, moment) = total(solved, &forces);
            let count = |zone: Zone| {
                let panes = panes[face.panes.clone()].iter();
                panes.filter(|pane| pane.zone == zone).count()
            };
            Self {
                contact: ContactResultants::of_panes(
                    solved,
                    contact,
                    face.panes.clone(),
                    force.into(),
                ),
                moment: moment.into(),
                zone_counts: [Zone::Open, Zone::Stick, Zone::Slip].map(count),
            }
        };
        faces.iter().map(of_face).collect()
    }
}

/// Nodal forces of the foundation on some panes of the body, −∫ φ (λ_ν ν + λ_t1 t₁ + λ_t2 t₂), in N, at free and
/// held nodes alike.
fn contact_forces(
    solved: &Solved<'_>,
    contact: &SolvedContact<'_>,
    panes: Range<usize>,
) -> Vec<Vector> {
    let surface = contact.state.surface;
    let frame = &contact.state.interface.frame;
    let multiplier = &solved.solution.multiplier;
    let layout = contact.coupling.layout;
    let mut forces = vec![[0.0; 3]; solved.mesh.coordinates.len()];
    for pane in panes {
        let tangential = layout.pair(multiplier, pane);
        for (local, weight) in surface.pane_weights(pane) {
            let stress = frame.vector(local, multiplier[layout.normal(pane)], tangential);
            for c in 0..3 {
                forces[surface.nodes[local]][c] -= weight * surface.pane_area[pane] * stress[c];
            }
        }
    }
    forces
}

/// Sum of nodal forces and of their moments about the origin.
fn total(solved: &Solved<'_>, forces: &[Vector]) -> (Vector3<f64>, Vector3<f64>) {
    forces.iter().zip(&solved.mesh.coordinates).fold(
        (Vector3::zeros(), Vector3::zeros()),
        |(force, moment), (f, x)| {
            let f = Vector3::from(*f);
            (force + f, moment + Vector3::from(*x).cross(&f))
        },
    )
}

fn imbalance(parts: [Vector3<f64>; 3]) -> f64 {
    let size: f64 = parts.iter().map(Vector3::norm).sum();
    if size == 0.0 {
        0.0
    } else {
        parts.iter().sum::<Vector3<f64>>().norm() / size
    }
}

/// Von Mises stress in Pa of a Voigt stress (xx, yy, zz, yz, xz, xy).
#[must_use]
pub fn von_mises(stress: &[f64; 6]) -> f64 {
    let [xx, yy, zz, yz, xz, xy] = *stress;
    let direct = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    (0.5 * direct + 3.0 * (yz * yz + xz * xz + xy * xy)).sqrt()
}

//! Forces, moments, energies and extreme values of a solution.

use std::ops::Range;

use nalgebra::Vector3;

use super::{
    PaneState, Solved, SolvedContact, Zone,
    nodal_forces::{NodalForces, contact_forces, total},
};
use crate::{
    linalg::dot,
    mesh::{Mesh, SurfaceFace},
};

/// A vector in the global axes.
pub type Vector = [f64; 3];

/// Forces, moments about the origin, energies and extreme values of a solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resultants {
    /// Applied loads in N.
    pub applied_force: Vector,
    /// Reaction of the clamps in N.
    pub clamp_force: Vector,
    /// Force of the springs in N; `None` without springs.
    pub spring_force: Option<Vector>,
    /// Moments about the origin in N·m, in the same order: contact, applied, clamp.
    pub moments: [Vector; 3],
    /// ‖Σ forces‖ over the sum of the norms of all nodal forces, so that loads which balance each other do not vanish from it; of a body
    /// that bears none, over √ε ‖|A||u|‖₁.
    pub force_imbalance: f64,
    /// ‖Σ moments‖ over the sum of the norms of the moments of all nodal forces.
    pub moment_imbalance: f64,
    /// Strain energy ½ a(u, u) of body and springs in J.
    pub strain_energy: f64,
    /// The springs' part of it, ½ ∫ u·K u, in J; `None` without springs.
    pub spring_energy: Option<f64>,
    /// Work of the loads l(u) in J.
    pub load_work: f64,
    /// Work of the clamps' reactions on prescribed displacements in J; `None` where all clamps hold at zero.
    pub clamp_work: Option<f64>,
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
    /// Numbers of open, sticking and slipping panes.
    pub zone_counts: [usize; 3],
}

impl Resultants {
    /// Sums the forces on the body; `terms` are what cancels in the equilibrium.
    pub(super) fn new(
        solved: &Solved<'_>,
        terms: &[f64],
        displacement: &[Vector],
        forces: &NodalForces,
        internal: &[Vector],
    ) -> Self {
        let parts = [&forces.contact, &forces.applied, &forces.clamp];
        let sums = parts.map(|f| total(solved.mesh, f));
        let springs = forces.springs.as_ref();
        let springs = springs.map(|springs| total(solved.mesh, springs));
        let all = || sums.iter().chain(&springs);
        let nodal = parts.into_iter().chain(&forces.springs);
        let [forces_size, moments_size] = nodal
            .map(|f| sizes(solved.mesh, f))
            .fold([0.0; 2], |sum, s| [sum[0] + s[0], sum[1] + s[1]]);
        // Where nothing bears a force, what rounding of u would make of it.
        let rounding = f64::EPSILON.sqrt() * terms.iter().sum::<f64>();
        let places = solved.mesh.coordinates.iter();
        let farthest = places.fold(0.0, |most: f64, x| most.max(Vector3::from(*x).norm()));
        let works = Works::new(solved, displacement, forces, internal);
        Self {
            applied_force: sums[1].0.into(),
            clamp_force: sums[2].0.into(),
            spring_force: springs.map(|(force, _)| force.into()),
            moments: sums.map(|(_, moment)| moment.into()),
            force_imbalance: imbalance(all().map(|(force, _)| force), forces_size.max(rounding)),
            moment_imbalance: imbalance(
                all().map(|(_, moment)| moment),
                moments_size.max(farthest * rounding),
            ),
            strain_energy: works.strain_energy,
            spring_energy: works.of_springs.map(|work| -0.5 * work),
            load_work: works.of_loads,
            clamp_work: works.of_clamps,
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

/// Works in J.
struct Works {
    strain_energy: f64,
    of_loads: f64,
    of_clamps: Option<f64>,
    /// Of their forces on the body.
    of_springs: Option<f64>,
}

impl Works {
    /// Over the free degrees of freedom where the others do not move.
    fn new(
        solved: &Solved<'_>,
        displacement: &[Vector],
        forces: &NodalForces,
        internal: &[Vector],
    ) -> Self {
        let system = solved.system;
        let work = |forces: &[Vector]| dot(forces.as_flattened(), displacement.as_flattened());
        let of_springs = forces.springs.as_ref().map(|springs| work(springs));
        if system.dofs.prescribed.is_some() {
            return Self {
                strain_energy: 0.5 * (work(internal) - of_springs.unwrap_or(0.0)),
                of_springs,
                of_loads: work(&forces.applied),
                of_clamps: Some(work(&forces.clamp)),
            };
        }
        let free = &solved.solution.displacement;
        if system.floating.is_some() {
            // A rigid motion, which has no energy, takes its digits from u·A u, but not from the work of forces in balance.
            return Self {
                strain_energy: 0.5 * (work(&forces.applied) + work(&forces.contact)),
                of_springs,
                of_loads: dot(&system.load, free),
                of_clamps: None,
            };
        }
        let mut stiffness_u = vec![0.0; free.len()];
        system.stiffness.mul(free, &mut stiffness_u);
        Self {
            strain_energy: 0.5 * dot(free, &stiffness_u),
            of_loads: dot(&system.load, free),
            of_clamps: None,
            of_springs,
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
            tangential_force: has_friction.then(|| [0, 1].map(|k| weighted(&|i| tangential[i][k]))),
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
            let (force, _) = total(solved.mesh, &forces);
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
                zone_counts: [Zone::Open, Zone::Stick, Zone::Slip].map(count),
            }
        };
        faces.iter().map(of_face).collect()
    }
}

fn imbalance<'a>(parts: impl Iterator<Item = &'a Vector3<f64>>, size: f64) -> f64 {
    if size == 0.0 {
        0.0
    } else {
        parts.sum::<Vector3<f64>>().norm() / size
    }
}

/// Sums of the norms of nodal forces and of their moments about the origin.
fn sizes(mesh: &Mesh, forces: &[Vector]) -> [f64; 2] {
    let nodes = forces.iter().zip(&mesh.coordinates);
    nodes.fold([0.0; 2], |[force, moment], (f, x)| {
        let f = Vector3::from(*f);
        [
            force + f.norm(),
            moment + Vector3::from(*x).cross(&f).norm(),
        ]
    })
}

/// Von Mises stress in Pa of a Voigt stress (xx, yy, zz, yz, xz, xy).
#[must_use]
pub fn von_mises(stress: &[f64; 6]) -> f64 {
    let [xx, yy, zz, yz, xz, xy] = *stress;
    let direct = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    (0.5 * direct + 3.0 * (yz * yz + xz * xz + xy * xy)).sqrt()
}

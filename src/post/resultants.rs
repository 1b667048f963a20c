use nalgebra::Vector3;

use super::Solved;
use crate::{elasticity::load_vector, scene::Frame};

/// A vector in the global axes.
pub type Vector = [f64; 3];

/// Forces, moments about the origin, energies and extreme values of a solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resultants {
    /// Total normal contact force Σ|Rⁱ|λ_ν in N.
    pub normal_force: f64,
    /// Total tangential multiplier force Σ|Rⁱ|λ_t in N; the foundation acts with its opposite.
    pub tangential_force: [f64; 2],
    /// Force of the foundation on the body in N.
    pub contact_force: Vector,
    /// Applied surface loads in N.
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
    /// max λ_ν in Pa.
    pub largest_pressure: f64,
}

impl Resultants {
    /// Sums the forces on the body. The reaction at a held component is the internal force there
    /// minus what loads and contact already contribute.
    pub(super) fn new(
        solved: &Solved<'_>,
        frame: &Frame,
        displacement: &[Vector],
        internal: &[Vector],
    ) -> Self {
        let applied = load_vector(solved.mesh, &solved.scene.tractions);
        let contact = contact_forces(solved, frame);
        let mut clamp = vec![[0.0; 3]; applied.len()];
        for (node, dofs) in solved.system.dofs.dof.iter().enumerate() {
            for component in (0..3).filter(|&c| dofs[c].is_none()) {
                clamp[node][component] =
                    internal[node][component] - applied[node][component] - contact[node][component];
            }
        }
        let sums = [&contact, &applied, &clamp].map(|f| total(solved, f));
        let m = solved.system.coupling.n_panes;
        let area = &solved.mesh.contact.pane_area;
        let weighted = |offset: usize, stride: usize| -> f64 {
            (0..m)
                .map(|i| area[i] * solved.solution.multiplier[offset + stride * i])
                .sum()
        };
        let mut stiffness_u = vec![0.0; solved.solution.displacement.len()];
        solved
            .system
            .stiffness
            .mul(&solved.solution.displacement, &mut stiffness_u);
        Self {
            normal_force: weighted(0, 1),
            tangential_force: [weighted(m, 2), weighted(m + 1, 2)],
            contact_force: sums[0].0.into(),
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
            largest_pressure: solved.solution.multiplier[..m]
                .iter()
                .copied()
                .fold(0.0, f64::max),
        }
    }
}

/// Nodal forces of the foundation on the body, −∫ φ (λ_ν ν + λ_t1 t₁ + λ_t2 t₂), in N, at free and
/// held nodes alike.
fn contact_forces(solved: &Solved<'_>, frame: &Frame) -> Vec<Vector> {
    let surface = &solved.mesh.contact;
    let m = solved.system.coupling.n_panes;
    let mut forces = vec![[0.0; 3]; solved.mesh.coordinates.len()];
    for pane in 0..m {
        let stress = [
            solved.solution.multiplier[pane],
            solved.solution.multiplier[m + 2 * pane],
            solved.solution.multiplier[m + 2 * pane + 1],
        ];
        let vector = Vector3::from(frame.normal) * stress[0]
            + Vector3::from(frame.axis_1) * stress[1]
            + Vector3::from(frame.axis_2) * stress[2];
        for (local, weight) in surface.pane_weights(pane) {
            for c in 0..3 {
                forces[surface.nodes[local]][c] -= weight * surface.pane_area[pane] * vector[c];
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

fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum()
}

/// Von Mises stress in Pa of a Voigt stress (xx, yy, zz, yz, xz, xy).
#[must_use]
pub fn von_mises(stress: &[f64; 6]) -> f64 {
    let [xx, yy, zz, yz, xz, xy] = *stress;
    let direct = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    (0.5 * direct + 3.0 * (yz * yz + xz * xz + xy * xy)).sqrt()
}

//! Forces on the nodes of a solved body, by what they come from.

use std::ops::Range;

use nalgebra::Vector3;

use super::{Solved, SolvedContact, Vector};
use crate::{
    elasticity::{Loads, SpringMatrix},
    mesh::Mesh,
    scene::{InvalidValue, Scene},
};

/// Forces on the nodes of a body at rest in N, `[n_nodes]` each; they and the internal forces balance.
pub(super) struct NodalForces {
    /// Of all loads.
    pub(super) applied: Vec<Vector>,
    /// Of the foundation.
    pub(super) contact: Vec<Vector>,
    /// Of the springs; `None` where there are none.
    pub(super) springs: Option<Vec<Vector>>,
    /// Of the clamps.
    pub(super) clamp: Vec<Vector>,
}

impl NodalForces {
    /// Takes the forces apart, from the displacement in m and the internal forces in N, `[n_nodes]` both: the reaction at a
    /// held component is the internal force there minus what loads, contact and springs already contribute.
    ///
    /// # Errors
    /// A load that is not finite.
    pub(super) fn new(
        solved: &Solved<'_>,
        displacement: &[Vector],
        internal: &[Vector],
    ) -> Result<Self, InvalidValue> {
        let springs = SpringMatrix::of(solved.scene, solved.mesh)?;
        let springs = springs.map(|springs| opposite(springs.forces(displacement)));
        let applied = Loads::of(solved.scene).nodal_forces(solved.mesh)?;
        let contact = match &solved.contact {
            Some(contact) => contact_forces(solved, contact, 0..contact.coupling.layout.n_panes()),
            None => vec![[0.0; 3]; applied.len()],
        };
        let of_springs = |node: usize, c: usize| springs.as_ref().map_or(0.0, |f| f[node][c]);
        let mut clamp = vec![[0.0; 3]; applied.len()];
        for (node, dofs) in solved.system.dofs.dof.iter().enumerate() {
            for component in (0..3).filter(|&c| dofs[c].is_none()) {
                clamp[node][component] = internal[node][component]
                    - applied[node][component]
                    - contact[node][component]
                    - of_springs(node, component);
            }
        }
        Ok(Self {
            applied,
            contact,
            springs,
            clamp,
        })
    }
}

fn opposite(mut forces: Vec<Vector>) -> Vec<Vector> {
    let entries = forces.as_flattened_mut().iter_mut();
    entries.for_each(|force| *force = 0.0 - *force);
    forces
}

/// Nodal forces of the foundation on some panes of the body, −∫ φ (λ_ν ν + λ_t1 t₁ + λ_t2 t₂), in N, at free and
/// held nodes alike.
pub(super) fn contact_forces(
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
pub(super) fn total(mesh: &Mesh, forces: &[Vector]) -> (Vector3<f64>, Vector3<f64>) {
    forces.iter().zip(&mesh.coordinates).fold(
        (Vector3::zeros(), Vector3::zeros()),
        |(force, moment), (f, x)| {
            let f = Vector3::from(*f);
            (force + f, moment + Vector3::from(*x).cross(&f))
        },
    )
}

/// The force on the body from one clamp, spring, load or contact face.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceForce {
    /// The key of its source in the scene, such as `clamp.0`, `spring.0` or `traction.1`.
    pub source: String,
    /// Its face; empty for a box of nodes and for a body force.
    pub face: String,
    /// Resultant force on the body in N.
    pub force: Vector,
    /// Its moment about the origin of coordinates in N·m.
    pub moment: Vector,
}

/// The forces on the body by their sources, clamps and springs first; all of them sum to zero.
///
/// What holds a component of a node that several clamps hold counts for each of them in equal parts.
///
/// # Errors
/// A load that is not finite.
pub(super) fn by_source(
    solved: &Solved<'_>,
    displacement: &[Vector],
    forces: &NodalForces,
) -> Result<Vec<SourceForce>, InvalidValue> {
    let (scene, mesh) = (solved.scene, solved.mesh);
    let row = |source: String, face: &str, forces: &[Vector]| {
        let (force, moment) = total(mesh, forces);
        SourceForce {
            source,
            face: face.to_owned(),
            force: force.into(),
            moment: moment.into(),
        }
    };
    let mut rows = Vec::new();
    let shares = clamp_shares(scene, mesh, &forces.clamp);
    for (i, (clamp, share)) in scene.clamps.iter().zip(shares).enumerate() {
        let face = clamp.face.as_deref().unwrap_or_default();
        rows.push(row(format!("clamp.{i}"), face, &share));
    }
    for (i, spring) in scene.springs.iter().enumerate() {
        let matrix = SpringMatrix::sum([(i, spring)].into_iter(), mesh)?;
        let forces = opposite(matrix.forces(displacement));
        rows.push(row(format!("spring.{i}"), &spring.face, &forces));
    }
    let none = Loads::default();
    for (i, traction) in scene.tractions.iter().enumerate() {
        let tractions = std::slice::from_ref(traction);
        let forces = Loads { tractions, ..none }.nodal_forces(mesh)?;
        rows.push(row(format!("traction.{i}"), &traction.face, &forces));
    }
    for (i, pressure) in scene.pressures.iter().enumerate() {
        let pressures = std::slice::from_ref(pressure);
        let forces = Loads { pressures, ..none }.nodal_forces(mesh)?;
        rows.push(row(format!("pressure.{i}"), &pressure.face, &forces));
    }
    if scene.body_force.is_some() {
        let body_force = scene.body_force.as_ref();
        let forces = Loads { body_force, ..none }.nodal_forces(mesh)?;
        rows.push(row("body_force".into(), "", &forces));
    }
    if let Some(contact) = &solved.contact {
        let faces = contact.state.surface.faces.iter();
        for (face, entry) in faces.zip(scene.contact_order()) {
            let of_face = contact_forces(solved, contact, face.panes.clone());
            let on = &scene.contacts[entry].face;
            rows.push(row(scene.contact_key(entry), on, &of_face));
        }
    }
    Ok(rows)
}

/// The nodal forces of each clamp.
fn clamp_shares(scene: &Scene, mesh: &Mesh, forces: &[Vector]) -> Vec<Vec<Vector>> {
    let holds: Vec<Vec<[bool; 3]>> = scene
        .clamps
        .iter()
        .map(|clamp| mesh.held_by(std::slice::from_ref(clamp)))
        .collect();
    let share = |holds_here: &Vec<[bool; 3]>| -> Vec<Vector> {
        let part = |node: usize, c: usize| {
            if holds_here[node][c] {
                let count = holds.iter().filter(|holds| holds[node][c]).count();
                forces[node][c] / count as f64
            } else {
                0.0
            }
        };
        let nodes = 0..forces.len();
        nodes
            .map(|node| std::array::from_fn(|c| part(node, c)))
            .collect()
    };
    holds.iter().map(share).collect()
}

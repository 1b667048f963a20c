//! Forces on the nodes of a solved body by what they come from, their sums, moments and works, and extreme values.

use std::ops::Range;

use nalgebra::Vector3;

use super::{PaneState, Solved, SolvedContact, Zone};
use crate::{
    elasticity::{Loads, SpringMatrix, tool_loads},
    linalg::{dot, larger},
    mesh::{Mesh, SurfaceFace},
    scene::{Clamp, InvalidValue, Scene},
};

/// Forces, moments about the origin, energies and extreme values of a solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resultants {
    /// Applied loads in N.
    pub applied_force: [f64; 3],
    /// Reaction of the clamps in N.
    pub clamp_force: [f64; 3],
    /// Force of the springs in N; `None` without springs.
    pub spring_force: Option<[f64; 3]>,
    /// Moments about the origin in N·m, in the same order: contact, applied, clamp.
    pub moments: [[f64; 3]; 3],
    /// ‖Σ forces‖ over the sum of the norms of all nodal forces, so that loads which balance each other do not vanish from it; of a body
    /// that bears none, over √ε_M ‖|A||u|‖₁.
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
    /// max |u| over the nodes in m.
    pub largest_displacement: f64,
    /// max |u_x|, |u_y|, |u_z| over the nodes in m.
    pub largest_displacement_along: [f64; 3],
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
    pub contact_force: [f64; 3],
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
        displacement: &[[f64; 3]],
        forces: &NodalForces,
        internal: &[[f64; 3]],
    ) -> Self {
        let parts = [&forces.contact, &forces.applied, &forces.clamp];
        let sums = parts.map(|f| total(solved.mesh, f));
        let springs = forces.springs.as_ref();
        let springs = springs.map(|forces| total(solved.mesh, forces));
        let nodal = || {
            let others = [&forces.springs, &forces.tools, &forces.joints];
            parts.into_iter().chain(others.into_iter().flatten())
        };
        // Where nothing bears a force, what rounding of u would make of it.
        let rounding = f64::EPSILON.sqrt() * terms.iter().sum::<f64>();
        let places = solved.mesh.coordinates.iter();
        let farthest = places.fold(0.0, |most: f64, x| most.max(Vector3::from(*x).norm()));
        let imbalances = solved.mesh.body_ranges().into_iter().map(|body| {
            let parts = nodal().map(|f| total_of(solved.mesh, f, body.nodes.clone()));
            let (forces, moments): (Vec<_>, Vec<_>) = parts.unzip();
            let [forces_size, moments_size] = nodal()
                .map(|f| sizes(solved.mesh, f, body.nodes.clone()))
                .fold([0.0; 2], |sum, s| [sum[0] + s[0], sum[1] + s[1]]);
            [
                imbalance(forces.iter(), forces_size.max(rounding)),
                imbalance(moments.iter(), moments_size.max(farthest * rounding)),
            ]
        });
        let [force_imbalance, moment_imbalance] = imbalances.fold([0.0; 2], |most, body| {
            [0, 1].map(|k| larger(most[k], body[k]))
        });
        let (strain_energy, load_work, clamp_work, spring_work) =
            works(solved, displacement, forces, internal);
        Self {
            applied_force: sums[1].0.into(),
            clamp_force: sums[2].0.into(),
            spring_force: springs.map(|(force, _)| force.into()),
            moments: sums.map(|(_, moment)| moment.into()),
            force_imbalance,
            moment_imbalance,
            strain_energy,
            spring_energy: spring_work.map(|work| -0.5 * work),
            load_work,
            clamp_work,
            largest_displacement: {
                let lengths = displacement.iter().map(|[x, y, z]| x.hypot(*y).hypot(*z));
                lengths.fold(0.0, f64::max)
            },
            largest_displacement_along: std::array::from_fn(|c| {
                displacement
                    .iter()
                    .fold(0.0, |most: f64, u| most.max(u[c].abs()))
            }),
            contact: solved.contact.as_ref().map(|contact| {
                let surface = contact.state.surface;
                let on_first = match &surface.opposite {
                    None => sums[0].0,
                    Some(_) => {
                        let faces = 0..surface.faces.len();
                        faces.map(|face| forces.on_first(solved, face)).sum()
                    }
                };
                ContactResultants::new(solved, contact, on_first.into())
            }),
        }
    }
}

/// The strain energy and the works of the loads, of the clamps that move and of the forces of the springs on the body in J, over the free
/// degrees of freedom where the others do not move.
fn works(
    solved: &Solved<'_>,
    displacement: &[[f64; 3]],
    forces: &NodalForces,
    internal: &[[f64; 3]],
) -> (f64, f64, Option<f64>, Option<f64>) {
    let system = solved.system;
    let work = |forces: &[[f64; 3]]| dot(forces.as_flattened(), displacement.as_flattened());
    let of_springs = forces.springs.as_ref().map(|springs| work(springs));
    if system.dofs.prescribed.is_some() {
        let strain_energy = 0.5 * (work(internal) - of_springs.unwrap_or(0.0));
        let moves = solved.scene.clamps.iter().any(Clamp::is_moved);
        let of_clamps = moves.then(|| work(&forces.clamp));
        let loads = tool_loads(solved.scene, solved.mesh).unwrap_or_default();
        let moved = system.dofs.tool_rows(&solved.solution.displacement);
        let load_work = work(&forces.applied) + dot(loads.as_flattened(), moved.as_flattened());
        return (strain_energy, load_work, of_clamps, of_springs);
    }
    let free = &solved.solution.displacement;
    let strain_energy = if system.rigid_modes.is_some() {
        // A rigid motion, which has no energy, takes its digits from u·A u, but not from the work of forces in balance.
        let of_tools = forces.tools.as_ref().map_or(0.0, |tools| work(tools));
        0.5 * (work(&forces.applied) + work(&forces.contact) + of_tools)
    } else {
        let mut stiffness_u = vec![0.0; free.len()];
        system.stiffness.mul(free, &mut stiffness_u);
        0.5 * dot(free, &stiffness_u)
    };
    (strain_energy, dot(&system.load, free), None, of_springs)
}

impl ContactResultants {
    /// Those of all faces; tangential forces of several faces, each in axes of its own, have no sum.
    fn new(solved: &Solved<'_>, contact: &SolvedContact<'_>, contact_force: [f64; 3]) -> Self {
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
        contact_force: [f64; 3],
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
    pub(super) fn of_faces(
        solved: &Solved<'_>,
        panes: &[PaneState],
        forces: &NodalForces,
    ) -> Vec<Self> {
        let Some(contact) = &solved.contact else {
            return Vec::new();
        };
        let faces = &contact.state.surface.faces;
        if faces.len() == 1 {
            return Vec::new();
        }
        let of_face = |(number, face): (usize, &SurfaceFace)| {
            let force = forces.on_first(solved, number);
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
        faces.iter().enumerate().map(of_face).collect()
    }
}

fn imbalance<'a>(parts: impl Iterator<Item = &'a Vector3<f64>>, size: f64) -> f64 {
    if size == 0.0 {
        0.0
    } else {
        parts.sum::<Vector3<f64>>().norm() / size
    }
}

/// Sums of the norms of forces on some nodes and of their moments about the origin.
fn sizes(mesh: &Mesh, forces: &[[f64; 3]], nodes: Range<usize>) -> [f64; 2] {
    let nodes = forces[nodes.clone()].iter().zip(&mesh.coordinates[nodes]);
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

/// Forces on the nodes of a body at rest in N, `[n_nodes]` each; they and the internal forces balance.
pub(super) struct NodalForces {
    /// Of all loads.
    pub(super) applied: Vec<[f64; 3]>,
    /// Of the foundation.
    pub(super) contact: Vec<[f64; 3]>,
    /// Force in N and moment about the origin in N·m of each contact face on the body with its panes and on the one opposite,
    /// `[n_contact_faces]`.
    of_faces: Vec<[(Vector3<f64>, Vector3<f64>); 2]>,
    /// Of the springs; `None` where there are none.
    pub(super) springs: Option<Vec<[f64; 3]>>,
    /// Of the clamps.
    pub(super) clamp: Vec<[f64; 3]>,
    /// Of tools that faces are bonded to; `None` where there are none.
    pub(super) tools: Option<Vec<[f64; 3]>>,
    /// Of the joints of glued faces; `None` where there are none.
    joints: Option<Vec<[f64; 3]>>,
    /// Force in N and moment about the origin in N·m of each joint on the body of the first face, `[n_contacts]`; zero of faces that touch.
    of_joints: Vec<(Vector3<f64>, Vector3<f64>)>,
}

impl NodalForces {
    /// Takes the forces apart, from the displacement in m and the internal forces in N, `[n_nodes]` both: the reaction at a
    /// held component is the internal force there minus what loads, contact and springs already contribute.
    ///
    /// # Errors
    /// A load that is not finite.
    pub(super) fn new(
        solved: &Solved<'_>,
        displacement: &[[f64; 3]],
        internal: &[[f64; 3]],
    ) -> Result<Self, InvalidValue> {
        let springs = SpringMatrix::of(solved.scene, solved.mesh)?;
        let springs = springs.map(|springs| opposite(springs.forces(displacement)));
        let applied = Loads::of(solved.scene).nodal_forces(solved.mesh)?;
        let contact = match &solved.contact {
            Some(contact) => {
                let panes = 0..contact.coupling.layout.n_panes();
                contact_forces(solved, contact, panes, [true; 2])
            }
            None => vec![[0.0; 3]; applied.len()],
        };
        let of_faces = solved.contact.iter().flat_map(|contact| {
            let faces = contact.state.surface.faces.iter();
            faces.map(|face| {
                [[true, false], [false, true]].map(|sides| {
                    let forces = contact_forces(solved, contact, face.panes.clone(), sides);
                    total(solved.mesh, &forces)
                })
            })
        });
        let of_faces = of_faces.collect();
        let of_springs = |node: usize, c: usize| springs.as_ref().map_or(0.0, |f| f[node][c]);
        let dofs = &solved.system.dofs;
        let mut clamp = vec![[0.0; 3]; applied.len()];
        for (node, clamp) in clamp.iter_mut().enumerate() {
            *clamp = std::array::from_fn(|c| {
                internal[node][c] - applied[node][c] - contact[node][c] - of_springs(node, c)
            });
        }
        let nothing = (Vector3::zeros(), Vector3::zeros());
        let mut of_joints = vec![nothing; solved.scene.contacts.len()];
        let joints = joint_forces(solved, &mut clamp, &mut of_joints);
        // What balances at free components is rounding.
        for (force, dofs) in clamp.iter_mut().zip(&dofs.dof) {
            *force = std::array::from_fn(|c| if dofs[c].is_none() { force[c] } else { 0.0 });
        }
        let tied = &dofs.tied;
        let tools = (!tied.is_empty()).then(|| {
            let mut tools = vec![[0.0; 3]; clamp.len()];
            for &node in tied.keys() {
                tools[node] = std::mem::take(&mut clamp[node]);
            }
            tools
        });
        Ok(Self {
            applied,
            contact,
            of_faces,
            springs,
            clamp,
            tools,
            joints,
            of_joints,
        })
    }

    /// The force in N of a contact face on the body, of two that touch each other on that of the first face.
    fn on_first(&self, solved: &Solved<'_>, number: usize) -> Vector3<f64> {
        let surface = solved.mesh.contact.as_ref().expect("a contact face");
        let of_pair = &solved.scene.contacts[solved.scene.contact_order()[number]];
        let face = &surface.faces[number];
        let on_second = solved.mesh.is_on_second_face(of_pair, surface, face);
        self.of_faces[number][usize::from(on_second)].0
    }
}

/// The forces of the joints of glued faces, in all and of each: what the forces `left` on a node that follows others lack of balance, which
/// acts on these by their shares. They are taken from what is left. A joint gets what acts on the body that is followed, and the opposite.
fn joint_forces(
    solved: &Solved<'_>,
    left: &mut [[f64; 3]],
    of_joints: &mut [(Vector3<f64>, Vector3<f64>)],
) -> Option<Vec<[f64; 3]>> {
    let (scene, mesh) = (solved.scene, solved.mesh);
    let bodies = 0..scene.bodies.len();
    let prefixes: Vec<String> = bodies.map(|body| scene.face_prefix(body)).collect();
    let mut all = vec![[0.0; 3]; left.len()];
    for run in mesh.glued_runs() {
        let own = run[0].node;
        let follows = |c: usize| run[0].axes[c] && solved.system.dofs.is_glued(own, c);
        let here = [0, 1, 2].map(|c| if follows(c) { left[own][c] } else { 0.0 });
        let others = run.iter().flat_map(|glued| {
            let shares = glued.shares.iter();
            shares.map(|(node, share)| (glued.entry, *node, -share))
        });
        for (entry, node, share) in others.chain([(run[0].entry, own, 1.0)]) {
            let force = here.map(|part| share * part);
            for c in 0..3 {
                left[node][c] -= force[c];
                all[node][c] += force[c];
            }
            let (force, at) = (Vector3::from(force), Vector3::from(mesh.coordinates[node]));
            let first = scene.contacts[entry].faces()[0];
            let [is_first, is_opposite] =
                [node, own].map(|node| first.starts_with(&prefixes[mesh.body_of_node(node)]));
            if is_first == is_opposite {
                continue;
            }
            let sign = if is_first { 1.0 } else { -1.0 };
            of_joints[entry].0 += sign * force;
            of_joints[entry].1 += sign * at.cross(&force);
        }
    }
    (!mesh.glued.is_empty()).then_some(all)
}

fn opposite(mut forces: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    let entries = forces.as_flattened_mut().iter_mut();
    entries.for_each(|force| *force = 0.0 - *force);
    forces
}

/// Nodal forces on some panes of the body, −∫ φ (λ_ν ν + λ_t1 t₁ + λ_t2 t₂), and opposite ones on the body that these touch, in N, at
/// free and held nodes alike: the side with panes, the other one, or both.
fn contact_forces(
    solved: &Solved<'_>,
    contact: &SolvedContact<'_>,
    panes: Range<usize>,
    [own, other]: [bool; 2],
) -> Vec<[f64; 3]> {
    let surface = contact.state.surface;
    let frame = &contact.state.interface.frame;
    let multiplier = &solved.solution.multiplier;
    let layout = contact.coupling.layout;
    let mut forces = vec![[0.0; 3]; solved.mesh.coordinates.len()];
    for pane in panes {
        let tangential = layout.pair(multiplier, pane);
        let stress = |local| frame.vector(local, multiplier[layout.normal(pane)], tangential);
        for (local, weight) in surface.pane_weights(pane).filter(|_| own) {
            let stress = stress(local);
            for c in 0..3 {
                forces[surface.nodes[local]][c] -= weight * surface.pane_area[pane] * stress[c];
            }
        }
        for (local, node, integral) in surface.products(pane).iter().filter(|_| other) {
            let stress = stress(*local);
            for c in 0..3 {
                forces[*node][c] += integral * stress[c];
            }
        }
    }
    forces
}

/// Sum of nodal forces and of their moments about the origin.
fn total(mesh: &Mesh, forces: &[[f64; 3]]) -> (Vector3<f64>, Vector3<f64>) {
    total_of(mesh, forces, 0..mesh.coordinates.len())
}

/// The same of some nodes.
fn total_of(mesh: &Mesh, forces: &[[f64; 3]], nodes: Range<usize>) -> (Vector3<f64>, Vector3<f64>) {
    let nodes = forces[nodes.clone()].iter().zip(&mesh.coordinates[nodes]);
    nodes.fold(
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
    pub force: [f64; 3],
    /// Its moment about the origin of coordinates in N·m.
    pub moment: [f64; 3],
}

/// The forces on the body by their sources, clamps and springs first; all of them sum to zero.
///
/// What holds a component of a node that several clamps hold counts for each of them in equal parts.
///
/// # Errors
/// A load that is not finite.
pub(super) fn by_source(
    solved: &Solved<'_>,
    displacement: &[[f64; 3]],
    forces: &NodalForces,
) -> Result<Vec<SourceForce>, InvalidValue> {
    let (scene, mesh) = (solved.scene, solved.mesh);
    let of_total =
        |source: String, face: &str, (force, moment): (Vector3<f64>, Vector3<f64>)| SourceForce {
            source,
            face: face.to_owned(),
            force: force.into(),
            moment: moment.into(),
        };
    let row = |source: String, face: &str, forces: &[[f64; 3]]| {
        of_total(source, face, total(mesh, forces))
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
    for load in scene.face_loads() {
        let forces = Loads::from(load).nodal_forces(mesh)?;
        rows.push(row(load.key(), load.part().face, &forces));
    }
    let bonded = scene.tools.iter().enumerate();
    for (i, tool) in bonded.filter(|(_, tool)| tool.face.is_some()) {
        let tied = solved.system.dofs.tied.iter();
        let mut of_tool = vec![[0.0; 3]; mesh.coordinates.len()];
        for (node, _) in tied.filter(|(_, point)| point.tool == i) {
            of_tool[*node] = forces.tools.as_ref().map_or([0.0; 3], |all| all[*node]);
        }
        let face = tool.face.as_deref().unwrap_or_default();
        rows.push(row(format!("tool.{i}"), face, &of_tool));
    }
    if scene.body_force.is_some() {
        let weight = Loads {
            body_force: scene.body_force.as_ref(),
            ..Loads::default()
        };
        rows.push(row("body_force".into(), "", &weight.nodal_forces(mesh)?));
    }
    if let Some(contact) = &solved.contact {
        let faces = contact.state.surface.faces.iter().zip(&forces.of_faces);
        for ((face, [own, opposite]), entry) in faces.zip(scene.contact_order()) {
            let key = scene.contact_key(entry);
            let with_panes = mesh.face_with_panes(contact.state.surface, face);
            rows.push(of_total(key.clone(), with_panes, *own));
            let others = scene.contacts[entry].faces().into_iter();
            let others = others.filter(|other| *other != with_panes);
            rows.extend(others.map(|other| of_total(key.clone(), other, *opposite)));
        }
    }
    for (entry, pair) in scene.glued_pairs() {
        let (force, moment) = forces.of_joints[entry];
        for (face, sign) in pair.iter().zip([1.0, -1.0]) {
            let sums = (sign * force, sign * moment);
            rows.push(of_total(scene.contact_key(entry), face, sums));
        }
    }
    Ok(rows)
}

/// The nodal forces of each clamp.
fn clamp_shares(scene: &Scene, mesh: &Mesh, forces: &[[f64; 3]]) -> Vec<Vec<[f64; 3]>> {
    let holds: Vec<Vec<[bool; 3]>> = scene
        .clamps
        .iter()
        .map(|clamp| mesh.held_by(std::slice::from_ref(clamp)))
        .collect();
    let share = |holds_here: &Vec<[bool; 3]>| -> Vec<[f64; 3]> {
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

//! Prescribed displacements: their values at the nodes, and the forces that they take.

use super::{Element, MaterialField};
use crate::{
    mesh::Mesh,
    scene::{Component, Invalid, Scene, UNDEFINED, Written, place_words},
};

/// Share of the largest prescribed displacement by which two clamps may differ at a node that both hold: rounding of
/// formulas.
const AGREED: f64 = 1e-12;

/// The displacement u_c in m at which the clamps hold each node, `[n_nodes, 3]`, zero for free components; `None` where
/// all clamps hold at zero.
///
/// # Errors
/// A formula that is not finite, two clamps that hold one component of a node at different values.
pub fn prescribed_displacements(
    scene: &Scene,
    mesh: &Mesh,
) -> Result<Option<Vec<[f64; 3]>>, Invalid> {
    if !scene.clamps.iter().any(|clamp| clamp.is_moved()) {
        return Ok(None);
    }
    let mut found: Vec<[Option<Held>; 3]> = vec![[None; 3]; mesh.coordinates.len()];
    let mut conflicts = Vec::new();
    for (index, clamp) in scene.clamps.iter().enumerate() {
        for node in mesh.clamped_nodes(clamp) {
            let at = mesh.coordinates[node];
            for &component in &clamp.components {
                let value = clamp.value[component as usize].at(at);
                if !value.is_finite() {
                    return Err(not_finite(index, value, at));
                }
                let held = Held { index, value };
                match found[node][component as usize].get_or_insert(held) {
                    first if first.value == value => {}
                    first => conflicts.push((node, component, [*first, held])),
                }
            }
        }
    }
    let values: Vec<[f64; 3]> = found
        .iter()
        .map(|node| node.map(|held| held.map_or(0.0, |held| held.value)))
        .collect();
    let largest = values.as_flattened().iter();
    let largest = largest.fold(0.0, |most: f64, v| most.max(v.abs()));
    let contradicts = |held: &[Held; 2]| {
        let difference = (held[0].value - held[1].value).abs();
        difference > AGREED * largest.max(held[1].value.abs())
    };
    match conflicts.iter().find(|(_, _, held)| contradicts(held)) {
        None => Ok(Some(values)),
        Some(&(node, component, held)) => {
            Err(contradiction(mesh.coordinates[node], component, held))
        }
    }
}

/// What a clamp does to one component of a node.
#[derive(Debug, Clone, Copy)]
struct Held {
    /// The clamp's place in the scene.
    index: usize,
    /// u_c in m.
    value: f64,
}

/// The nodal forces ∫ σ(u_c) : ε(φ) in N, `[n_nodes]`, that hold the body where its held nodes are displaced by u_c in m
/// and no other node moves; over the free degrees of freedom this is A_fc u_c.
#[must_use]
pub fn forces_of_prescribed(
    mesh: &Mesh,
    material: &MaterialField<'_>,
    prescribed: &[[f64; 3]],
) -> Vec<[f64; 3]> {
    let mut forces = vec![[0.0; 3]; mesh.coordinates.len()];
    for t in 0..mesh.tetrahedra.len() {
        let local: Vec<[f64; 3]> = mesh.tetrahedron_nodes(t).map(|n| prescribed[n]).collect();
        if local.iter().all(|u| *u == [0.0; 3]) {
            continue;
        }
        let mut own = vec![nalgebra::Vector3::zeros(); local.len()];
        Element::of(mesh, t).add_internal_forces(material.tensor(t), &local, &mut own);
        for (node, force) in mesh.tetrahedron_nodes(t).zip(&own) {
            for c in 0..3 {
                forces[node][c] += force[c];
            }
        }
    }
    forces
}

fn not_finite(clamp: usize, value: f64, at: [f64; 3]) -> Invalid {
    Invalid {
        key: format!("clamp.{clamp}.value"),
        expected: "a formula that is finite at every held node".into(),
        found: format!("{} at {}", Written(&value), place_words(at)),
        help: UNDEFINED.into(),
    }
}

fn contradiction(at: [f64; 3], component: Component, held: [Held; 2]) -> Invalid {
    let [first, second] = held;
    Invalid {
        key: format!("clamp.{}.value", second.index),
        expected: format!(
            "{}, the displacement along {} of the node at {} in clamp.{}",
            Written(&first.value),
            component.name(),
            place_words(at),
            first.index
        ),
        found: Written(&second.value).to_string(),
        help: "a node that two clamps hold has one displacement: give both the same value there, or leave the axis out of the components of one".into(),
    }
}

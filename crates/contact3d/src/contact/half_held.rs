//! Nodes with multipliers of their own that clamps hold along one or two axes.

use super::ContactFrame;
use crate::{
    mesh::{ContactSurface, Mesh},
    scene::{ContactFeatures, Invalid, Scene, place_words},
};

/// Component of a unit vector up to which it is rounding: of the cosine of 90°, of a normal on a plane of symmetry.
const ROUNDING: f64 = 1e-12;

/// The components of ν, t₁ or t₂ along the free axes of a half-held node, without roundings: an axis along a held component has
/// no row in B, and one of roundings would be as good as parallel to another.
pub(super) fn free_of_rounding(direction: [f64; 3], dofs: &[Option<usize>; 3]) -> [f64; 3] {
    if dofs.iter().any(Option::is_none) {
        direction.map(|part| if part.abs() > ROUNDING { part } else { 0.0 })
    } else {
        direction
    }
}

/// Refuses nodes that clamps hold in part, with rows of ν, t₁ and t₂ along their free axes that are more than these: S would be
/// singular, and the stress along the held axis anything.
///
/// # Errors
/// The key of the contact, and the place of the first such node.
pub(super) fn refuse_dependent(
    scene: &Scene,
    features: &[ContactFeatures],
    mesh: &Mesh,
    surface: &ContactSurface,
    frame: &ContactFrame,
) -> Result<(), Invalid> {
    let held = mesh.held_nodes(scene);
    let faces = surface.faces.iter().zip(features);
    let rough = faces.filter(|(face, of)| face.is_nodal && of.friction.is_some());
    for (face, of) in rough {
        for local in face.nodes.clone() {
            let node = surface.nodes[local];
            if surface.carried_by(face, local).is_none() || held[node] == [false; 3] {
                continue;
            }
            let free = || (0..3).filter(|&c| !held[node][c]);
            let [first, second] = *frame.axes_at(local);
            let rows = [frame.normal_at(local), first, second];
            let felt = rows
                .iter()
                .filter(|row| free().any(|c| row[c].abs() > ROUNDING));
            if felt.count() > free().count() {
                return Err(Invalid {
                    key: format!("{}.multipliers", scene.contact_key(of.entry)),
                    expected: "nodes that carry no more conditions than they have displacements".into(),
                    found: format!(
                        "the node at {}, which a clamp holds along some axes, and whose normal and axes of friction lie along none of them",
                        place_words(mesh.coordinates[node])
                    ),
                    help: "write multipliers = \"panes\", which have nodes of their own; or give the face axes of friction along those of the clamp".into(),
                });
            }
        }
    }
    Ok(())
}

//! Contact nodes that clamps hold, in part or at a displacement.

use super::ContactFrame;
use crate::{
    elasticity::prescribed_displacements,
    mesh::{ContactSurface, Mesh},
    scene::{ContactFeatures, InvalidValue, Scene, Written, place_words},
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
) -> Result<(), InvalidValue> {
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
                return Err(InvalidValue {
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

/// Share of a displacement by which a held node may lie in the foundation: rounding of formulas.
const OF_FORMULAS: f64 = 1e-12;

/// Refuses clamps that push a contact node into the foundation, which gives way to nothing.
///
/// # Errors
/// The place of the first such node; what [`prescribed_displacements`] refuses.
pub(super) fn refuse_penetration(
    scene: &Scene,
    mesh: &Mesh,
    surface: &ContactSurface,
    frame: &ContactFrame,
    gap: Option<&[f64]>,
) -> Result<(), InvalidValue> {
    let Some(prescribed) = prescribed_displacements(scene, mesh)? else {
        return Ok(());
    };
    let held = mesh.held_nodes(scene);
    for (local, &node) in surface.nodes.iter().enumerate() {
        let normal = frame.normal_at(local);
        if !(0..3).all(|c| normal[c] == 0.0 || held[node][c]) {
            continue;
        }
        let towards = frame.normal_part(local, prescribed[node]);
        let gap = gap.map_or(0.0, |gap| gap[local]);
        let size = prescribed[node]
            .iter()
            .fold(gap, |most, u| most.max(u.abs()));
        if towards - gap > OF_FORMULAS * size {
            return Err(InvalidValue {
                key: "clamp".into(),
                expected: format!(
                    "at most the gap {} as the displacement of held contact nodes towards the foundation",
                    Written(&gap)
                ),
                found: format!("{} {}", Written(&towards), place_words(mesh.coordinates[node])),
                help: "the foundation is rigid: give such nodes a gap, move them less, or leave the axis towards it out of the clamp's components".into(),
            });
        }
    }
    Ok(())
}

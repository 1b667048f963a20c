//! Prescribed displacements of contact nodes.

use super::ContactFrame;
use crate::{
    elasticity::prescribed_displacements,
    mesh::{ContactSurface, Mesh},
    scene::{Invalid, Scene, Written, place_words},
};

/// Share of a displacement by which a held node may lie in the foundation: rounding of formulas.
const ROUNDING: f64 = 1e-12;

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
) -> Result<(), Invalid> {
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
        if towards - gap > ROUNDING * size {
            return Err(Invalid {
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

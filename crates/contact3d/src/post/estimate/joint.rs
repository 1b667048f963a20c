//! The stress that passes a joint of glued faces.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Vector3, Vector6};

use super::facing::{is_inside, seen_in};
use crate::{
    elasticity::{InternalForces, traction},
    mesh::Mesh,
    post::Solved,
};

/// Triangles of glued faces: the tetrahedron behind each, E/(1 − ν²) there in Pa, and those of the other face that may lie opposite.
pub(in crate::post) fn joint_sides(
    solved: &Solved<'_>,
) -> BTreeMap<usize, (usize, f64, Vec<usize>)> {
    let (scene, mesh) = (solved.scene, solved.mesh);
    let opposite = mesh.glued_facets(scene);
    let moduli: Vec<f64> = scene
        .materials()
        .map(|(_, m)| m.contact_modulus())
        .collect();
    let behind = mesh.behind(opposite.keys().copied());
    let sides = opposite.into_iter().zip(behind);
    let side = |((facet, others), behind): ((usize, BTreeSet<usize>), usize)| {
        let region = mesh.tetrahedron_region.get(behind).copied().unwrap_or(0);
        (
            facet,
            (behind, moduli[region], others.into_iter().collect()),
        )
    };
    sides.map(side).collect()
}

/// The triangle of the other face that a place in m on a boundary triangle lies opposite of; `None` where nothing is glued.
pub(in crate::post) fn opposite_in(
    mesh: &Mesh,
    sides: &BTreeMap<usize, (usize, f64, Vec<usize>)>,
    facet: usize,
    at: [f64; 3],
) -> Option<usize> {
    let mut others = sides.get(&facet)?.2.iter().copied();
    others.find(|other| is_inside(&seen_in(mesh, *other, at)))
}

/// The traction in Pa at a point of a boundary triangle with some outward unit normal that passes a joint there: the mean of those of both
/// sides, each with the stiffness of the other one; `None` where nothing is glued.
pub(super) fn traction_through(
    mesh: &Mesh,
    sides: &BTreeMap<usize, (usize, f64, Vec<usize>)>,
    (facet, at): (usize, [f64; 3]),
    normal: &Vector3<f64>,
    internal: &InternalForces,
) -> Option<Vector3<f64>> {
    let seen = opposite_in(mesh, sides, facet, at)?;
    let (behind, own, _) = sides.get(&facet)?;
    let (opposite, other, _) = sides.get(&seen)?;
    let on_other = stress(mesh, seen, *opposite, at, internal);
    let on_own = stress(mesh, facet, *behind, at, internal);
    Some(traction(
        normal,
        &((on_own * *other + on_other * *own) / (own + other)),
    ))
}

/// The stress in Pa of a quadratic tetrahedron at a point on or before one of its sides.
fn stress(
    mesh: &Mesh,
    facet: usize,
    behind: usize,
    at: [f64; 3],
    internal: &InternalForces,
) -> Vector6<f64> {
    let corners = mesh.tetrahedra[behind];
    let share = seen_in(mesh, facet, at);
    let nodes = mesh.facets[facet].into_iter().zip(share);
    let terms = nodes.filter_map(|(node, share)| {
        let corner = corners.iter().position(|corner| *corner == node)?;
        Some(Vector6::from(internal.corner_stress[behind][corner]) * share)
    });
    terms.sum()
}

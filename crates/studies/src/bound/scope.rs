//! The scenes whose error can be bounded.

use contact3d::{
    elasticity::SurfaceLoad,
    mesh::is_straight,
    post::Solved,
    reference::TETRAHEDRON_EDGES,
    scene::{ContactFeatures, InvalidValue, MultiplierSpace, Quantity, Scene},
};

/// Refuses what no stress of this kind balances.
pub(super) fn check(solved: &Solved<'_>) -> Result<(), InvalidValue> {
    let (scene, mesh) = (solved.scene, solved.mesh);
    scene.require_one_body("a bound of errors")?;
    let faces = scene.contact_features();
    let face_with = |is_meant: fn(&ContactFeatures) -> bool, key: &str| {
        let face = faces.iter().find(|face| is_meant(face));
        face.map(|face| format!("{}.{key}", scene.contact_key(face.entry)))
    };
    let turns = mesh.contact.as_ref().is_some_and(|surface| {
        surface.faces.iter().any(|face| {
            let first = surface.normal_at(face.nodes.start);
            let mut nodes = face.nodes.clone();
            nodes.any(|node| surface.normal_at(node) != first)
        })
    });
    let is_curved = mesh.mid_edges.as_ref().is_some_and(|mid_edges| {
        let mut both = mesh.tetrahedra.iter().zip(&mid_edges.tetrahedra);
        both.any(|(corners, middles)| {
            let [corners, middles] = [
                mesh.corners(corners).to_vec(),
                mesh.corners(middles).to_vec(),
            ];
            !is_straight(&corners, &TETRAHEDRON_EDGES, &middles)
        })
    });
    let named = |is_there: bool, key: &str| is_there.then(|| key.to_owned());
    let refusals = [
        (
            named(!scene.springs.is_empty(), "spring"),
            "no springs",
            "faces on springs, whose tractions are not linear",
        ),
        (
            named(!scene.tools.is_empty(), "tool"),
            "obstacles that rest",
            "a tool, whose motion the bound does not know",
        ),
        (
            varying_load(solved),
            "the same value on all of a face",
            "a formula, a moment or a part that cuts triangles, which linear tractions do not balance exactly",
        ),
        (
            face_with(|face| face.space == MultiplierSpace::Nodal, "multipliers"),
            "panes",
            "nodal multipliers, which no traction has as its moments",
        ),
        (
            face_with(|it| it.turning_frame && it.friction.is_some(), "axis_1"),
            "the same axes of friction everywhere",
            "axes that turn, along which tractions are not linear",
        ),
        (
            named(turns, "contact.obstacle"),
            "a contact normal that is the same on a whole face",
            "one that turns, along which tractions are not linear",
        ),
        (
            named(is_curved, "body"),
            "tetrahedra with straight sides",
            "curved ones, in which no stress of this kind is in balance",
        ),
    ];
    let mut found = refusals
        .into_iter()
        .filter_map(|(key, expected, found)| Some(invalid(&key?, expected, found)));
    found.next().map_or(Ok(()), Err)
}

/// Whether equilibrium is a minimum of energy in which no quantity differs from place to place: without friction or with one slip bound on
/// each face, and with a distance from the foundation that the mesh does not interpolate.
pub(super) fn is_minimum(scene: &Scene) -> bool {
    scene.contact_features().iter().all(|face| {
        let is_given = face.friction.as_ref().is_none_or(|law| {
            let bound = law.bound.place_dependent();
            let is_one = bound.is_some_and(|(_, bound)| !bound.depends_on_place());
            is_one && !scene.has_history()
        });
        is_given && !face.gap.as_ref().is_some_and(Quantity::depends_on_place)
    })
}

/// Forces that no tractions balance: of supports at points or along lines, or of an answer that is not in equilibrium.
pub(super) fn unbalanced(solved: &Solved<'_>) -> InvalidValue {
    match held_at_points(solved) {
        Some(clamp) => invalid(
            &format!("clamp.{clamp}"),
            "supports on whole sides of tetrahedra",
            "a box that holds single nodes, whose reactions no stress can balance",
        ),
        None => invalid(
            "solve",
            "an answer in equilibrium to rounding",
            "one whose forces around a node do not balance",
        ),
    }
}

/// The first clamp that holds a node in a direction in which no boundary triangle around it is held.
fn held_at_points(solved: &Solved<'_>) -> Option<usize> {
    let (mesh, clamps) = (solved.mesh, &solved.scene.clamps);
    let held = mesh.held_nodes(solved.scene);
    let mut on_sides = vec![[false; 3]; held.len()];
    for facet in 0..mesh.facets.len() {
        for c in (0..3).filter(|c| mesh.facet_nodes(facet).all(|node| held[node][*c])) {
            let nodes = mesh.facet_nodes(facet);
            nodes.for_each(|node| on_sides[node][c] = true);
        }
    }
    clamps.iter().position(|clamp| {
        let is_alone = |node: usize| {
            let mut components = clamp.components.iter();
            components.any(|component| !on_sides[node][*component as usize])
        };
        mesh.clamped_nodes(clamp).any(is_alone)
    })
}

/// Prescribed displacements into the foundation.
pub(super) fn pressed_in() -> InvalidValue {
    invalid(
        "clamp",
        "held nodes outside the foundation",
        "nodes that are held inside it, or faces in contact that meet at a slant",
    )
}

fn invalid(key: &str, expected: &str, found: &str) -> InvalidValue {
    InvalidValue {
        key: key.to_owned(),
        expected: format!("{expected}, for a bound of the error"),
        found: found.to_owned(),
        help: "the estimate of the error, which every solution has, needs none of this".to_owned(),
    }
}

/// The key of a load or a prescribed displacement that differs from place to place.
fn varying_load(solved: &Solved<'_>) -> Option<String> {
    let scene = solved.scene;
    let varies = |values: &[Quantity]| values.iter().any(Quantity::depends_on_place);
    let is_uniform = |load| SurfaceLoad::new(load, solved.mesh).is_ok_and(|it| it.is_uniform());
    let load = scene.face_loads().find(|load| !is_uniform(*load));
    let clamp = scene.clamps.iter().position(|clamp| varies(&clamp.value));
    let mut body_force = scene.body_force.iter();
    load.map(|load| load.key() + ".value")
        .or_else(|| clamp.map(|i| format!("clamp.{i}.value")))
        .or_else(|| {
            let whole = body_force.find(|force| varies(&force.value));
            whole.map(|_| "body_force.value".to_owned())
        })
}

//! What holds and loads a body, for its picture.

use std::collections::BTreeMap;

use contact3d::{
    mesh::Mesh,
    scene::{Quantity, Scene},
};
use plots::{BodyMark, BodyMarkKind};

/// The clamps, springs and loads of a scene without steps that do something; loads first, which look worse at a rim.
pub(super) fn body_marks(scene: &Scene, mesh: &Mesh) -> Vec<BodyMark> {
    let at = |values: &[Quantity; 3], x| [0, 1, 2].map(|c| values[c].at(x));
    let loads = scene.face_loads().map(|load| {
        on_face(mesh, load.face(), BodyMarkKind::Load, |x, normal| {
            load.at(x, normal)
        })
    });
    let volume = scene.body_force.iter().map(|force| {
        let nodes: BTreeMap<usize, [f64; 3]> = (mesh.facets.as_flattened().iter())
            .map(|&node| (node, [0.0; 3]))
            .collect();
        marked(mesh, BodyMarkKind::Volume, nodes, |x, _| {
            at(&force.value, x)
        })
    });
    let springs = scene
        .springs
        .iter()
        .map(|spring| on_face(mesh, &spring.face, BodyMarkKind::Spring, |_, normal| normal));
    let clamps = scene.clamps.iter().map(|clamp| {
        let face = clamp.face.iter().flat_map(|face| node_normals(mesh, face));
        let mut nodes: BTreeMap<usize, [f64; 3]> = face.collect();
        for node in mesh.clamped_nodes(clamp) {
            nodes.entry(node).or_default();
        }
        let held = [0, 1, 2]
            .map(|c| f64::from(u8::from(clamp.components.iter().any(|&k| k as usize == c))));
        if clamp.is_moved() {
            marked(mesh, BodyMarkKind::Moved, nodes, |x, _| at(&clamp.value, x))
        } else {
            marked(mesh, BodyMarkKind::Held, nodes, |_, _| held)
        }
    });
    let all = loads.chain(volume).chain(clamps).chain(springs);
    let acts = |mark: &BodyMark| {
        let values = || mark.vectors.iter().flatten();
        values().all(|value| value.is_finite()) && values().any(|&value| value != 0.0)
    };
    all.filter(acts).collect()
}

fn on_face(
    mesh: &Mesh,
    face: &str,
    kind: BodyMarkKind,
    vector: impl Fn([f64; 3], [f64; 3]) -> [f64; 3],
) -> BodyMark {
    marked(mesh, kind, node_normals(mesh, face), vector)
}

/// A mark of nodes with their normals; `vector` makes one of place and normal.
fn marked(
    mesh: &Mesh,
    kind: BodyMarkKind,
    nodes: BTreeMap<usize, [f64; 3]>,
    vector: impl Fn([f64; 3], [f64; 3]) -> [f64; 3],
) -> BodyMark {
    let vectors = nodes.iter();
    let vectors = vectors.map(|(&node, &normal)| vector(mesh.coordinates[node], normal));
    BodyMark {
        kind,
        vectors: vectors.collect(),
        normals: nodes.values().copied().collect(),
        nodes: nodes.into_keys().collect(),
    }
}

/// The mean outward unit normal of a face at each of its corners.
fn node_normals(mesh: &Mesh, face: &str) -> BTreeMap<usize, [f64; 3]> {
    let mut normals: BTreeMap<usize, [f64; 3]> = BTreeMap::new();
    for facet in mesh.facets_on(face) {
        let nodes = mesh.facets[facet];
        let [a, b, c] = nodes.map(|node| mesh.coordinates[node]);
        let [u, v] = [b, c].map(|x| [0, 1, 2].map(|k| x[k] - a[k]));
        let area = [0, 1, 2].map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            u[i] * v[j] - u[j] * v[i]
        });
        for node in nodes {
            let sum = normals.entry(node).or_default();
            *sum = [0, 1, 2].map(|k| sum[k] + area[k]);
        }
    }
    for normal in normals.values_mut() {
        let length = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
        *normal = normal.map(|c| if length > 0.0 { c / length } else { 0.0 });
    }
    normals
}

//! What is around a body in its pictures: what holds and loads it, and the part of an obstacle that contact faces see.

use std::collections::{BTreeMap, BTreeSet};

use contact3d::{
    elasticity::SurfaceLoad,
    mesh::{ContactSurface, Mesh, SurfaceFace},
    post::ToolState,
    scene::{FacePart, Quantity, Scene},
};
use plots::{BodyMark, BodyMarkKind, DrawnObstacle};

/// The clamps, springs and loads of a scene without steps that do something; loads first, which look worse at a rim.
pub(super) fn body_marks(scene: &Scene, mesh: &Mesh) -> Vec<BodyMark> {
    let at = |values: &[Quantity; 3], x| [0, 1, 2].map(|c| values[c].at(x));
    let loads = scene.face_loads().filter_map(|load| {
        let load = SurfaceLoad::new(load, mesh).ok()?;
        let nodes = part_normals(mesh, &load.load.part());
        Some(marked(mesh, BodyMarkKind::Load, nodes, |x, normal| {
            load.at(x, normal)
        }))
    });
    let volume = scene.body_force.iter().map(|force| {
        let nodes: BTreeMap<usize, [f64; 3]> = (mesh.facets.as_flattened().iter())
            .map(|&node| (node, [0.0; 3]))
            .collect();
        marked(mesh, BodyMarkKind::Volume, nodes, |x, _| {
            at(&force.value, x)
        })
    });
    let springs = scene.springs.iter().map(|spring| {
        marked(
            mesh,
            BodyMarkKind::Spring,
            part_normals(mesh, &spring.part()),
            |_, normal| normal,
        )
    });
    let clamps = scene.clamps.iter().map(|clamp| {
        let face = clamp.face.iter().map(|face| node_normals(mesh, face));
        let normals: BTreeMap<usize, [f64; 3]> = face.flatten().collect();
        let normal = |node| normals.get(&node).copied().unwrap_or_default();
        let nodes = mesh.clamped_nodes(clamp).map(|node| (node, normal(node)));
        let nodes: BTreeMap<usize, [f64; 3]> = nodes.collect();
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

/// The normals of a face at its corners inside a part, or at those of the triangles around it where it holds none.
fn part_normals(mesh: &Mesh, part: &FacePart<'_>) -> BTreeMap<usize, [f64; 3]> {
    let mut normals = node_normals(mesh, part.face);
    // A part that holds nothing was refused before.
    let sides = mesh.sides_of("", part).unwrap_or_default();
    let corners = |inside: bool| -> BTreeSet<usize> {
        let corners = sides.iter().flat_map(|side| {
            let held = (0..3).filter(move |k| !inside || side.holds_corner(*k));
            held.map(|k| mesh.facets[side.facet][k])
        });
        corners.collect()
    };
    let inside = corners(true);
    let nodes = if inside.is_empty() {
        corners(false)
    } else {
        inside
    };
    normals.retain(|node, _| nodes.contains(node));
    normals
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

/// The obstacle as some contact faces see it, where its tool is, with a strip around each where it is flat.
pub(super) fn obstacle_beside(
    mesh: &Mesh,
    surface: &ContactSurface,
    faces: &[SurfaceFace],
    (scene, tools): (&Scene, &[ToolState]),
) -> DrawnObstacle {
    let mut shape = DrawnObstacle::default();
    let entries = scene.contact_order();
    // The other body is drawn itself.
    let before_obstacles = faces
        .iter()
        .filter(|face| !surface.touches_body(face.panes.start));
    for face in before_obstacles {
        let first = shape.points.len();
        add(&mut shape, mesh, surface, face);
        let number = surface.faces.iter().position(|other| other == face);
        let tool = number.and_then(|number| scene.tool_on(*entries.get(number)?));
        let Some(tool) = tool.and_then(|tool| tools.get(tool)) else {
            continue;
        };
        let points = shape.points[first..].iter().zip(&mut shape.gaps[first..]);
        for (point, gap) in points {
            let moved = tool.displacement_at([0, 1, 2].map(|c| point[c] + gap[c]));
            *gap = [0, 1, 2].map(|c| gap[c] + moved[c]);
        }
    }
    shape
}

fn add(shape: &mut DrawnObstacle, mesh: &Mesh, surface: &ContactSurface, face: &SurfaceFace) {
    let facets = surface.facets[face.facets.clone()]
        .iter()
        .map(|&facet| mesh.facets[facet]);
    let facets: Vec<[usize; 3]> = facets.collect();
    let mut place: BTreeMap<usize, usize> = BTreeMap::new();
    let mut normals = Vec::new();
    for node in facets.as_flattened() {
        let Some(contact) = surface
            .contact_node(face, *node)
            .filter(|_| !place.contains_key(node))
        else {
            continue;
        };
        let normal = surface.normal_at(contact);
        let clearance = surface.clearance.get(contact).copied().unwrap_or(0.0);
        place.insert(*node, shape.points.len());
        shape.points.push(mesh.coordinates[*node]);
        shape.gaps.push(normal.map(|c| clearance * c));
        normals.push(normal);
    }
    // It looks at the body, the other way round than the face.
    shape.triangles.extend(
        facets
            .iter()
            .map(|&[a, b, c]| [place[&a], place[&c], place[&b]]),
    );
    if let [normal, others @ ..] = normals.as_slice()
        && others.iter().all(|other| other == normal)
    {
        add_strip(shape, mesh, &facets, &place, *normal);
    }
}

/// A strip in the plane of the obstacle around a face.
fn add_strip(
    shape: &mut DrawnObstacle,
    mesh: &Mesh,
    facets: &[[usize; 3]],
    place: &BTreeMap<usize, usize>,
    normal: [f64; 3],
) {
    let edges = || {
        facets
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
    };
    let all: BTreeSet<[usize; 2]> = edges().collect();
    let rim: Vec<[usize; 2]> = edges().filter(|&[a, b]| !all.contains(&[b, a])).collect();
    let mut outward: BTreeMap<usize, [f64; 3]> = BTreeMap::new();
    let mut across = 0.0_f64;
    for &[a, b] in &rim {
        let way: [f64; 3] =
            std::array::from_fn(|c| mesh.coordinates[b][c] - mesh.coordinates[a][c]);
        // The body's inside is to the left of the edge seen from outside, and the normal points there.
        let out = unit(cross(way, normal));
        for node in [a, b] {
            let sum = outward.entry(node).or_default();
            *sum = std::array::from_fn(|c| sum[c] + out[c]);
        }
        let from_first = |c: usize| mesh.coordinates[b][c] - mesh.coordinates[rim[0][0]][c];
        across = across.max(from_first(0).hypot(from_first(1)).hypot(from_first(2)));
    }
    let mut beyond: BTreeMap<usize, usize> = BTreeMap::new();
    for (node, sum) in outward {
        // The sum of two unit vectors o₁ + o₂; both edges move by the margin along 2 (o₁ + o₂) / |o₁ + o₂|².
        let length = sum.iter().map(|c| c * c).sum::<f64>().max(0.5);
        let at = place[&node];
        beyond.insert(node, shape.points.len());
        shape.gaps.push(shape.gaps[at]);
        let point = shape.points[at];
        shape.points.push(std::array::from_fn(|c| {
            // How far a flat obstacle is drawn beyond the contact face, as a share of the longest way across it.
            point[c] + 2.0 * 0.08 * across * sum[c] / length
        }));
    }
    for [a, b] in rim {
        let [near_a, near_b, far_a, far_b] = [place[&a], place[&b], beyond[&a], beyond[&b]];
        shape
            .triangles
            .extend([[near_a, near_b, far_b], [near_a, far_b, far_a]]);
    }
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = vector.iter().map(|c| c * c).sum::<f64>().sqrt();
    vector.map(|c| if length > 0.0 { c / length } else { 0.0 })
}

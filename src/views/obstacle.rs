//! The part of an obstacle that contact faces see.

use std::collections::{BTreeMap, BTreeSet};

use contact3d::mesh::{ContactSurface, Mesh, SurfaceFace};
use plots::DrawnObstacle;

/// The obstacle as some contact faces see it, with a strip around each where it is flat.
pub(super) fn obstacle_beside(
    mesh: &Mesh,
    surface: &ContactSurface,
    faces: &[SurfaceFace],
) -> DrawnObstacle {
    let mut shape = DrawnObstacle::default();
    faces
        .iter()
        .for_each(|face| add(&mut shape, mesh, surface, face));
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

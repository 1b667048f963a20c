//! Refusal of meshes whose parts touch without sharing nodes.

use nalgebra::Vector3;

use super::{GmshError, body::Body, boundary::Boundary, contents::Contents, nearby::Nearby};

/// Nodes this much nearer than an edge is long are in the same place: far more than roundings and
/// the tolerance of CAD kernels (1e-8 of the part), far less than any element worth having.
const SAME_PLACE: f64 = 1e-6;

/// Refuses boundaries on which parts touch without being joined: nodes in the same place, or on
/// triangles of which they are no corner.
///
/// Only boundary triangles are looked at, since a face between unjoined parts is boundary of both.
pub(super) fn check(
    body: &Body,
    boundary: &Boundary,
    contents: &Contents,
) -> Result<(), GmshError> {
    let mut nodes: Vec<usize> = boundary.facets.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let nearby = Nearby::new(&body.coordinates, nodes.clone());
    no_coincident_nodes(body, boundary, &nodes, &nearby)?;
    no_hanging_nodes(body, boundary, contents, &nearby)
}

fn point(body: &Body, node: usize) -> Vector3<f64> {
    body.coordinates[node].into()
}

fn no_coincident_nodes(
    body: &Body,
    boundary: &Boundary,
    nodes: &[usize],
    nearby: &Nearby,
) -> Result<(), GmshError> {
    let mut shortest = vec![f64::INFINITY; body.coordinates.len()];
    for &[a, b, c] in &boundary.facets {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let length = (point(body, p) - point(body, q)).norm();
            shortest[p] = shortest[p].min(length);
            shortest[q] = shortest[q].min(length);
        }
    }
    for &node in nodes {
        let at = body.coordinates[node];
        let reach = SAME_PLACE * shortest[node];
        let others = nearby.in_box(at.map(|x| x - reach), at.map(|x| x + reach));
        if let Some(&other) = others.iter().find(|&&other| other != node) {
            return Err(GmshError::CoincidentNodes {
                first: body.tags[node.min(other)],
                second: body.tags[node.max(other)],
                at,
            });
        }
    }
    Ok(())
}

fn no_hanging_nodes(
    body: &Body,
    boundary: &Boundary,
    contents: &Contents,
    nearby: &Nearby,
) -> Result<(), GmshError> {
    for (facet, &owner) in boundary.facets.iter().zip(&boundary.owner) {
        let corners = facet.map(|n| point(body, n));
        let longest = (0..3)
            .map(|i| (corners[i] - corners[(i + 1) % 3]).norm())
            .fold(0.0, f64::max);
        let reach = SAME_PLACE * longest;
        let low = corners[0]
            .inf(&corners[1])
            .inf(&corners[2])
            .add_scalar(-reach);
        let high = corners[0]
            .sup(&corners[1])
            .sup(&corners[2])
            .add_scalar(reach);
        let inside = nearby.in_box(low.into(), high.into());
        let hanging = inside
            .into_iter()
            .filter(|node| !facet.contains(node))
            .find(|&node| lies_on(&corners, reach, &point(body, node)));
        if let Some(node) = hanging {
            return Err(GmshError::HangingNode {
                node: body.tags[node],
                triangle: facet.map(|n| body.tags[n]),
                element: contents.tetrahedra[owner].tag,
            });
        }
    }
    Ok(())
}

/// Whether a point is within `reach` of the plane of a triangle and its foot is in the triangle.
fn lies_on(corners: &[Vector3<f64>; 3], reach: f64, at: &Vector3<f64>) -> bool {
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a));
    let twice_area = normal.norm();
    if (at - a).dot(&normal).abs() > reach * twice_area {
        return false;
    }
    [(a, b), (b, c), (c, a)].into_iter().all(|(p, q)| {
        let share = (q - p).cross(&(at - p)).dot(&normal) / (twice_area * twice_area);
        share >= -SAME_PLACE
    })
}

//! Orientation and outline edges of a triangulated surface.

use std::collections::BTreeMap;

use super::svg::{Vector, cross, dot, minus, unit};

/// Cosine of the angle between two facets from which on their common edge is a sharp edge (30°).
const SHARP_COSINE: f64 = 0.866;

/// An edge with the one or two (or more) triangles that meet in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct SurfaceEdge {
    pub(super) nodes: [usize; 2],
    pub(super) triangles: Vec<usize>,
}

/// All edges of a surface, ordered by their nodes.
pub(super) fn surface_edges(triangles: &[[usize; 3]]) -> Vec<SurfaceEdge> {
    let mut edges: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
    for (index, &[a, b, c]) in triangles.iter().enumerate() {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            edges.entry([p.min(q), p.max(q)]).or_default().push(index);
        }
    }
    let edges = edges.into_iter();
    edges
        .map(|(nodes, triangles)| SurfaceEdge { nodes, triangles })
        .collect()
}

/// Joins edges that meet in a node of two edges to lines of nodes; every edge is used once.
pub(super) fn joined_lines(edges: &[[usize; 2]]) -> Vec<Vec<usize>> {
    let mut edges_at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, edge) in edges.iter().enumerate() {
        for &node in edge {
            edges_at.entry(node).or_default().push(index);
        }
    }
    let mut used = vec![false; edges.len()];
    let mut lines = Vec::new();
    // Lines start where they end or branch; what remains are rings, which start anywhere.
    let ends = edges_at.iter().filter(|(_, at)| at.len() != 2);
    let starts = ends.chain(edges_at.iter());
    for (&start, at_start) in starts {
        for &first in at_start {
            if used[first] {
                continue;
            }
            let mut line = vec![start];
            let mut edge = first;
            loop {
                used[edge] = true;
                let [p, q] = edges[edge];
                let node = if line.last() == Some(&p) { q } else { p };
                line.push(node);
                let at = &edges_at[&node];
                match at.iter().find(|&&next| !used[next]) {
                    Some(&next) if at.len() == 2 => edge = next,
                    _ => break,
                }
            }
            lines.push(line);
        }
    }
    lines
}

/// Normals of the triangles, outward when the surface is closed and consistently oriented.
pub(super) struct FacetNormals {
    /// Unit normals.
    pub(super) normals: Vec<Vector>,
    /// Whether they all point outward, so that facets turned away from the viewer are hidden.
    pub(super) outward: bool,
}

impl FacetNormals {
    /// Normals of `triangles` with the nodes at `points`.
    pub(super) fn new(points: &[Vector], triangles: &[[usize; 3]], edges: &[SurfaceEdge]) -> Self {
        let mut normals: Vec<Vector> = triangles
            .iter()
            .map(|&[a, b, c]| {
                unit(cross(
                    minus(points[b], points[a]),
                    minus(points[c], points[a]),
                ))
            })
            .collect();
        let outward = is_oriented(triangles, edges);
        if outward && enclosed_volume(points, triangles) < 0.0 {
            for normal in &mut normals {
                *normal = normal.map(|component| -component);
            }
        }
        Self { normals, outward }
    }

    /// Whether the edge belongs to the outline seen from direction `toward`:
    /// sharp, at the rim of the surface, or between a visible and a hidden facet.
    pub(super) fn is_outline(&self, edge: &SurfaceEdge, toward: Vector) -> bool {
        let [first, second] = edge.triangles[..] else {
            return true;
        };
        let (first, second) = (self.normals[first], self.normals[second]);
        let cosine = dot(first, second);
        let cosine = if self.outward { cosine } else { cosine.abs() };
        let contour = self.outward && (dot(first, toward) > 0.0) != (dot(second, toward) > 0.0);
        cosine < SHARP_COSINE || contour
    }

    /// Whether the viewer in direction `toward` may see the facet.
    pub(super) fn faces(&self, triangle: usize, toward: Vector) -> bool {
        !self.outward || dot(self.normals[triangle], toward) > 0.0
    }
}

/// Whether every edge is passed once in each direction.
fn is_oriented(triangles: &[[usize; 3]], edges: &[SurfaceEdge]) -> bool {
    let forward = |triangle: usize, [p, q]: [usize; 2]| {
        let [a, b, c] = triangles[triangle];
        [[a, b], [b, c], [c, a]].contains(&[p, q])
    };
    edges.iter().all(|edge| match edge.triangles[..] {
        [first, second] => forward(first, edge.nodes) != forward(second, edge.nodes),
        _ => false,
    })
}

/// Signed volume Σ a·(b × c)/6, taken about the first point against cancellation.
fn enclosed_volume(points: &[Vector], triangles: &[[usize; 3]]) -> f64 {
    let Some(&[origin, ..]) = triangles.first() else {
        return 0.0;
    };
    let origin = points[origin];
    let six_fold = triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|node| minus(points[node], origin));
        dot(a, cross(b, c))
    });
    six_fold.sum::<f64>() / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Vector; 4] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    ];

    #[test]
    fn inward_oriented_tetrahedron_gets_outward_normals() {
        let inward = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
        let facets = FacetNormals::new(&CORNERS, &inward, &surface_edges(&inward));
        assert!(facets.outward);
        assert_eq!(facets.normals[0], [0.0, 0.0, -1.0]);
        assert!(facets.faces(0, [0.0, 0.0, -1.0]) && !facets.faces(0, [0.0, 0.0, 1.0]));
    }

    #[test]
    fn edges_are_joined_up_to_branches_and_around_rings() {
        let lines = joined_lines(&[[0, 1], [1, 2], [2, 3], [2, 4]]);
        assert_eq!(lines, [vec![0, 1, 2], vec![2, 3], vec![2, 4]]);
        assert_eq!(joined_lines(&[[0, 1], [1, 2], [0, 2]]), [vec![0, 1, 2, 0]]);
    }

    #[test]
    fn an_open_surface_hides_nothing() {
        let open = [[0, 1, 2], [0, 3, 1]];
        let facets = FacetNormals::new(&CORNERS, &open, &surface_edges(&open));
        assert!(!facets.outward && facets.faces(0, [0.0, 0.0, 1.0]));
    }
}

//! The edges of a surface that are drawn as lines, and the normals that tell which of its triangles are seen.

use std::collections::BTreeMap;

use super::view::{Vector, cross, dot, minus, unit};

/// An edge with the one or two (or more) triangles that meet in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct SurfaceEdge {
    pub(super) nodes: [usize; 2],
    pub(super) triangles: Vec<usize>,
    /// Whether it is drawn from wherever it is seen: at a rim, between named faces, or a crease of the body at rest.
    pub(super) is_line: bool,
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
        .map(|(nodes, triangles)| SurfaceEdge {
            nodes,
            is_line: triangles.len() != 2,
            triangles,
        })
        .collect()
}

/// Marks the edges between named faces, and the creases of the body at rest.
pub(super) fn mark_lines(edges: &mut [SurfaceEdge], rest: &FacetNormals, faces: &[usize]) {
    for edge in edges {
        if let [first, second] = edge.triangles[..] {
            let cosine = dot(rest.normals[first], rest.normals[second]);
            let cosine = if rest.outward { cosine } else { cosine.abs() };
            // Facets that meet at more than 50° have a crease between them; those of coarse round faces meet at less.
            edge.is_line = cosine < 0.643 || faces.get(first) != faces.get(second);
        }
    }
}

/// Joins edges that meet in a node of two edges to lines of nodes; every edge is used once.
pub(super) fn joined_lines(edges: &[[usize; 2]]) -> Vec<Vec<usize>> {
    joined(edges, |n_edges| n_edges == 2)
}

/// Joins the edges of a border to loops of nodes, the first of which is not said again; every edge is used once.
pub(super) fn edge_loops(edges: &[[usize; 2]]) -> Vec<Vec<usize>> {
    let mut loops = joined(edges, |_| true);
    for nodes in loops.iter_mut().filter(|it| it.first() == it.last()) {
        nodes.pop();
    }
    loops
}

/// Joins edges to lines that go on through nodes of so many edges, until they are back.
fn joined(edges: &[[usize; 2]], goes_on: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
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
                    Some(&next) if goes_on(at.len()) && node != start => edge = next,
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

    /// Whether the edge belongs to the outline seen from direction `toward`: a line, or between a visible and a hidden facet.
    pub(super) fn is_outline(&self, edge: &SurfaceEdge, toward: Vector) -> bool {
        let is_seen = |triangle: &usize| dot(self.normals[*triangle], toward) > 0.0;
        let count = edge
            .triangles
            .iter()
            .filter(|triangle| is_seen(triangle))
            .count();
        edge.is_line || (self.outward && count == 1)
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

    /// The edge between two facets at a right angle, at half of one, and between two faces in a plane.
    #[test]
    fn lines_are_creases_and_bounds_of_faces() {
        let triangles = [[0, 1, 2], [1, 0, 3]];
        let is_line = |apex: Vector, faces: &[usize]| {
            let points = [CORNERS[0], CORNERS[1], [0.0, -1.0, 0.0], apex];
            let mut edges = surface_edges(&triangles);
            let rest = FacetNormals::new(&points, &triangles, &edges);
            mark_lines(&mut edges, &rest, faces);
            edges
                .iter()
                .find(|edge| edge.nodes == [0, 1])
                .is_some_and(|edge| edge.is_line)
        };
        assert!(is_line([0.0, 0.0, 1.0], &[]));
        assert!(!is_line([0.0, 1.0, 1.0], &[]) && !is_line([0.0, 1.0, 1.0], &[4, 4]));
        assert!(is_line([0.0, 1.0, 0.0], &[4, 5]));
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

//! Interpolation of P1 fields between nested bricks.

use nalgebra::{Matrix3, Vector3};

use crate::{mesh::Mesh, reference::shape::quadratic_tetrahedron, scene::Brick};

/// A finite element field of a brick's mesh, `[n_nodes]`, at the points of the same brick, `[n_points]`; exact
/// interpolation where the mesh of the points is nested in the brick's.
pub(super) fn prolongate(
    brick: &Brick,
    mesh: &Mesh,
    nodal: &[[f64; 3]],
    points: &[[f64; 3]],
) -> Vec<[f64; 3]> {
    let planes = [0, 1, 2].map(|axis| brick.planes(axis));
    let value = |point: &[f64; 3]| {
        let (tetrahedron, at) = tetrahedron_around(&planes, mesh, point);
        let shape = match &mesh.mid_edges {
            None => at.to_vec(),
            Some(_) => quadratic_tetrahedron(&at).to_vec(),
        };
        let nodes = || mesh.tetrahedron_nodes(tetrahedron);
        std::array::from_fn(|c| nodes().zip(&shape).map(|(n, w)| w * nodal[n][c]).sum())
    };
    points.iter().map(value).collect()
}

/// The tetrahedron that holds a point, and the point's barycentric coordinates in it. A brick's
/// tetrahedra come five a cell, the cells with the first index fastest.
pub(super) fn tetrahedron_around(
    planes: &[Vec<f64>; 3],
    mesh: &Mesh,
    point: &[f64; 3],
) -> (usize, [f64; 4]) {
    let cells: [usize; 3] = std::array::from_fn(|axis| planes[axis].len() - 1);
    let [i, j, k] = std::array::from_fn(|axis| {
        let inner = &planes[axis][1..cells[axis]];
        inner.partition_point(|plane| *plane <= point[axis])
    });
    let cell = i + cells[0] * (j + cells[1] * k);
    let depth = |weights: &[f64; 4]| weights.iter().copied().fold(f64::INFINITY, f64::min);
    (5 * cell..5 * (cell + 1))
        .map(|t| (t, mesh.barycentric(t, point)))
        .max_by(|(_, a), (_, b)| depth(a).total_cmp(&depth(b)))
        .unwrap_or((0, [0.0; 4]))
}

impl Mesh {
    /// Barycentric coordinates of a point in a tetrahedron with straight sides.
    pub(super) fn barycentric(&self, tetrahedron: usize, point: &[f64; 3]) -> [f64; 4] {
        let corners = self.corners(&self.tetrahedra[tetrahedron]);
        let [a, b, c, d] = corners.map(Vector3::from);
        let edges = Matrix3::from_columns(&[b - a, c - a, d - a]);
        let inverse = edges.try_inverse().unwrap_or_else(Matrix3::zeros);
        let weights = inverse * (Vector3::from(*point) - a);
        [1.0 - weights.sum(), weights[0], weights[1], weights[2]]
    }
}

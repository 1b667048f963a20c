//! Interpolation of P1 fields between nested bricks.

use nalgebra::{Matrix3, Vector3};

use crate::{mesh::Mesh, scene::Brick};

/// A P1 field of a brick's mesh, `[n_nodes]`, at the points of the same brick, `[n_points]`; exact
/// interpolation where the mesh of the points is nested in the brick's.
pub(super) fn prolongate(
    brick: &Brick,
    mesh: &Mesh,
    nodal: &[[f64; 3]],
    points: &[[f64; 3]],
) -> Vec<[f64; 3]> {
    let value = |point: &[f64; 3]| {
        let (nodes, weights) = tetrahedron_around(brick, mesh, point);
        std::array::from_fn(|c| (0..4).map(|k| weights[k] * nodal[nodes[k]][c]).sum())
    };
    points.iter().map(value).collect()
}

/// Nodes of the tetrahedron that holds a point, and its barycentric coordinates there. A brick's
/// tetrahedra come five a cell, the cells with the first index fastest.
fn tetrahedron_around(brick: &Brick, mesh: &Mesh, point: &[f64; 3]) -> ([usize; 4], [f64; 4]) {
    let [i, j, k] = std::array::from_fn(|axis| {
        let cells = brick.cells[axis];
        let along = (point[axis] / brick.size[axis] * cells as f64).floor();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "points of the brick lie between 0 and the number of cells"
        )]
        let index = along.max(0.0) as usize;
        index.min(cells - 1)
    });
    let cell = i + brick.cells[0] * (j + brick.cells[1] * k);
    let candidates = &mesh.tetrahedra[5 * cell..5 * (cell + 1)];
    let depth = |weights: &[f64; 4]| weights.iter().copied().fold(f64::INFINITY, f64::min);
    candidates
        .iter()
        .map(|nodes| (*nodes, barycentric(&mesh.corners(nodes), point)))
        .max_by(|(_, a), (_, b)| depth(a).total_cmp(&depth(b)))
        .unwrap_or(([0; 4], [0.0; 4]))
}

fn barycentric(corners: &[[f64; 3]; 4], point: &[f64; 3]) -> [f64; 4] {
    let [a, b, c, d] = corners.map(Vector3::from);
    let edges = Matrix3::from_columns(&[b - a, c - a, d - a]);
    let inverse = edges.try_inverse().unwrap_or_else(Matrix3::zeros);
    let weights = inverse * (Vector3::from(*point) - a);
    [1.0 - weights.sum(), weights[0], weights[1], weights[2]]
}

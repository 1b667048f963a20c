//! The reference triangle and tetrahedron: edges, quadratic shape functions, quadrature.

pub mod quadrature;
pub mod shape;

/// Corners of the six edges of a tetrahedron, in the order of its mid-edge nodes (that of VTK).
pub const TETRAHEDRON_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// Corners of the four sides of a tetrahedron, side k opposite to corner k.
pub const TETRAHEDRON_SIDES: [[usize; 3]; 4] = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];

/// Corners of the three edges of a triangle, in the order of its mid-edge nodes (that of VTK).
pub const TRIANGLE_EDGES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// Barycentric coordinates of the nodes of a quadratic triangle: its corners, then the middles of [`TRIANGLE_EDGES`].
pub(crate) const QUADRATIC_TRIANGLE_NODES: [[f64; 3]; 6] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
];

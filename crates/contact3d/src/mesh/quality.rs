//! Sizes and shapes of the tetrahedra of a mesh.

use nalgebra::Vector3;

use super::{Mesh, tetrahedron_volume};

/// Figures that say how well shaped a mesh is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Longest edge h in m.
    pub longest_edge: f64,
    /// Shortest edge in m.
    pub shortest_edge: f64,
    /// Smallest tetrahedron volume in m³.
    pub smallest_volume: f64,
    /// Total volume |Ω| in m³.
    pub total_volume: f64,
    /// Smallest [`shape`] of a tetrahedron.
    pub smallest_shape: f64,
    /// Mean of the same measure.
    pub mean_shape: f64,
}

impl Quality {
    /// Measures a mesh.
    #[must_use]
    pub fn of(mesh: &Mesh) -> Self {
        let mut quality = Self {
            longest_edge: 0.0,
            shortest_edge: f64::INFINITY,
            smallest_volume: f64::INFINITY,
            total_volume: 0.0,
            smallest_shape: f64::INFINITY,
            mean_shape: 0.0,
        };
        for nodes in &mesh.tetrahedra {
            let corners = mesh.corners(nodes);
            let volume = tetrahedron_volume(&corners);
            let lengths = edge_lengths(&corners);
            let shape = shape(&corners);
            quality.longest_edge = lengths.iter().copied().fold(quality.longest_edge, f64::max);
            quality.shortest_edge = lengths
                .iter()
                .copied()
                .fold(quality.shortest_edge, f64::min);
            quality.smallest_volume = quality.smallest_volume.min(volume);
            quality.total_volume += volume;
            quality.smallest_shape = quality.smallest_shape.min(shape);
            quality.mean_shape += shape / mesh.tetrahedra.len() as f64;
        }
        quality
    }
}

/// 12 (3V)^{2/3} / Σ l² of a tetrahedron: 1 is regular, 0 degenerate (Liu & Joe 1994); 0.4 where it is a fifth as high as wide.
#[must_use]
pub fn shape(corners: &[[f64; 3]; 4]) -> f64 {
    let squares: f64 = edge_lengths(corners).iter().map(|l| l * l).sum();
    12.0 * (3.0 * tetrahedron_volume(corners)).powf(2.0 / 3.0) / squares
}

fn edge_lengths(corners: &[[f64; 3]; 4]) -> [f64; 6] {
    let p = corners.map(Vector3::from);
    [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)].map(|(a, b)| (p[a] - p[b]).norm())
}

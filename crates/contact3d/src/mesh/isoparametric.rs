//! The map from the reference tetrahedron to one with curved sides.

use nalgebra::{Matrix3, Vector3};

use super::tetrahedron_volume;
use crate::reference::{
    TETRAHEDRON_EDGES, quadrature,
    shape::{quadratic_tetrahedron, quadratic_tetrahedron_slopes},
};

/// x(λ) = Σ φ_k(λ) x_k with the quadratic shape functions φ of ten nodes x.
#[derive(Debug, Clone)]
pub(crate) struct IsoparametricMap {
    /// Coordinates of the corners, then of the mid-edge nodes, in m.
    nodes: [[f64; 3]; 10],
}

impl IsoparametricMap {
    /// The map through corners and mid-edge nodes.
    pub(crate) fn new(corners: &[[f64; 3]; 4], middles: &[[f64; 3]; 6]) -> Self {
        let node = |k: usize| k.checked_sub(4).map_or_else(|| corners[k], |e| middles[e]);
        Self {
            nodes: std::array::from_fn(node),
        }
    }

    /// The place in m of a point in barycentric coordinates.
    pub(crate) fn place(&self, at: &[f64; 4]) -> [f64; 3] {
        let shape = quadratic_tetrahedron(at);
        std::array::from_fn(|c| (0..10).map(|k| shape[k] * self.nodes[k][c]).sum())
    }

    /// A sixth of the Jacobian determinant in m³, the volume of a straight tetrahedron with the
    /// same, and ∇φ of the shape functions in 1/m, at a point in barycentric coordinates.
    pub(crate) fn geometry(&self, at: &[f64; 4]) -> (f64, [Vector3<f64>; 10]) {
        let slopes = quadratic_tetrahedron_slopes(at);
        // λ₀ = 1 − λ₁ − λ₂ − λ₃.
        let reference = slopes.map(|s| Vector3::new(s[1] - s[0], s[2] - s[0], s[3] - s[0]));
        let mut map = Matrix3::zeros();
        for (x, slope) in self.nodes.iter().zip(&reference) {
            map += Vector3::from(*x) * slope.transpose();
        }
        let inverse = map.try_inverse().unwrap_or_else(Matrix3::zeros).transpose();
        (
            map.determinant() / 6.0,
            reference.map(|slope| inverse * slope),
        )
    }

    /// The smallest Jacobian determinant at nodes and points of integration over that of the
    /// straight tetrahedron with the same corners; not positive where the element folds.
    pub(crate) fn least_jacobian(&self) -> f64 {
        let straight = tetrahedron_volume(&std::array::from_fn(|k| self.nodes[k]));
        let corner = |k: usize| std::array::from_fn(|j| f64::from(u8::from(j == k)));
        let middle =
            |ends: [usize; 2]| std::array::from_fn(|j| if ends.contains(&j) { 0.5 } else { 0.0 });
        let nodes = (0..4).map(corner).chain(TETRAHEDRON_EDGES.map(middle));
        let places = nodes.chain(quadrature::tetrahedron_5().map(|(at, _)| at));
        places
            .map(|at| self.geometry(&at).0 / straight)
            .fold(f64::INFINITY, f64::min)
    }
}

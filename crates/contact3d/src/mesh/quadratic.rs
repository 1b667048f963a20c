//! Quadratic meshes: nodes in the middle of edges, and the map of a curved tetrahedron.

use std::collections::HashMap;

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::{Mesh, tetrahedron_volume};
use crate::reference::{
    TETRAHEDRON_EDGES, TRIANGLE_EDGES, quadratic_tetrahedron, quadratic_tetrahedron_slopes,
    quadratic_triangle, quadrature,
};

/// The mid-edge nodes of a mesh of quadratic tetrahedra.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MidEdgeNodes {
    /// Mid-edge nodes of each tetrahedron on [`TETRAHEDRON_EDGES`], `[n_tetrahedra]`.
    pub tetrahedra: Vec<[usize; 6]>,
    /// Mid-edge nodes of each boundary triangle on [`TRIANGLE_EDGES`], `[n_facets]`.
    pub facets: Vec<[usize; 3]>,
}

/// The edge between two corners, as a key.
pub(super) fn edge(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

impl MidEdgeNodes {
    /// Numbers the edges of a mesh after its corners, in increasing order of their corners, and
    /// gives the corners of each new node.
    #[must_use]
    pub(super) fn number(
        n_corners: usize,
        tetrahedra: &[[usize; 4]],
        facets: &[[usize; 3]],
    ) -> (Self, Vec<[usize; 2]>) {
        let mut edges: Vec<[usize; 2]> = tetrahedra
            .iter()
            .flat_map(|nodes| TETRAHEDRON_EDGES.map(|[a, b]| edge(nodes[a], nodes[b])))
            .collect();
        edges.par_sort_unstable();
        edges.dedup();
        let find = |a: usize, b: usize| {
            let place = edges.partition_point(|known| *known < edge(a, b));
            n_corners + place
        };
        let numbered = Self {
            tetrahedra: tetrahedra
                .par_iter()
                .map(|nodes| TETRAHEDRON_EDGES.map(|[a, b]| find(nodes[a], nodes[b])))
                .collect(),
            facets: facets
                .par_iter()
                .map(|nodes| TRIANGLE_EDGES.map(|[a, b]| find(nodes[a], nodes[b])))
                .collect(),
        };
        (numbered, edges)
    }

    /// Adds nodes in the middle of straight edges to the corners of a mesh, in m.
    pub(super) fn add_straight(
        coordinates: &mut Vec<[f64; 3]>,
        tetrahedra: &[[usize; 4]],
        facets: &[[usize; 3]],
    ) -> Self {
        let (numbered, edges) = Self::number(coordinates.len(), tetrahedra, facets);
        let middle = |[a, b]: [usize; 2]| {
            let (a, b) = (coordinates[a], coordinates[b]);
            std::array::from_fn(|c| 0.5 * (a[c] + b[c]))
        };
        let middles: Vec<[f64; 3]> = edges.into_iter().map(middle).collect();
        coordinates.extend(middles);
        numbered
    }

    /// Finds the mid-edge nodes of boundary triangles from those of the tetrahedra.
    #[must_use]
    pub(super) fn with_facets(
        tetrahedra: Vec<[usize; 6]>,
        corners: &[[usize; 4]],
        facets: &[[usize; 3]],
    ) -> Self {
        let mut middle = HashMap::new();
        for (corners, middles) in corners.iter().zip(&tetrahedra) {
            for ([a, b], node) in TETRAHEDRON_EDGES.into_iter().zip(middles) {
                middle.insert(edge(corners[a], corners[b]), *node);
            }
        }
        let facets = facets.iter();
        let facets = facets.map(|f| TRIANGLE_EDGES.map(|[a, b]| middle[&edge(f[a], f[b])]));
        Self {
            facets: facets.collect(),
            tetrahedra,
        }
    }
}

impl Mesh {
    /// Nodes of a tetrahedron: its corners, then its mid-edge nodes if it has any.
    pub fn tetrahedron_nodes(&self, tetrahedron: usize) -> impl Iterator<Item = usize> + '_ {
        let middles = self.mid_edges.as_ref().map(|m| m.tetrahedra[tetrahedron]);
        let corners = self.tetrahedra[tetrahedron].into_iter();
        corners.chain(middles.into_iter().flatten())
    }

    /// Nodes of a boundary triangle: its corners, then its mid-edge nodes if it has any.
    pub fn facet_nodes(&self, facet: usize) -> impl Iterator<Item = usize> + '_ {
        let middles = self.mid_edges.as_ref().map(|m| m.facets[facet]);
        let corners = self.facets[facet].into_iter();
        corners.chain(middles.into_iter().flatten())
    }

    /// Shape functions of the nodes of a boundary triangle at a point in barycentric coordinates.
    pub(crate) fn facet_shape(&self, at: &[f64; 3]) -> Vec<f64> {
        match self.mid_edges {
            None => at.to_vec(),
            Some(_) => quadratic_triangle(at).to_vec(),
        }
    }

    /// Nodes of a tetrahedron: 4 of a linear one, 10 of a quadratic one.
    #[must_use]
    pub fn nodes_per_tetrahedron(&self) -> usize {
        if self.mid_edges.is_some() { 10 } else { 4 }
    }
}

/// x(λ) = Σ φ_k(λ) x_k with the quadratic shape functions φ of ten nodes x.
#[derive(Debug, Clone)]
pub struct IsoparametricMap {
    /// Coordinates of the corners, then of the mid-edge nodes, in m.
    nodes: [[f64; 3]; 10],
}

impl IsoparametricMap {
    /// The map through corners and mid-edge nodes.
    #[must_use]
    pub fn new(corners: &[[f64; 3]; 4], middles: &[[f64; 3]; 6]) -> Self {
        let node = |k: usize| k.checked_sub(4).map_or_else(|| corners[k], |e| middles[e]);
        Self {
            nodes: std::array::from_fn(node),
        }
    }

    /// The place in m of a point in barycentric coordinates.
    #[must_use]
    pub fn place(&self, at: &[f64; 4]) -> [f64; 3] {
        let shape = quadratic_tetrahedron(at);
        std::array::from_fn(|c| (0..10).map(|k| shape[k] * self.nodes[k][c]).sum())
    }

    /// A sixth of the Jacobian determinant in m³, the volume of a straight tetrahedron with the
    /// same, and ∇φ of the shape functions in 1/m, at a point in barycentric coordinates.
    pub fn geometry(&self, at: &[f64; 4]) -> (f64, [Vector3<f64>; 10]) {
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

//! Nodes in the middle of edges: what quadratic tetrahedra have beyond their corners.

use std::collections::HashMap;

use rayon::prelude::*;

use super::Mesh;
use crate::reference::{TETRAHEDRON_EDGES, TRIANGLE_EDGES};

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

    /// Nodes of a tetrahedron: 4 of a linear one, 10 of a quadratic one.
    #[must_use]
    pub fn nodes_per_tetrahedron(&self) -> usize {
        if self.mid_edges.is_some() { 10 } else { 4 }
    }
}

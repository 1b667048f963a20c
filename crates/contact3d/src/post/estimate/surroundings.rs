//! What lies on the other side of each side of each tetrahedron.

use std::collections::HashMap;

use super::bubbles::SIDES;
use crate::mesh::{Mesh, sorted};

/// The other side of a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beyond {
    /// Another tetrahedron.
    Tetrahedron(usize),
    /// A boundary triangle.
    Facet(usize),
}

/// What lies beyond side k, opposite to corner k, of every tetrahedron, `[n_tetrahedra]`.
pub(super) fn surroundings(mesh: &Mesh) -> Vec<[Beyond; 4]> {
    let side = |t: usize, k: usize| sorted(SIDES[k].map(|c| mesh.tetrahedra[t][c]));
    let mut sides: Vec<([usize; 3], usize, usize)> = (0..mesh.tetrahedra.len())
        .flat_map(|t| (0..4).map(move |k| (t, k)))
        .map(|(t, k)| (side(t, k), t, k))
        .collect();
    rayon::slice::ParallelSliceMut::par_sort_unstable(sides.as_mut_slice());
    let facets: HashMap<[usize; 3], usize> = (0..mesh.facets.len())
        .map(|f| (sorted(mesh.facets[f]), f))
        .collect();
    let mut beyond = vec![[Beyond::Facet(usize::MAX); 4]; mesh.tetrahedra.len()];
    for shared in sides.chunk_by(|a, b| a.0 == b.0) {
        match *shared {
            [(_, t, k), (_, s, l)] => {
                beyond[t][k] = Beyond::Tetrahedron(s);
                beyond[s][l] = Beyond::Tetrahedron(t);
            }
            _ => {
                for (nodes, t, k) in shared {
                    beyond[*t][*k] = Beyond::Facet(facets[nodes]);
                }
            }
        }
    }
    beyond
}

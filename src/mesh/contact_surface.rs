use std::collections::BTreeSet;

use super::triangle_area;
use crate::linalg::CscMatrix;

/// The contact face Γ_c: its nodes, its triangles, and its partition into panes Rⁱ.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactSurface {
    /// Mesh nodes on Γ_c in increasing order, `[n_contact_nodes]`.
    pub nodes: Vec<usize>,
    /// Boundary triangles on Γ_c (indices into the mesh's facets), `[n_contact_facets]`.
    pub facets: Vec<usize>,
    /// The pane of each contact triangle, `[n_contact_facets]`.
    pub facet_pane: Vec<usize>,
    /// Area |Rⁱ| of each pane in m², `[n_panes]`.
    pub pane_area: Vec<f64>,
    /// Averaging over panes: column i holds (1/|Rⁱ|) ∫_{Rⁱ} φ_j over contact nodes j,
    /// `[n_contact_nodes, n_panes]`; each column sums to 1. For the 2 × 2 macro-faces of a brick
    /// it is 4/12 at the centre and 1/12 at the eight other nodes.
    pub pane_average: CscMatrix,
}

impl ContactSurface {
    /// Gathers nodes, areas and averages of the panes from the triangles of Γ_c.
    #[must_use]
    pub fn new(
        coordinates: &[[f64; 3]],
        mesh_facets: &[[usize; 3]],
        facets: Vec<usize>,
        facet_pane: Vec<usize>,
    ) -> Self {
        let nodes: Vec<usize> = facets
            .iter()
            .flat_map(|&f| mesh_facets[f])
            .collect::<BTreeSet<_>>()
            .into_iter()
            .collect();
        let n_panes = facet_pane.iter().max().map_or(0, |p| p + 1);
        let mut shares: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n_panes];
        let mut pane_area = vec![0.0; n_panes];
        for (&facet, &pane) in facets.iter().zip(&facet_pane) {
            let corners = mesh_facets[facet];
            let area = triangle_area(&corners.map(|n| coordinates[n]));
            pane_area[pane] += area;
            for node in corners {
                let local = nodes.partition_point(|&n| n < node);
                match shares[pane].iter_mut().find(|(n, _)| *n == local) {
                    Some((_, share)) => *share += area / 3.0,
                    None => shares[pane].push((local, area / 3.0)),
                }
            }
        }
        let pane_average = average_matrix(nodes.len(), &mut shares, &pane_area);
        Self {
            nodes,
            facets,
            facet_pane,
            pane_area,
            pane_average,
        }
    }

    /// Number of panes m.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        self.pane_area.len()
    }

    /// The (contact node, weight) pairs of one pane; the weights sum to 1.
    pub fn pane_weights(&self, pane: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.pane_average.indptr[pane]..self.pane_average.indptr[pane + 1];
        range.map(|k| (self.pane_average.indices[k], self.pane_average.data[k]))
    }
}

fn average_matrix(
    n_contact_nodes: usize,
    shares: &mut [Vec<(usize, f64)>],
    pane_area: &[f64],
) -> CscMatrix {
    let mut matrix = CscMatrix {
        rows: n_contact_nodes,
        cols: shares.len(),
        indptr: vec![0],
        indices: Vec::new(),
        data: Vec::new(),
    };
    for (share, area) in shares.iter_mut().zip(pane_area) {
        share.sort_by_key(|(node, _)| *node);
        matrix.indices.extend(share.iter().map(|(node, _)| *node));
        matrix
            .data
            .extend(share.iter().map(|(_, integral)| integral / area));
        matrix.indptr.push(matrix.indices.len());
    }
    matrix
}

//! The contact face Γ_c with the panes or nodes that carry multipliers.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::triangle_area;
use crate::linalg::CscMatrix;

/// The contact face Γ_c: its nodes, its triangles, and the pieces that carry multipliers: panes Rⁱ,
/// or the surroundings of single nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactSurface {
    /// Outward unit normal ν of the flat face.
    pub normal: [f64; 3],
    /// Mesh nodes on Γ_c in increasing order, `[n_contact_nodes]`.
    pub nodes: Vec<usize>,
    /// Boundary triangles on Γ_c (indices into the mesh's facets), `[n_contact_facets]`.
    pub facets: Vec<usize>,
    /// The pane of each contact triangle, `[n_contact_facets]`; empty with nodal multipliers.
    pub facet_pane: Vec<usize>,
    /// Area |Rⁱ| of each pane in m², `[n_panes]`; with nodal multipliers the integral of the
    /// node's hat function.
    pub pane_area: Vec<f64>,
    /// Averaging over panes: column i holds (1/|Rⁱ|) ∫_{Rⁱ} φ_j over contact nodes j,
    /// `[n_contact_nodes, n_panes]`; each column sums to 1. For the 2 × 2 macro-faces of a brick
    /// it is 4/12 at the centre and 1/12 at the eight other nodes; with nodal multipliers (lumped
    /// integration) it is 1 at the node itself.
    pub pane_average: CscMatrix,
}

/// Triangles of a face and what is known of them.
pub(super) struct FaceTriangles<'a> {
    pub(super) coordinates: &'a [[f64; 3]],
    /// All boundary triangles of the mesh.
    pub(super) mesh_facets: &'a [[usize; 3]],
    /// Those on the face.
    pub(super) facets: Vec<usize>,
    pub(super) normal: [f64; 3],
}

impl FaceTriangles<'_> {
    /// The nodes of the face, increasing.
    pub(super) fn nodes(&self) -> Vec<usize> {
        let nodes = self.facets.iter().flat_map(|&f| self.mesh_facets[f]);
        nodes.collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// Area of each triangle in m².
    fn area(&self, facet: usize) -> f64 {
        triangle_area(&self.mesh_facets[facet].map(|n| self.coordinates[n]))
    }
}

impl ContactSurface {
    /// Multipliers that are constant on panes, given the pane of every triangle.
    #[must_use]
    pub(super) fn with_panes(face: FaceTriangles<'_>, facet_pane: Vec<usize>) -> Self {
        let nodes = face.nodes();
        let n_panes = facet_pane.iter().max().map_or(0, |p| p + 1);
        let mut shares: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n_panes];
        let mut pane_area = vec![0.0; n_panes];
        for (&facet, &pane) in face.facets.iter().zip(&facet_pane) {
            let area = face.area(facet);
            pane_area[pane] += area;
            for node in face.mesh_facets[facet] {
                let local = nodes.partition_point(|&n| n < node);
                match shares[pane].iter_mut().find(|(n, _)| *n == local) {
                    Some((_, share)) => *share += area / 3.0,
                    None => shares[pane].push((local, area / 3.0)),
                }
            }
        }
        Self {
            normal: face.normal,
            pane_average: average_matrix(nodes.len(), &mut shares, &pane_area),
            nodes,
            facets: face.facets,
            facet_pane,
            pane_area,
        }
    }

    /// One multiplier per contact node whose normal displacement is free, with lumped integration.
    #[must_use]
    pub(super) fn nodal(face: FaceTriangles<'_>, is_held: impl Fn(usize) -> bool) -> Self {
        let nodes = face.nodes();
        let mut hat_integral = vec![0.0; nodes.len()];
        for &facet in &face.facets {
            let third = face.area(facet) / 3.0;
            for node in face.mesh_facets[facet] {
                hat_integral[nodes.partition_point(|&n| n < node)] += third;
            }
        }
        let free: Vec<usize> = (0..nodes.len()).filter(|&n| !is_held(nodes[n])).collect();
        Self {
            normal: face.normal,
            pane_area: free.iter().map(|&n| hat_integral[n]).collect(),
            pane_average: CscMatrix {
                rows: nodes.len(),
                cols: free.len(),
                indptr: (0..=free.len()).collect(),
                data: vec![1.0; free.len()],
                indices: free,
            },
            nodes,
            facets: face.facets,
            facet_pane: Vec::new(),
        }
    }

    /// Number of panes m, or of nodes that carry multipliers.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        self.pane_area.len()
    }

    /// Whether each multiplier belongs to one node.
    #[must_use]
    pub fn is_nodal(&self) -> bool {
        self.facet_pane.is_empty()
    }

    /// The (contact node, weight) pairs of one pane; the weights sum to 1.
    pub fn pane_weights(&self, pane: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.pane_average.indptr[pane]..self.pane_average.indptr[pane + 1];
        range.map(|k| (self.pane_average.indices[k], self.pane_average.data[k]))
    }

    /// The mean over a pane of values at the contact nodes.
    #[must_use]
    pub(crate) fn pane_mean(&self, pane: usize, nodal: &[f64]) -> f64 {
        self.pane_weights(pane)
            .map(|(node, weight)| weight * nodal[node])
            .sum()
    }
}

/// The unit normal of a flat set of triangles, and the largest distance of a corner from the plane
/// over the extent of the set; `None` for no triangles, or without area.
pub(super) fn plane_of(
    coordinates: &[[f64; 3]],
    triangles: impl Iterator<Item = [usize; 3]> + Clone,
) -> Option<([f64; 3], f64)> {
    let corners = |t: [usize; 3]| t.map(|n| Vector3::from(coordinates[n]));
    let mut area_vector = Vector3::zeros();
    for [a, b, c] in triangles.clone().map(corners) {
        area_vector += (b - a).cross(&(c - a));
    }
    let normal = area_vector.try_normalize(0.0)?;
    let normal = snap_to_axis(normal);
    let origin = corners(triangles.clone().next()?)[0];
    let (mut distance, mut extent) = (0.0_f64, 0.0_f64);
    for point in triangles.flat_map(corners) {
        distance = distance.max((point - origin).dot(&normal).abs());
        extent = extent.max((point - origin).norm());
    }
    Some((normal.into(), distance / extent))
}

/// A normal along a coordinate axis to rounding is that axis, so that products with it are exact.
fn snap_to_axis(normal: Vector3<f64>) -> Vector3<f64> {
    let axis = normal.map(f64::round);
    if axis.norm() == 1.0 && (normal - axis).norm() < 8.0 * f64::EPSILON {
        axis
    } else {
        normal
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

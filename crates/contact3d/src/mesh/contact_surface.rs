//! The contact face Γ_c with the panes or nodes that carry multipliers.

use std::ops::Range;

use nalgebra::Vector3;

use super::{Mesh, Opposite};
use crate::linalg::CscMatrix;

/// The contact face Γ_c: its nodes, its triangles, and the pieces that carry multipliers: panes Rⁱ,
/// or the surroundings of single nodes.
///
/// It may consist of several faces, whose nodes, triangles and panes follow each other: a mesh node on two faces is two
/// contact nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactSurface {
    /// The faces, those with friction first.
    pub faces: Vec<SurfaceFace>,
    /// Unit normal ν of contact, out of the body and into the obstacle: one for the whole face where it is the same
    /// everywhere, or one for each contact node.
    pub normals: Vec<[f64; 3]>,
    /// Distance d from what lies opposite along ν in m, negative inside it, `[n_contact_nodes]`, 0 before a foundation; empty where none is.
    pub clearance: Vec<f64>,
    /// Mesh nodes on Γ_c, increasing on each face, `[n_contact_nodes]`.
    pub nodes: Vec<usize>,
    /// Boundary triangles on Γ_c (indices into the mesh's facets), `[n_contact_facets]`.
    pub facets: Vec<usize>,
    /// The pane of each contact triangle of the faces with panes, `[n_pane_facets]`; empty with nodal multipliers.
    pub facet_pane: Vec<usize>,
    /// Area |Rⁱ| of each pane in m², `[n_panes]`; with nodal multipliers the integral of the
    /// node's hat function.
    pub pane_area: Vec<f64>,
    /// Averaging over panes: column i holds (1/|Rⁱ|) ∫_{Rⁱ} φ_j over contact nodes j,
    /// `[n_contact_nodes, n_panes]`; each column sums to 1. For the 2 × 2 macro-faces of a brick
    /// it is 4/12 at the centre and 1/12 at the eight other nodes; with nodal multipliers (lumped
    /// integration) it is 1 at the node itself.
    pub pane_average: CscMatrix,
    /// What lies opposite on other bodies; `None` where no face touches one.
    pub opposite: Option<Opposite>,
}

/// One face of a [`ContactSurface`]: where its nodes, triangles and panes lie.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SurfaceFace {
    /// Its contact nodes.
    pub nodes: Range<usize>,
    /// Its contact triangles.
    pub facets: Range<usize>,
    /// Its panes, or nodes that carry multipliers.
    pub panes: Range<usize>,
    /// Whether each multiplier belongs to one node.
    pub is_nodal: bool,
}

impl SurfaceFace {
    /// The only face.
    #[must_use]
    pub fn only(n_nodes: usize, n_facets: usize, n_panes: usize, is_nodal: bool) -> Self {
        Self {
            nodes: 0..n_nodes,
            facets: 0..n_facets,
            panes: 0..n_panes,
            is_nodal,
        }
    }

    /// The same face with others before it.
    fn shifted(&self, nodes: usize, facets: usize, panes: usize) -> Self {
        let moved = |range: &Range<usize>, by: usize| range.start + by..range.end + by;
        Self {
            nodes: moved(&self.nodes, nodes),
            facets: moved(&self.facets, facets),
            panes: moved(&self.panes, panes),
            is_nodal: self.is_nodal,
        }
    }
}

/// Triangles of a face and the integrals of their nodes' shape functions.
pub(super) struct ContactFace {
    /// As [`ContactSurface::opposite`], with products by triangles in place of panes.
    pub(super) opposite: Option<Opposite>,
    /// The nodes of the face, increasing.
    pub(super) nodes: Vec<usize>,
    /// As [`ContactSurface::normals`].
    pub(super) normals: Vec<[f64; 3]>,
    /// As [`ContactSurface::clearance`].
    pub(super) clearance: Vec<f64>,
    pub(super) triangles: Vec<FaceTriangle>,
}

/// One triangle of the contact face.
#[derive(Debug, Clone)]
pub(super) struct FaceTriangle {
    /// Its place among the boundary triangles of the mesh.
    pub(super) facet: usize,
    /// Area in m².
    pub(super) area: f64,
    /// Its nodes, each with ∫ φ in m² over the triangle: a third of the area for the corners of P1; on
    /// straight sides of P2 nothing for corners and a third for the middle of each edge.
    pub(super) integrals: Vec<(usize, f64)>,
    /// The nodes that can carry a multiplier of their own: corners of P1, mid-edge nodes of P2.
    pub(super) carriers: [usize; 3],
}

impl FaceTriangle {
    /// The carriers with the area that each stands for in m²: its own integral, and a third of those of the nodes
    /// that carry nothing.
    fn lumped(&self) -> [(usize, f64); 3] {
        let is_carrier = |node: &usize| self.carriers.contains(node);
        let others = self.integrals.iter().filter(|(node, _)| !is_carrier(node));
        let rest: f64 = others.map(|(_, integral)| integral).sum();
        self.carriers.map(|carrier| {
            let own = self.integrals.iter().find(|(node, _)| *node == carrier);
            (
                carrier,
                own.map_or(0.0, |(_, integral)| *integral) + rest / 3.0,
            )
        })
    }
}

impl ContactFace {
    fn facets(&self) -> Vec<usize> {
        self.triangles
            .iter()
            .map(|triangle| triangle.facet)
            .collect()
    }
}

impl ContactSurface {
    /// Multipliers that are constant on panes, given the pane of every triangle.
    #[must_use]
    pub(super) fn with_panes(face: ContactFace, facet_pane: Vec<usize>) -> Self {
        let nodes = &face.nodes;
        let n_panes = facet_pane.iter().max().map_or(0, |p| p + 1);
        let mut shares: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n_panes];
        let mut pane_area = vec![0.0; n_panes];
        for (triangle, &pane) in face.triangles.iter().zip(&facet_pane) {
            pane_area[pane] += triangle.area;
            for &(node, integral) in triangle.integrals.iter().filter(|(_, i)| *i != 0.0) {
                let local = nodes.partition_point(|&n| n < node);
                match shares[pane].iter_mut().find(|(n, _)| *n == local) {
                    Some((_, share)) => *share += integral,
                    None => shares[pane].push((local, integral)),
                }
            }
        }
        let only = SurfaceFace::only(nodes.len(), face.triangles.len(), n_panes, false);
        let pane_average = average_matrix(nodes.len(), &mut shares, &pane_area);
        let facets = face.facets();
        Self {
            faces: vec![only],
            opposite: face.opposite.map(|of| of.on_panes(&facet_pane, n_panes)),
            pane_average,
            facets,
            nodes: face.nodes,
            normals: face.normals,
            clearance: face.clearance,
            facet_pane,
            pane_area,
        }
    }

    /// One multiplier per carrying contact node whose normal displacement is free, with lumped
    /// integration, a third of each flat triangle's area for each of its carriers; `is_held` tells by the node and ν.
    #[must_use]
    pub(super) fn nodal(face: ContactFace, is_held: impl Fn(usize, [f64; 3]) -> bool) -> Self {
        let nodes = &face.nodes;
        let mut weight = vec![0.0; nodes.len()];
        for (node, share) in face.triangles.iter().flat_map(FaceTriangle::lumped) {
            weight[nodes.partition_point(|&n| n < node)] += share;
        }
        let carries =
            |n: &usize| weight[*n] > 0.0 && !is_held(nodes[*n], at_node(&face.normals, *n));
        let free: Vec<usize> = (0..nodes.len()).filter(carries).collect();
        let only = SurfaceFace::only(nodes.len(), face.triangles.len(), free.len(), true);
        Self {
            faces: vec![only],
            pane_area: free.iter().map(|&n| weight[n]).collect(),
            pane_average: CscMatrix {
                rows: nodes.len(),
                cols: free.len(),
                indptr: (0..=free.len()).collect(),
                data: vec![1.0; free.len()],
                indices: free,
            },
            facets: face.facets(),
            opposite: None,
            facet_pane: Vec::new(),
            nodes: face.nodes,
            normals: face.normals,
            clearance: face.clearance,
        }
    }

    /// ν at a contact node.
    #[must_use]
    pub fn normal_at(&self, contact_node: usize) -> [f64; 3] {
        at_node(&self.normals, contact_node)
    }

    /// Number of panes m, or of nodes that carry multipliers.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        self.pane_area.len()
    }

    /// Whether each multiplier belongs to one node, on all faces.
    #[must_use]
    pub fn is_nodal(&self) -> bool {
        self.facet_pane.is_empty()
    }

    /// One face after the other.
    #[must_use]
    pub(super) fn joined(surfaces: Vec<Self>) -> Option<Self> {
        surfaces.into_iter().reduce(Self::joined_with)
    }

    fn joined_with(mut self, next: Self) -> Self {
        let (nodes, facets, panes) = (self.nodes.len(), self.facets.len(), self.n_panes());
        let normals = |surface: &Self| -> Vec<[f64; 3]> {
            let nodes = 0..surface.nodes.len();
            nodes.map(|node| surface.normal_at(node)).collect()
        };
        self.normals = [normals(&self), normals(&next)].concat();
        if !(self.clearance.is_empty() && next.clearance.is_empty()) {
            self.clearance.resize(nodes, 0.0);
            self.clearance.extend(&next.clearance);
            self.clearance.resize(nodes + next.nodes.len(), 0.0);
        }
        if self.opposite.is_some() || next.opposite.is_some() {
            let n_mesh_nodes = [&self.opposite, &next.opposite].into_iter().flatten();
            let n_mesh_nodes = n_mesh_nodes.map(|of| of.points.rows).max().unwrap_or(0);
            let nothing = |nodes, panes| Opposite::nothing(n_mesh_nodes, nodes, panes);
            let own = self.opposite.get_or_insert_with(|| nothing(nodes, panes));
            let (more, of) = ([next.nodes.len(), next.n_panes()], next.opposite.clone());
            own.joined_with(of.unwrap_or_else(|| nothing(more[0], more[1])));
        }
        let faces = next.faces.iter();
        self.faces
            .extend(faces.map(|face| face.shifted(nodes, facets, panes)));
        self.facet_pane
            .extend(next.facet_pane.iter().map(|pane| pane + panes));
        self.pane_average.rows += next.pane_average.rows;
        for pane in 0..next.pane_average.cols {
            let weights = next.pane_average.entries(pane);
            let moved = weights.map(|(node, weight)| (node + nodes, weight));
            self.pane_average.push_column(moved);
        }
        self.nodes.extend(next.nodes);
        self.facets.extend(next.facets);
        self.pane_area.extend(next.pane_area);
        self
    }

    /// The number of the face that a contact triangle belongs to.
    #[must_use]
    pub fn face_number(&self, place: usize) -> usize {
        self.faces.partition_point(|face| face.facets.end <= place)
    }

    /// The number of the face that a pane belongs to.
    #[must_use]
    pub fn face_of_pane(&self, pane: usize) -> usize {
        self.faces.partition_point(|face| face.panes.end <= pane)
    }

    /// The face that a contact triangle belongs to.
    #[must_use]
    pub fn face_of_facet(&self, place: usize) -> &SurfaceFace {
        &self.faces[self.face_number(place)]
    }

    /// The pane of a contact triangle; `None` on a face with nodal multipliers.
    #[must_use]
    pub fn pane_of_facet(&self, place: usize) -> Option<usize> {
        let mut before = 0;
        for face in &self.faces {
            if face.facets.contains(&place) {
                let inside = before + place - face.facets.start;
                return (!face.is_nodal).then(|| self.facet_pane[inside]);
            }
            if !face.is_nodal {
                before += face.facets.len();
            }
        }
        None
    }

    /// The panes of a contact triangle: one, or the multipliers of its nodes.
    pub(crate) fn panes_of_facet(&self, mesh: &Mesh, place: usize) -> Vec<usize> {
        let face = self.face_of_facet(place);
        let nodes = mesh.facet_nodes(self.facets[place]);
        let carried = |node: usize| self.carried_by(face, self.contact_node(face, node)?);
        match self.pane_of_facet(place) {
            Some(pane) => vec![pane],
            None => nodes.filter_map(carried).collect(),
        }
    }

    /// The panes that share a node with each, or the multipliers that share a triangle where nodes carry them, increasing, `[n_panes]`.
    pub(crate) fn panes_beside(&self, mesh: &Mesh) -> Vec<Vec<usize>> {
        let mut beside = vec![Vec::new(); self.n_panes()];
        let mut at_node = vec![Vec::new(); self.nodes.len()];
        for place in 0..self.facets.len() {
            let panes = self.panes_of_facet(mesh, place);
            panes.iter().for_each(|&pane| beside[pane].extend(&panes));
            if let Some(pane) = self.pane_of_facet(place) {
                let face = self.face_of_facet(place);
                // Of a triangle that another body covers in part, some nodes may be none of the contact face.
                let nodes = mesh.facet_nodes(self.facets[place]);
                let nodes = nodes.filter_map(|node| self.contact_node(face, node));
                nodes.for_each(|node| at_node[node].push(pane));
            }
        }
        for panes in &at_node {
            panes.iter().for_each(|&pane| beside[pane].extend(panes));
        }
        for (pane, others) in beside.iter_mut().enumerate() {
            others.sort_unstable();
            others.dedup();
            others.retain(|&other| other != pane);
        }
        beside
    }

    /// The contact node that a mesh node is on a face.
    #[must_use]
    pub fn contact_node(&self, face: &SurfaceFace, mesh_node: usize) -> Option<usize> {
        let nodes = &self.nodes[face.nodes.clone()];
        let found = nodes.binary_search(&mesh_node).ok()?;
        Some(face.nodes.start + found)
    }

    /// The contact nodes of a contact triangle with the given nodes of the mesh, all of them on its face.
    pub(crate) fn contact_nodes<const K: usize>(
        &self,
        place: usize,
        mesh_nodes: [usize; K],
    ) -> [usize; K] {
        let face = self.face_of_facet(place);
        let nodes = &self.nodes[face.nodes.clone()];
        mesh_nodes.map(|node| face.nodes.start + nodes.partition_point(|&n| n < node))
    }

    /// The multiplier that a contact node of a face with nodal multipliers carries.
    #[must_use]
    pub fn carried_by(&self, face: &SurfaceFace, contact_node: usize) -> Option<usize> {
        // One entry in each column of the average, increasing on each face.
        let columns = &self.pane_average.indptr;
        let first = columns[face.panes.start];
        let carriers = &self.pane_average.indices[first..columns[face.panes.end]];
        let found = carriers.binary_search(&contact_node).ok()?;
        face.is_nodal.then_some(face.panes.start + found)
    }

    /// The (contact node, weight) pairs of one pane; the weights sum to 1.
    pub fn pane_weights(&self, pane: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.pane_average.entries(pane)
    }

    /// The centroid of a pane in m.
    #[must_use]
    pub fn pane_centre(&self, mesh: &Mesh, pane: usize) -> [f64; 3] {
        let weights = self.pane_weights(pane);
        weights.fold([0.0; 3], |sum, (node, weight)| {
            let at = mesh.coordinates[self.nodes[node]];
            [0, 1, 2].map(|c| sum[c] + weight * at[c])
        })
    }

    /// The nodes of the mesh that contact forces or slips are of, on both sides of a face between bodies; some of them repeatedly.
    pub(crate) fn nodes_of_both_sides(&self) -> impl Iterator<Item = usize> + '_ {
        let opposite = self.opposite.iter();
        let under_panes = opposite.clone().flat_map(|of| &of.products).flatten();
        let under_nodes = opposite.flat_map(|of| &of.points.indices).copied();
        let own = self.nodes.iter().copied();
        own.chain(under_panes.map(|(_, node, _)| *node))
            .chain(under_nodes)
    }

    /// ∫ φ_j ψ_k in m² over a pane as (contact node j, node k of the mesh, integral); none where it touches no body.
    #[must_use]
    pub fn products(&self, pane: usize) -> &[(usize, usize, f64)] {
        let opposite = self.opposite.as_ref();
        opposite.map_or(&[], |of| &of.products[pane])
    }

    /// Whether a pane touches another body.
    #[must_use]
    pub fn touches_body(&self, pane: usize) -> bool {
        !self.products(pane).is_empty()
    }

    /// The mean over a pane of values at the contact nodes.
    #[must_use]
    pub(crate) fn pane_mean(&self, pane: usize, nodal: &[f64]) -> f64 {
        self.pane_weights(pane)
            .map(|(node, weight)| weight * nodal[node])
            .sum()
    }
}

/// The normal of a node among one for all nodes or one for each.
fn at_node(normals: &[[f64; 3]], node: usize) -> [f64; 3] {
    match normals {
        [everywhere] => *everywhere,
        each => each[node],
    }
}

/// The unit normal of a flat set of triangles, and the largest distance of a corner or of another
/// of its nodes from the plane over the extent of the set; `None` for no triangles, or without area.
pub(super) fn plane_of(
    coordinates: &[[f64; 3]],
    triangles: impl Iterator<Item = [usize; 3]> + Clone,
    others: impl Iterator<Item = usize>,
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
    let others = others.map(|node| Vector3::from(coordinates[node]));
    for point in triangles.flat_map(corners).chain(others) {
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
    let columns = shares.iter_mut().zip(pane_area).map(|(share, area)| {
        share.sort_by_key(|(node, _)| *node);
        share
            .iter()
            .map(move |(node, integral)| (*node, integral / area))
    });
    CscMatrix::of_columns(n_contact_nodes, columns)
}

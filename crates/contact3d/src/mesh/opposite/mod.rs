//! What lies opposite a contact face of another body.
//!
//! On the side s with panes the displacement jump is [u] = u_s − u_m, where m is the point of the other face along the normal of s. Its mean
//! over a pane needs ∫ φ_j ψ_k with the shape functions of both sides, which [`overlap`] integrates over the pieces that the triangles of
//! both faces have in common: quadrature points of one side alone do not pass the patch test (B. I. Wohlmuth, *SIAM J. Numer. Anal.* 38
//! (2000) 989; M. A. Puso, T. A. Laursen, *Comput. Methods Appl. Mech. Engrg.* 193 (2004) 601). At a contact node, where friction laws
//! see the slip, it is u_j − Σ_k ψ_k(Y_j) u_k with the point Y_j opposite the node ([`nodes`]).
//!
//! The normal is ν ∝ k_s n_s − k_m n_m with the moduli k = E/(1 − ν²) of both sides: the touching faces take the shape of the stiffer body.
//! With the normal of one side alone a gap d that closes at an angle θ is read as a slip d θ, a quarter of the stick zone of two cylinders.

mod nodes;
mod normals;
mod overlap;
mod surface;

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;
use rstar::{
    AABB, RTree,
    primitives::{GeomWithData, Rectangle},
};

pub(super) use nodes::NodePairing;
pub(super) use overlap::Overlap;

use super::{GEOMETRY_TOLERANCE, Mesh, contact_surface::plane_of};
use crate::linalg::CscMatrix;

/// What lies opposite contact nodes and panes, on faces that touch another body.
#[derive(Debug, Clone, PartialEq)]
pub struct Opposite {
    /// Π, `[n_nodes, n_contact_nodes]`: column j holds ψ_k(Y_j), which sum to 1, and nothing on faces that touch no body.
    pub points: CscMatrix,
    /// ∫ φ_j ψ_k over each pane in m², `[n_panes]`: (contact node j, mesh node k, integral); nothing on panes that touch no body.
    pub products: Vec<Vec<(usize, usize, f64)>>,
}

impl Opposite {
    /// The nodes opposite a contact node with their shares; none where no body is.
    pub fn at_node(&self, contact_node: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.points.entries(contact_node)
    }

    /// Products of triangles, gathered on the panes that these belong to.
    pub(super) fn on_panes(self, facet_pane: &[usize], n_panes: usize) -> Self {
        let mut sums: Vec<BTreeMap<(usize, usize), f64>> = vec![BTreeMap::new(); n_panes];
        for (pane, entries) in facet_pane.iter().zip(&self.products) {
            for (local, node, value) in entries {
                *sums[*pane].entry((*local, *node)).or_insert(0.0) += value;
            }
        }
        let flat = |sum: BTreeMap<(usize, usize), f64>| {
            let entries = sum.into_iter();
            entries
                .map(|((local, node), value)| (local, node, value))
                .collect()
        };
        Self {
            points: self.points,
            products: sums.into_iter().map(flat).collect(),
        }
    }

    /// For faces that touch no body.
    pub(super) fn nothing(n_nodes: usize, n_contact_nodes: usize, n_panes: usize) -> Self {
        let mut points = CscMatrix::empty(n_nodes);
        points.cols = n_contact_nodes;
        points.indptr = vec![0; n_contact_nodes + 1];
        Self {
            points,
            products: vec![Vec::new(); n_panes],
        }
    }

    /// The same for contact nodes and panes that follow those of `self`, which are `n_contact_nodes`.
    pub(super) fn joined_with(&mut self, next: Self) {
        let columns = self.points.cols;
        for column in 0..next.points.cols {
            self.points.push_column(next.points.entries(column));
        }
        let moved = |pane: Vec<(usize, usize, f64)>| {
            let entries = pane.into_iter();
            entries
                .map(|(local, node, value)| (local + columns, node, value))
                .collect()
        };
        self.products.extend(next.products.into_iter().map(moved));
    }
}

/// One of two faces: triangles of the boundary with the normals of their nodes.
pub(super) struct Face<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) facets: Vec<usize>,
    /// The unit normal at each node; the same for all of a flat face.
    pub(super) normals: BTreeMap<usize, Vector3<f64>>,
    /// Whether straight triangles stand for a curved face.
    has_straight_sides: bool,
    /// What normals leave of distances between the face and its mesh at most, in m.
    pub(super) unresolved: f64,
    /// The normal of a flat face.
    pub(super) plane: Option<Vector3<f64>>,
    /// E/(1 − ν²) in Pa.
    pub(super) modulus: f64,
}

impl<'a> Face<'a> {
    /// The face of some triangles, before a material with the modulus E/(1 − ν²) in Pa.
    pub(super) fn new(mesh: &'a Mesh, facets: Vec<usize>, modulus: f64) -> Self {
        let corners = facets.iter().map(|&f| mesh.facets[f]);
        let nodes: BTreeSet<usize> = facets.iter().flat_map(|&f| mesh.facet_nodes(f)).collect();
        let plane = plane_of(&mesh.coordinates, corners, nodes.iter().copied());
        let flat = plane.filter(|(_, unevenness)| *unevenness <= GEOMETRY_TOLERANCE);
        let plane = flat.map(|(normal, _)| normal.into());
        let (normals, has_straight_sides, unresolved) = match plane {
            Some(normal) => (nodes.iter().map(|n| (*n, normal)).collect(), false, 0.0),
            None => normals::of_curved(mesh, &facets),
        };
        Self {
            mesh,
            facets,
            normals,
            has_straight_sides,
            unresolved,
            plane,
            modulus,
        }
    }

    /// The mean longest edge of its triangles in m.
    pub(super) fn edge(&self) -> f64 {
        let edges = self.facets.iter().map(|&f| self.mesh.longest_edge(f));
        edges.sum::<f64>() / self.facets.len() as f64
    }

    pub(super) fn places(&self) -> impl Iterator<Item = Vector3<f64>> + '_ {
        let nodes = self.normals.keys();
        nodes.map(|node| Vector3::from(self.mesh.coordinates[*node]))
    }

    /// Half of the diagonal of the box around it in m.
    pub(super) fn radius(&self) -> f64 {
        let low = self
            .places()
            .fold(Vector3::repeat(f64::INFINITY), |m, x| m.inf(&x));
        let high = self
            .places()
            .fold(Vector3::repeat(f64::NEG_INFINITY), |m, x| m.sup(&x));
        (high - low).norm() / 2.0
    }
}

/// The triangles of a face by the boxes around them.
pub(super) struct Boxes {
    tree: RTree<GeomWithData<Rectangle<[f64; 3]>, usize>>,
    /// How far in m a face is looked for.
    reach: f64,
}

impl Boxes {
    /// The triangles of a face, for one that lies no farther away than it is wide.
    pub(super) fn of(face: &Face<'_>) -> Self {
        let boxes = face.facets.iter().map(|&facet| {
            let nodes = face.mesh.facet_nodes(facet);
            let places = nodes.map(|node| face.mesh.coordinates[node]);
            let corners: Vec<[f64; 3]> = places.collect();
            GeomWithData::new(Rectangle::from_aabb(AABB::from_points(&corners)), facet)
        });
        Self {
            tree: RTree::bulk_load(boxes.collect()),
            reach: face.radius(),
        }
    }

    /// The triangles on lines along a normal through some places, and others near them, increasing.
    pub(super) fn along(&self, normal: &Vector3<f64>, places: &[[f64; 3]]) -> Vec<usize> {
        let ends = [-self.reach, self.reach].map(|by| normal * by);
        let ends = places
            .iter()
            .flat_map(|x| ends.map(|end| Vector3::from(*x) + end));
        let ends: Vec<[f64; 3]> = ends.map(Into::into).collect();
        let found = self
            .tree
            .locate_in_envelope_intersecting(AABB::from_points(&ends));
        let mut found: Vec<usize> = found.map(|item| item.data).collect();
        found.sort_unstable();
        found
    }
}

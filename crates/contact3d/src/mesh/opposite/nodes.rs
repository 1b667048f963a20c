//! The points opposite contact nodes, with normals and gaps there.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;

use super::{Face, Overlap, overlap::Projection};
use crate::{linalg::UNIT_ROUNDING, reference::QUADRATIC_TRIANGLE_NODES};

/// What lies opposite a contact node.
#[derive(Debug, Clone)]
pub(in crate::mesh) struct NodePairing {
    /// Nodes opposite with ψ_k(Y), which sum to 1.
    pub(in crate::mesh) shares: Vec<(usize, f64)>,
    /// The least barycentric coordinate of Y in its triangle, negative beyond the edge of the other face.
    pub(in crate::mesh) least: f64,
    /// The contact normal ν.
    pub(in crate::mesh) normal: Vector3<f64>,
    /// (Y − X)·ν in m: the gap, negative where the bodies overlap.
    pub(in crate::mesh) distance: f64,
}

impl NodePairing {
    /// For the nodes of some overlaps: the nearest point of the other face along the normal of the node among the triangles that lie
    /// opposite those around the node; beyond the edge of the other face what its last triangle is extended to.
    pub(in crate::mesh) fn of_nodes(
        side: &Face<'_>,
        overlaps: &[&Overlap],
        other: &Face<'_>,
    ) -> BTreeMap<usize, Self> {
        let mut around: BTreeMap<usize, (f64, BTreeSet<usize>)> = BTreeMap::new();
        for overlap in overlaps {
            let facet = overlap.triangle.facet;
            let nodes = side.mesh.facet_nodes(facet);
            for (node, at) in nodes.zip(&QUADRATIC_TRIANGLE_NODES) {
                let (bulge, candidates) = around.entry(node).or_default();
                *bulge = side.bulge(facet, at);
                candidates.extend(&overlap.opposite);
            }
        }
        let pairs = around
            .into_iter()
            .filter_map(|(node, (bulge, candidates))| {
                Some((node, Self::of_node(side, node, bulge, &candidates, other)?))
            });
        pairs.collect()
    }

    fn of_node(
        side: &Face<'_>,
        node: usize,
        bulge: f64,
        candidates: &BTreeSet<usize>,
        other: &Face<'_>,
    ) -> Option<Self> {
        // A point on the common edge of two triangles is inside one of them but for rounding.
        const INSIDE: f64 = -1e-9;
        let place = Vector3::from(side.mesh.coordinates[node]);
        let along = side.normals[&node];
        let own_bulge = along * bulge;
        let points = candidates.iter().map(|&facet| {
            let projection = Projection::new(other.mesh, facet, along);
            let at = projection.point_at(&place);
            let least = at.into_iter().fold(f64::INFINITY, f64::min);
            let shape = other.mesh.facet_shape(&at);
            let (opposite, distance) = projection.place_of(&shape, &place);
            let bulge = other.bulge(facet, &at);
            (
                least,
                distance.abs(),
                facet,
                shape,
                opposite - along * bulge,
            )
        });
        let nearest = points.max_by(|a, b| {
            let by_place = if a.0 >= INSIDE && b.0 >= INSIDE {
                b.1.total_cmp(&a.1)
            } else {
                a.0.total_cmp(&b.0)
            };
            by_place.then(b.2.cmp(&a.2))
        });
        let (least, _, facet, shape, opposite) = nearest?;
        let shares: Vec<(usize, f64)> = other.mesh.facet_nodes(facet).zip(shape).collect();
        let theirs = match other.plane {
            Some(normal) => normal,
            None => {
                let terms = shares.iter();
                let sum: Vector3<f64> = terms.map(|(k, share)| other.normals[k] * *share).sum();
                sum.try_normalize(0.0).unwrap_or(-along)
            }
        };
        // Planes that are parallel to rounding have one normal.
        let is_parallel = (theirs + along).norm() <= UNIT_ROUNDING;
        let normal = if is_parallel && side.plane.is_some() && other.plane.is_some() {
            along
        } else {
            (along * side.modulus - theirs * other.modulus).normalize()
        };
        Some(Self {
            distance: (opposite - place - own_bulge).dot(&normal),
            shares,
            least,
            normal,
        })
    }
}

//! The contact face between two bodies: which side has panes, and which panes have something opposite.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::{Boxes, Face, NodePairing, Opposite, Overlap};
use crate::{
    linalg::CscMatrix,
    mesh::{
        ContactSurface, GEOMETRY_TOLERANCE, Mesh, SurfaceFace, contact_surface::ContactFace, sorted,
    },
    scene::{Contact, InvalidValue, Scene, Written, place_words},
};

/// The share below which a pane joins a neighbour: its pressure would be that of a sliver, and S as badly scaled as its square root.
const OWN_OVERLAP: f64 = 0.25;

/// The share of a pane that rounding covers where edges of two bodies lie on each other; a multiplier there has no force.
const ROUNDED_OVERLAP: f64 = 1e-8;

/// How many times stiffer a side is before the panes lie on the other one whatever its mesh.
const SIMILAR_STIFFNESS: f64 = 2.0;

impl Mesh {
    /// The contact between the faces of two bodies, with what a first mesh left of them in m where this one was cut from it.
    ///
    /// # Errors
    /// Faces that nowhere lie opposite each other, or overlap.
    pub(in crate::mesh) fn pair_surface(
        &self,
        scene: &Scene,
        entry: usize,
        (pair, cut_faceting): (&[String; 2], Option<f64>),
        held: &[[bool; 3]],
    ) -> Result<ContactSurface, InvalidValue> {
        let key = scene.contact_key(entry);
        let faces = pair.each_ref().map(|name| self.pair_face(scene, name));
        let first = self.side_with_panes(scene, entry, &faces);
        let (side, other) = (&faces[first], &faces[1 - first]);
        let boxes = Boxes::of(other);
        let overlaps: Vec<Overlap> = side
            .facets
            .par_iter()
            .map(|&facet| Overlap::of(side, facet, other, &boxes))
            .collect();
        let panes = match cut_faceting {
            None => self.panes_of(scene, &pair[first], &side.facets, held),
            Some(_) => self.grouped_panes(&side.facets, held),
        };
        let panes = panes.map_err(|invalid| InvalidValue {
            key: format!("{key}.between"),
            help: "refine the mesh of the face with panes, or name the other one by panes_on"
                .into(),
            ..invalid
        })?;
        let panes = self.covered_panes(&overlaps, panes);
        let kept: Vec<(&Overlap, usize)> = overlaps
            .iter()
            .zip(panes)
            .filter_map(|(overlap, pane)| Some((overlap, pane?)))
            // Nodes of other triangles in a pane may have no point opposite.
            .filter(|(overlap, _)| !overlap.opposite.is_empty())
            .collect();
        if kept.is_empty() {
            return Err(InvalidValue {
                key: format!("{key}.between"),
                expected: "faces that look at each other".into(),
                found: Written(pair).to_string(),
                help: "no triangle of one has a triangle of the other on the line along its normal: place the bodies with body.origin, or name the faces that touch".into(),
            });
        }
        let (overlaps, panes): (Vec<&Overlap>, Vec<usize>) = kept.into_iter().unzip();
        let pairings = NodePairing::of_nodes(side, &overlaps, other);
        let face = self.face_of_pairings(&overlaps, &pairings);
        if !scene.contacts[entry].interference {
            let digits = GEOMETRY_TOLERANCE * side.radius().min(other.radius());
            let inherited = cut_faceting.unwrap_or(0.0);
            let allowed = side.unresolved + other.unresolved + inherited + digits;
            self.refuse_overlap(&key, &pairings, allowed)?;
        }
        Ok(ContactSurface::with_panes(face, panes))
    }

    /// Whether the panes of a contact between two bodies lie on the second of its faces.
    #[must_use]
    pub(crate) fn is_on_second_face(
        &self,
        contact: &Contact,
        surface: &ContactSurface,
        face: &SurfaceFace,
    ) -> bool {
        contact
            .between
            .as_ref()
            .is_some_and(|[_, second]| self.face_with_panes(surface, face) == second)
    }

    /// The name of the face of the mesh that a contact face lies on, of two bodies that of the side with panes.
    pub(crate) fn face_with_panes(&self, surface: &ContactSurface, face: &SurfaceFace) -> &str {
        let facet = surface.facets[face.facets.start];
        &self.face_names[self.facet_face[facet]]
    }

    /// A face of a pair with the modulus of the material behind it, the mean over its triangles of 1/k.
    pub(in crate::mesh) fn pair_face(&self, scene: &Scene, name: &str) -> Face<'_> {
        let facets: Vec<usize> = self.facets_on(name).collect();
        let moduli: Vec<f64> = scene
            .materials()
            .map(|(_, m)| m.contact_modulus())
            .collect();
        let behind = self.behind(facets.iter().copied());
        let region = |t: &usize| self.tetrahedron_region.get(*t).copied().unwrap_or(0);
        let yielding = behind.iter().map(|t| moduli[region(t)].recip());
        let modulus = behind.len() as f64 / yielding.sum::<f64>();
        Face::new(self, facets, modulus)
    }

    /// The number of the face that the multipliers belong to: the softer one, of similar ones that with the finer mesh. The smallest
    /// eigenvalue of S, scaled by panes, is then bounded below whatever the ratio of meshes and stiffnesses.
    pub(in crate::mesh) fn side_with_panes(
        &self,
        scene: &Scene,
        entry: usize,
        faces: &[Face<'_>; 2],
    ) -> usize {
        let contact = &scene.contacts[entry];
        if let Some(wanted) = &contact.panes_on {
            return usize::from(contact.faces()[0] != wanted);
        }
        let [first, second] = faces.each_ref().map(|face| face.modulus);
        if first > SIMILAR_STIFFNESS * second || second > SIMILAR_STIFFNESS * first {
            return usize::from(second < first);
        }
        let [first, second] = faces.each_ref().map(Face::edge);
        usize::from(second < first)
    }

    fn panes_of(
        &self,
        scene: &Scene,
        face: &str,
        facets: &[usize],
        held: &[[bool; 3]],
    ) -> Result<Vec<usize>, InvalidValue> {
        let Some((spec, side)) = scene.brick_face(face) else {
            return self.grouped_panes(facets, held);
        };
        let per_pane = scene.element().cells_per_pane();
        let along = (0..3).filter(|axis| *axis != side.axis());
        let odd = along
            .filter(|axis| !spec.cells[*axis].is_multiple_of(per_pane))
            .count();
        if odd > 0 {
            return Err(InvalidValue {
                key: "contact.between".into(),
                expected: format!("even numbers of cells along {face}, which has the panes"),
                found: Written(&spec.cells).to_string(),
                help: "a pane is 2 x 2 cells, with body.element = \"P2\" one; or name the other face by panes_on".into(),
            });
        }
        let triangles: Vec<[usize; 3]> = facets.iter().map(|&f| self.facets[f]).collect();
        Ok(self.brick_panes(scene, face, &triangles))
    }

    /// The panes of triangles after those with nothing opposite are left out, and those with little joined to the neighbour with the
    /// longest common edge.
    fn covered_panes(&self, overlaps: &[Overlap], panes: Vec<usize>) -> Vec<Option<usize>> {
        let n_panes = panes.iter().max().map_or(0, |pane| pane + 1);
        let (mut whole, mut covered) = (vec![0.0; n_panes], vec![0.0; n_panes]);
        for (overlap, &pane) in overlaps.iter().zip(&panes) {
            let (area, _) = self.side_integrals(overlap.triangle.facet);
            whole[pane] += area;
            covered[pane] += overlap.triangle.area;
        }
        let share = |pane: usize| match covered[pane] / whole[pane] {
            rounded if rounded < ROUNDED_OVERLAP => 0.0,
            share => share,
        };
        let mut joined: Vec<usize> = (0..n_panes).collect();
        let borders = self.borders(overlaps, &panes);
        let is_sliver = |pane: &usize| share(*pane) > 0.0 && share(*pane) < OWN_OVERLAP;
        for pane in (0..n_panes).filter(is_sliver) {
            let beside = borders.iter().filter_map(|(&[a, b], &length)| match pane {
                p if p == a => Some((b, length)),
                p if p == b => Some((a, length)),
                _ => None,
            });
            let beside = beside.filter(|(other, _)| share(*other) >= OWN_OVERLAP);
            let longest = beside.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
            joined[pane] = longest.map_or(pane, |(other, _)| other);
        }
        let is_kept = |pane: usize| share(pane) > 0.0 && joined[pane] == pane;
        let kept = (0..n_panes).filter(|&pane| is_kept(pane));
        let number: BTreeMap<usize, usize> = kept.zip(0..).collect();
        let places = panes
            .iter()
            .map(|&pane| (share(pane) > 0.0).then(|| number[&joined[pane]]));
        places.collect()
    }

    /// The lengths of the edges between panes in m.
    fn borders(&self, overlaps: &[Overlap], panes: &[usize]) -> BTreeMap<[usize; 2], f64> {
        let mut edges: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        let mut borders: BTreeMap<[usize; 2], f64> = BTreeMap::new();
        for (overlap, &pane) in overlaps.iter().zip(panes) {
            let [a, b, c] = sorted(self.facets[overlap.triangle.facet]);
            for [from, to] in [[a, b], [b, c], [a, c]] {
                let Some(other) = edges.insert([from, to], pane) else {
                    continue;
                };
                if other != pane {
                    let [x, y] =
                        [from, to].map(|node| nalgebra::Vector3::from(self.coordinates[node]));
                    *borders
                        .entry([other.min(pane), other.max(pane)])
                        .or_insert(0.0) += (y - x).norm();
                }
            }
        }
        borders
    }

    /// The face with what lies opposite its nodes and triangles.
    fn face_of_pairings(
        &self,
        overlaps: &[&Overlap],
        pairings: &BTreeMap<usize, NodePairing>,
    ) -> ContactFace {
        let nodes: Vec<usize> = pairings.keys().copied().collect();
        let local = |node: usize| nodes.partition_point(|&n| n < node);
        let points = pairings.values().map(|pairing| {
            let mut shares = pairing.shares.clone();
            shares.retain(|(_, share)| *share != 0.0);
            shares.sort_by_key(|(node, _)| *node);
            shares
        });
        let points = CscMatrix::of_columns(self.coordinates.len(), points);
        let products = overlaps.iter().map(|overlap| {
            let entries = overlap.products.iter().filter(|(_, value)| **value != 0.0);
            entries
                .map(|((j, k), value)| (local(*j), *k, *value))
                .collect()
        });
        let mut normals: Vec<[f64; 3]> = pairings.values().map(|p| p.normal.into()).collect();
        if normals.iter().all(|normal| *normal == normals[0]) {
            normals.truncate(1);
        }
        // Distances of touching nodes are roundings of their coordinates.
        let sizes = nodes.iter().flat_map(|&node| self.coordinates[node]);
        let rounding = 16.0 * f64::EPSILON * sizes.fold(0.0, |most: f64, x| most.max(x.abs()));
        let distance = |p: &NodePairing| {
            if p.distance.abs() > rounding {
                p.distance
            } else {
                0.0
            }
        };
        let mut clearance: Vec<f64> = pairings.values().map(distance).collect();
        if clearance.iter().all(|d| *d == 0.0) {
            clearance.clear();
        }
        ContactFace {
            opposite: Some(Opposite {
                points,
                products: products.collect(),
            }),
            nodes,
            normals,
            clearance,
            triangles: overlaps
                .iter()
                .map(|overlap| overlap.triangle.clone())
                .collect(),
        }
    }

    /// Refuses bodies that lie inside each other by more than `allowed` in m.
    fn refuse_overlap(
        &self,
        key: &str,
        pairings: &BTreeMap<usize, NodePairing>,
        allowed: f64,
    ) -> Result<(), InvalidValue> {
        let deepest = pairings
            .iter()
            .min_by(|a, b| a.1.distance.total_cmp(&b.1.distance));
        match deepest.filter(|(_, pairing)| pairing.distance < -allowed) {
            None => Ok(()),
            Some((node, pairing)) => Err(InvalidValue {
                key: format!("{key}.between"),
                expected: format!(
                    "bodies outside each other; up to {allowed:.1e} deep counts as touching"
                ),
                found: format!(
                    "one inside the other by {} at {}",
                    Written(&-pairing.distance),
                    place_words(self.coordinates[*node])
                ),
                help: "move one of them away by that depth with body.origin, or write interference = true to press them apart".into(),
            }),
        }
    }
}

//! Glued faces of two bodies, whose meshes need not match.
//!
//! The nodes of one face follow the other such that ∫ ψ_j (u_s − u_m) = 0 with dual functions ψ_j, ∫ ψ_j φ_i = δ_ij ∫ φ_j: that leaves
//! u_j = Σ_k ∫ ψ_j φ_k / ∫ φ_j u_k with few nodes k of the other face (B. I. Wohlmuth, *SIAM J. Numer. Anal.* 38 (2000) 989). On the common
//! part of a triangle ψ = D M⁻¹ φ with its masses M and D = diag ∫ φ_j. Functions of corners of quadratic triangles have no integral;
//! φ̃_a = φ_a + α Σ φ_m with the middles m of its edges has one, and φ̃_m = (1 − 2α) φ_m keeps their sum (A. Popp, B. I. Wohlmuth,
//! M. W. Gee, W. A. Wall, *SIAM J. Sci. Comput.* 34 (2012) B421): u_m = (1 − 2α) ũ_m + α (u_a + u_b), u_a = ũ_a.
//!
//! The same relation places the nodes, x_j = Σ_k … x_k: then no rigid motion strains the joint, whatever the gap was.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, Vector3};
use rayon::prelude::*;

use super::{
    Mesh,
    opposite::{Boxes, Face, Overlap},
    tetrahedron_volume,
};
use crate::{
    reference::TRIANGLE_EDGES,
    scene::{InvalidValue, Scene, Written, place_words},
};

/// A node of a face that is glued to another one.
#[derive(Debug, Clone, PartialEq)]
pub struct GluedNode {
    /// The node.
    pub node: usize,
    /// The contact of the scene that glues it.
    pub entry: usize,
    /// The nodes that it follows, u = Σ share u_k, with shares that sum to 1; those of them that are glued themselves come later in a mesh.
    pub shares: Vec<(usize, f64)>,
}

/// α: what the function of a corner takes of those in the middle of its edges.
const CORNER_SHARE: f64 = 0.2;

/// The share of a triangle that the other face covers below which its nodes do not follow for its sake: what a sliver would tell of them is
/// extrapolated over the whole triangle.
const LEAST_COVER: f64 = 0.01;

/// Uncovered share of a face that is rounding.
const ROUNDED_COVER: f64 = 1e-6;

/// Shares below this are roundings of none, where meshes match.
const ROUNDED_SHARE: f64 = 1e-13;

/// The largest gap over the mean edge of the triangles whose nodes are moved by it: the tetrahedra behind keep their shape.
const LARGEST_GAP: f64 = 0.25;

impl Mesh {
    /// Glues the faces of a scene: finds what their nodes follow, and moves them there. What a first mesh left of curved faces in m, where this
    /// one was cut from it, is no gap.
    ///
    /// # Errors
    /// Faces that nowhere lie opposite each other, a gap beyond [`LARGEST_GAP`], pairs whose nodes follow each other in a circle.
    pub(super) fn glue(&mut self, scene: &Scene, cut_faceting: f64) -> Result<(), InvalidValue> {
        let mut taken: BTreeSet<usize> = self.nodes_of_tools(scene).collect();
        for (entry, pair) in scene.glued_pairs() {
            let (found, edge) = self.glued_pair(scene, entry, pair, &taken)?;
            taken.extend(found.iter().map(|glued| glued.node));
            self.glued.extend(found);
            self.order_glued(scene, entry)?;
            let allowed = LARGEST_GAP * edge + cut_faceting;
            self.close_gap(scene, entry, allowed)?;
        }
        Ok(())
    }

    /// The bodies that move as one, in groups: one body, or several that are glued together.
    #[must_use]
    pub fn glued_bodies(&self) -> Vec<Vec<usize>> {
        let mut group: Vec<usize> = (0..self.bodies.len().max(1)).collect();
        for glued in &self.glued {
            let own = group[self.body_of_node(glued.node)];
            for (node, _) in &glued.shares {
                let other = group[self.body_of_node(*node)];
                let (low, high) = (own.min(other), own.max(other));
                group
                    .iter_mut()
                    .filter(|g| **g == high)
                    .for_each(|g| *g = low);
            }
        }
        let mut bodies: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (body, group) in group.into_iter().enumerate() {
            bodies.entry(group).or_default().push(body);
        }
        bodies.into_values().collect()
    }

    /// What the nodes of a pair follow, and the mean edge in m of the triangles that they belong to; `taken` nodes follow something else.
    fn glued_pair(
        &self,
        scene: &Scene,
        entry: usize,
        pair: &[String; 2],
        taken: &BTreeSet<usize>,
    ) -> Result<(Vec<GluedNode>, f64), InvalidValue> {
        let faces = pair.each_ref().map(|name| self.pair_face(scene, name));
        let overlaps = [0, 1].map(|first| covered(&faces[first], &faces[1 - first]));
        let is_whole = |k: usize| {
            let areas = faces[k].facets.iter().map(|&f| self.side_integrals(f).0);
            let common = overlaps[k].iter().map(|it| it.triangle.area);
            common.sum::<f64>() > (1.0 - ROUNDED_COVER) * areas.sum::<f64>()
        };
        let follows = match (is_whole(0), is_whole(1)) {
            (first, second) if first != second && scene.contacts[entry].panes_on.is_none() => {
                usize::from(second)
            }
            _ => self.side_with_panes(scene, entry, &faces),
        };
        let rows = dual_rows(self, &overlaps[follows]);
        if rows.is_empty() {
            return Err(InvalidValue {
                key: format!("{}.between", scene.contact_key(entry)),
                expected: "faces that look at each other".into(),
                found: Written(pair).to_string(),
                help: "no triangle of one has a triangle of the other on the line along its normal: place the bodies with body.origin, or name the faces that are glued".into(),
            });
        }
        let ends = self.middles_of(&faces[follows].facets);
        let followed = |(node, shares): (usize, BTreeMap<usize, f64>)| {
            let mut shares = shares;
            if let Some(ends) = ends.get(&node) {
                shares
                    .values_mut()
                    .for_each(|share| *share *= 1.0 - 2.0 * CORNER_SHARE);
                shares.extend(ends.map(|end| (end, CORNER_SHARE)));
            }
            GluedNode {
                node,
                entry,
                shares: whole(shares),
            }
        };
        let rows = rows.into_iter().filter(|(node, _)| !taken.contains(node));
        Ok((rows.map(followed).collect(), faces[follows].edge()))
    }

    /// The corners at both ends of the edges of some triangles by the nodes in their middle.
    fn middles_of(&self, facets: &[usize]) -> BTreeMap<usize, [usize; 2]> {
        let middles = self.mid_edges.iter();
        let facets = middles.flat_map(|middles| facets.iter().map(|&f| (f, middles.facets[f])));
        let edges = facets.flat_map(|(facet, middles)| {
            let ends = TRIANGLE_EDGES.map(|ends| ends.map(|k| self.facets[facet][k]));
            middles.into_iter().zip(ends)
        });
        edges.collect()
    }

    /// Puts glued nodes before those that they follow.
    fn order_glued(&mut self, scene: &Scene, entry: usize) -> Result<(), InvalidValue> {
        let rows: BTreeMap<usize, &GluedNode> = self.glued.iter().map(|g| (g.node, g)).collect();
        // None while the nodes that one follows are looked at.
        let mut depths: BTreeMap<usize, Option<usize>> = BTreeMap::new();
        let are_ordered = self
            .glued
            .iter()
            .all(|glued| depth(&rows, glued.node, &mut depths).is_some());
        if !are_ordered {
            return Err(InvalidValue {
                key: format!("{}.panes_on", scene.contact_key(entry)),
                expected: "glued faces whose nodes do not follow each other in a circle".into(),
                found: "a node that follows itself".into(),
                help: "name the face whose nodes follow the other by panes_on, in the pairs that meet there".into(),
            });
        }
        self.glued
            .sort_by_key(|glued| (std::cmp::Reverse(depths[&glued.node]), glued.node));
        Ok(())
    }

    /// Moves glued nodes to where their shares say.
    fn close_gap(&mut self, scene: &Scene, entry: usize, allowed: f64) -> Result<(), InvalidValue> {
        let mut largest = (0.0, 0);
        let mut is_moved = vec![false; self.coordinates.len()];
        for glued in self.glued.iter().rev() {
            let terms = glued.shares.iter();
            let terms = terms.map(|(k, share)| Vector3::from(self.coordinates[*k]) * *share);
            let to: Vector3<f64> = terms.sum();
            let way = (to - Vector3::from(self.coordinates[glued.node])).norm();
            if way > largest.0 && glued.entry == entry {
                largest = (way, glued.node);
            }
            // Roundings of places leave those of flat faces as they are.
            if way > ROUNDED_SHARE.sqrt() * allowed {
                self.coordinates[glued.node] = to.into();
                is_moved[glued.node] = true;
            }
        }
        let is_inverted = |corners: &[usize; 4]| {
            corners.iter().any(|node| is_moved[*node])
                && tetrahedron_volume(&self.corners(corners)) <= 0.0
        };
        let (gap, node) = largest;
        if gap <= allowed && !self.tetrahedra.iter().any(is_inverted) {
            return Ok(());
        }
        Err(InvalidValue {
            key: format!("{}.between", scene.contact_key(entry)),
            expected: format!(
                "glued faces up to {allowed:.3e} {} apart, a quarter of an edge of their triangles, for nodes are moved by the gap",
                scene.units.length()
            ),
            found: format!(
                "a gap of {} at {}",
                Written(&gap),
                place_words(self.coordinates[node])
            ),
            help: "move one of the bodies with body.origin, or name the faces that are glued"
                .into(),
        })
    }
}

/// How many glued nodes follow one another from a node on; `None` where they follow each other in a circle.
fn depth(
    rows: &BTreeMap<usize, &GluedNode>,
    node: usize,
    known: &mut BTreeMap<usize, Option<usize>>,
) -> Option<usize> {
    let Some(glued) = rows.get(&node) else {
        return Some(0);
    };
    if let Some(depth) = known.get(&node) {
        return *depth;
    }
    known.insert(node, None);
    let mut deepest = 0;
    for (next, _) in &glued.shares {
        deepest = deepest.max(depth(rows, *next, known)?);
    }
    known.insert(node, Some(deepest + 1));
    Some(deepest + 1)
}

/// What triangles of a face have in common with another one, without slivers.
fn covered(side: &Face<'_>, other: &Face<'_>) -> Vec<Overlap> {
    let boxes = Boxes::of(other);
    let overlaps = side.facets.par_iter();
    let overlaps = overlaps.map(|&facet| Overlap::of(side, facet, other, &boxes));
    let is_covered = |overlap: &Overlap| {
        let (whole, _) = side.mesh.side_integrals(overlap.triangle.facet);
        overlap.triangle.area > LEAST_COVER * whole
    };
    overlaps.filter(is_covered).collect()
}

/// What ũ of the nodes of some triangles follows: ∫ ψ_j φ_k / ∫ φ̃_j by nodes k of the other face.
fn dual_rows(mesh: &Mesh, overlaps: &[Overlap]) -> BTreeMap<usize, BTreeMap<usize, f64>> {
    let mut sums: BTreeMap<usize, (f64, BTreeMap<usize, f64>)> = BTreeMap::new();
    for overlap in overlaps {
        let nodes: Vec<usize> = mesh.facet_nodes(overlap.triangle.facet).collect();
        let mut others: Vec<usize> = overlap.products.keys().map(|(_, k)| *k).collect();
        others.sort_unstable();
        others.dedup();
        let with_integrals = with_integrals(nodes.len());
        let masses = DMatrix::from_fn(nodes.len(), nodes.len(), |i, j| overlap.masses[i][j]);
        let masses = &with_integrals * masses * with_integrals.transpose();
        let product = |j: usize, k: usize| overlap.products.get(&(nodes[j], others[k]));
        let products = DMatrix::from_fn(nodes.len(), others.len(), |j, k| {
            product(j, k).copied().unwrap_or(0.0)
        });
        let integrals: Vec<f64> = masses.row_iter().map(|row| row.sum()).collect();
        let Some(factor) = masses.cholesky() else {
            continue;
        };
        let shares = factor.solve(&(with_integrals * products));
        for (j, node) in nodes.iter().enumerate() {
            let (whole, row) = sums.entry(*node).or_default();
            *whole += integrals[j];
            for (k, other) in others.iter().enumerate() {
                *row.entry(*other).or_insert(0.0) += integrals[j] * shares[(j, k)];
            }
        }
    }
    let rows = sums.into_iter().map(|(node, (whole, mut row))| {
        row.values_mut().for_each(|share| *share /= whole);
        (node, row)
    });
    rows.collect()
}

/// φ̃ of a triangle with three or six nodes by its φ.
fn with_integrals(n: usize) -> DMatrix<f64> {
    let mut rows = DMatrix::identity(n, n);
    for (middle, ends) in (3..n).zip(TRIANGLE_EDGES) {
        rows[(middle, middle)] = 1.0 - 2.0 * CORNER_SHARE;
        ends.into_iter()
            .for_each(|end| rows[(end, middle)] = CORNER_SHARE);
    }
    rows
}

/// Shares without roundings of none, whose sum is 1.
pub(crate) fn whole(mut shares: BTreeMap<usize, f64>) -> Vec<(usize, f64)> {
    shares.retain(|_, share| share.abs() > ROUNDED_SHARE);
    let mut shares: Vec<(usize, f64)> = shares.into_iter().collect();
    let sum: f64 = shares.iter().map(|(_, share)| share).sum();
    let largest = shares.iter_mut().max_by(|a, b| a.1.total_cmp(&b.1));
    largest
        .into_iter()
        .for_each(|(_, share)| *share += 1.0 - sum);
    shares
}

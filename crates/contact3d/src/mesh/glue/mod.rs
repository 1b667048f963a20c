//! Glued faces of two bodies, whose meshes need not match.
//!
//! The nodes of one face follow the other such that ∫ ψ_j (u_s − u_m) = 0 with dual functions ψ_j, ∫ ψ_j φ_i = δ_ij ∫ φ_j: that leaves
//! u_j = Σ_k ∫ ψ_j φ_k / ∫ φ_j u_k with few nodes k of the other face (B. I. Wohlmuth, *SIAM J. Numer. Anal.* 38 (2000) 989). On the common
//! part of a triangle ψ = D M⁻¹ φ with its masses M and D = diag ∫ φ_j. Functions of corners of quadratic triangles have no integral;
//! φ̃_a = φ_a + α Σ φ_m with the middles m of its edges has one, and φ̃_m = (1 − 2α) φ_m keeps their sum (A. Popp, B. I. Wohlmuth,
//! M. W. Gee, W. A. Wall, *SIAM J. Sci. Comput.* 34 (2012) B421): u_m = (1 − 2α) ũ_m + α (u_a + u_b), u_a = ũ_a.
//!
//! Nodes t that clamps hold or that follow something else already, as on a line where joints meet, have no row. Their ψ_t go to functions
//! beside, for Σ ψ_j = 1 carries constant stress: ũ_j gains D_t/Σ D (Σ_k … u_k − ũ_t). Where nodes of the other face on that line follow
//! nothing yet, they follow the point of this one there, so that a ring of joints closes.
//!
//! The same relations place the nodes, x_j = Σ_k … x_k: then no rigid motion strains the joint, whatever the gap was.

mod dual;

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;
use units::Dimension;

pub(crate) use dual::whole;
use dual::{CORNER_SHARE, ROUNDED_SHARE, covered, dual_rows, pass_on};

use super::{
    DEEPEST_INTERFERENCE, GEOMETRY_TOLERANCE, Mesh,
    opposite::{Face, NodePairing, Overlap},
    tetrahedron_volume,
};
use crate::{
    linalg::UNIT_ROUNDING,
    reference::TRIANGLE_EDGES,
    scene::{Component, InvalidValue, Scene, Warning, Written, place_words},
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

/// What a pair of glued faces says of its nodes.
struct Joint {
    nodes: Vec<GluedNode>,
    /// The largest distance in m between the faces.
    gap: f64,
    /// What triangles leave of such distances, in m.
    unresolved: f64,
    /// How far in m nodes may be moved.
    allowed: f64,
    /// The largest share of a triangle of each face that the other one covers.
    cover: [f64; 2],
    /// What lies opposite the nodes of the face that follows and of the other one.
    pairings: [BTreeMap<usize, NodePairing>; 2],
}

/// Uncovered share of a face that is rounding.
const ROUNDED_COVER: f64 = 1e-6;

/// Share of a node below which a point is on the side without it: edges of two bodies lie on each other as near as that.
const ON_EDGE: f64 = 1e-3;

/// Share of a triangle that a joint covers below which the triangle is wider than the joint. On cells four times and twice as wide as itself and
/// as wide, of which it covers 28, 51 and 84 %, a pulled rib stores 22, 14 and 9 % less energy than it should, 10, 6 and 2 % with quadratic
/// elements.
const OWN_TRIANGLE: f64 = 0.75;

/// The largest gap over the mean edge of the triangles whose nodes are moved by it: the tetrahedra behind keep their shape.
const LARGEST_GAP: f64 = 0.25;

impl Mesh {
    /// Glues the faces of a scene: finds what their nodes follow, and moves them there. What a first mesh left of curved faces in m, where this
    /// one was cut from it, is no gap.
    ///
    /// # Errors
    /// Faces that nowhere lie opposite each other, a gap beyond [`LARGEST_GAP`] or [`DEEPEST_INTERFERENCE`], clamps that hold both faces at
    /// different values, pairs whose nodes follow each other in a circle.
    pub(super) fn glue(&mut self, scene: &Scene, cut_faceting: f64) -> Result<(), InvalidValue> {
        let held = self.held_nodes(scene);
        let held = (0..held.len()).filter(|node| held[*node] == [true; 3]);
        let mut taken: BTreeSet<usize> = held.collect();
        for (entry, pair) in scene.glued_pairs() {
            let joint = self.joint(scene, entry, pair, &taken)?;
            self.refuse_torn(scene, pair, &joint.pairings)?;
            taken.extend(joint.nodes.iter().map(|glued| glued.node));
            self.glued.extend(joint.nodes);
            self.order_glued(scene, entry)?;
            let allowed = joint.allowed + cut_faceting;
            let gap = Some(joint.gap).filter(|gap| *gap > joint.unresolved + cut_faceting);
            self.joint_gap.push(gap.unwrap_or(0.0));
            self.joint_cover.push(joint.cover);
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

    /// What the nodes of a pair follow; `taken` ones follow something else.
    fn joint(
        &self,
        scene: &Scene,
        entry: usize,
        pair: &[String; 2],
        taken: &BTreeSet<usize>,
    ) -> Result<Joint, InvalidValue> {
        let faces = pair.each_ref().map(|name| self.pair_face(scene, name));
        let overlaps = [0, 1].map(|first| covered(&faces[first], &faces[1 - first]));
        let follows = self.following(scene, entry, &faces, &overlaps);
        let rows = dual_rows(self, &overlaps[follows]);
        if rows.is_empty() {
            return Err(InvalidValue {
                key: format!("{}.between", scene.contact_key(entry)),
                expected: "faces that look at each other".into(),
                found: Written(pair).to_string(),
                help: "no triangle of one has a triangle of the other on the line along its normal: place the bodies with body.origin, or name the faces that are glued".into(),
            });
        }
        let pairings = [follows, 1 - follows].map(|k| {
            let overlaps: Vec<&Overlap> = overlaps[k].iter().collect();
            NodePairing::of_nodes(&faces[k], &overlaps, &faces[1 - k])
        });
        let [own, theirs] = &pairings;
        let inside = own.values().chain(theirs.values());
        let inside = inside.filter(|pairing| pairing.least >= -ON_EDGE);
        let size = faces.iter().map(Face::radius).fold(0.0, f64::max);
        let unresolved: f64 = faces.iter().map(|face| face.unresolved).sum();
        let cover = overlaps.each_ref().map(|overlaps| {
            let shares = overlaps
                .iter()
                .map(|it| it.triangle.area / self.side_integrals(it.triangle.facet).0);
            shares.fold(0.0, f64::max)
        });
        Ok(Joint {
            nodes: self.followers(entry, &overlaps[follows], rows, &pairings, taken),
            gap: inside.fold(0.0, |most, pairing| most.max(pairing.distance.abs())),
            unresolved: unresolved + GEOMETRY_TOLERANCE * size,
            allowed: unresolved
                + (LARGEST_GAP * faces[follows].edge()).min(DEEPEST_INTERFERENCE * self.extent()),
            cover,
            pairings,
        })
    }

    /// The number of the face whose nodes follow the other one.
    fn following(
        &self,
        scene: &Scene,
        entry: usize,
        faces: &[Face<'_>; 2],
        overlaps: &[Vec<Overlap>; 2],
    ) -> usize {
        let is_whole = |k: usize| {
            let areas = faces[k].facets.iter().map(|&f| self.side_integrals(f).0);
            let common = overlaps[k].iter().map(|it| it.triangle.area);
            common.sum::<f64>() > (1.0 - ROUNDED_COVER) * areas.sum::<f64>()
        };
        match (is_whole(0), is_whole(1)) {
            (first, second) if first != second && scene.contacts[entry].panes_on.is_none() => {
                usize::from(second)
            }
            _ => self.side_with_panes(scene, entry, faces),
        }
    }

    /// The nodes with rows of a face by its `overlaps`, and those of the other face that close a ring of joints.
    fn followers(
        &self,
        entry: usize,
        overlaps: &[Overlap],
        mut rows: BTreeMap<usize, (f64, BTreeMap<usize, f64>)>,
        [own, theirs]: &[BTreeMap<usize, NodePairing>; 2],
        taken: &BTreeSet<usize>,
    ) -> Vec<GluedNode> {
        let has_row = |node: usize| {
            let point = own.get(&node).and_then(|it| on_edge_of(it, taken));
            !taken.contains(&node) && !point.is_some_and(|it| self.leads_back(&it, node))
        };
        let rowless: BTreeSet<usize> = rows.keys().copied().filter(|it| !has_row(*it)).collect();
        let facets: Vec<usize> = overlaps.iter().map(|it| it.triangle.facet).collect();
        let ends = self.middles_of(&facets);
        pass_on(self, overlaps, &ends, &rowless, &mut rows);
        let followed = |(node, (_, mut shares)): (usize, (f64, BTreeMap<usize, f64>))| {
            if let Some(ends) = ends.get(&node) {
                shares
                    .values_mut()
                    .for_each(|share| *share *= 1.0 - 2.0 * CORNER_SHARE);
                for end in ends {
                    *shares.entry(*end).or_insert(0.0) += CORNER_SHARE;
                }
            }
            GluedNode {
                node,
                entry,
                shares: whole(shares),
            }
        };
        let rows = rows.into_iter().filter(|(node, _)| !rowless.contains(node));
        let closing = theirs.iter().filter_map(|(node, pairing)| {
            let point = on_edge_of(pairing, taken).filter(|_| !taken.contains(node))?;
            (!self.leads_back(&point, *node)).then(|| GluedNode {
                node: *node,
                entry,
                shares: whole(point),
            })
        });
        rows.map(followed).chain(closing).collect()
    }

    /// What a scene does not show of its joints.
    pub(crate) fn joint_warnings(&self, scene: &Scene) -> Vec<Warning> {
        let joints = self.joint_gap.iter().zip(&self.joint_cover);
        let warnings =
            scene
                .glued_pairs()
                .zip(joints)
                .flat_map(|((entry, pair), (&gap, cover))| {
                    let key = format!("{}.between", scene.contact_key(entry));
                    let coarse = pair
                        .iter()
                        .zip(cover)
                        .filter(|(_, cover)| **cover < OWN_TRIANGLE);
                    let narrow = coarse.map(|(face, &cover)| Warning::NarrowJoint {
                        key: key.clone(),
                        face: face.clone(),
                        cover,
                    });
                    let units = &scene.units;
                    let closed = (gap > 0.0).then(|| Warning::ClosedGap {
                        key: key.clone(),
                        gap: units.of(Dimension::LENGTH).told(&[gap]),
                    });
                    narrow.chain(closed).collect::<Vec<_>>()
                });
        warnings.collect()
    }

    /// Whether nodes follow others, which may follow others again, up to some of the body that a node is of.
    fn leads_back(&self, from: &BTreeMap<usize, f64>, to: usize) -> bool {
        let body = self.body_of_node(to);
        let mut left: Vec<usize> = from.keys().copied().collect();
        let mut seen = BTreeSet::new();
        while let Some(node) = left.pop() {
            if self.body_of_node(node) == body {
                return true;
            }
            if seen.insert(node) {
                let rows = self.glued.iter().filter(|glued| glued.node == node);
                left.extend(rows.flat_map(|glued| glued.shares.iter().map(|(k, _)| *k)));
            }
        }
        false
    }

    /// Refuses nodes that clamps hold where the nodes of the other face around them are held at other values.
    fn refuse_torn(
        &self,
        scene: &Scene,
        pair: &[String; 2],
        [pairings, _]: &[BTreeMap<usize, NodePairing>; 2],
    ) -> Result<(), InvalidValue> {
        let mut holding: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (index, clamp) in scene.clamps.iter().enumerate() {
            for node in self.clamped_nodes(clamp) {
                holding.entry(node).or_default().push(index);
            }
        }
        let clamp_of = |node: usize, axis: Component| {
            let clamps = holding.get(&node).into_iter().flatten();
            let mut clamps = clamps.filter(|it| scene.clamps[**it].components.contains(&axis));
            clamps.next().copied()
        };
        let inside = pairings.iter().filter(|(_, it)| it.least >= -ON_EDGE);
        for (node, pairing) in inside {
            let at = self.coordinates[*node];
            for axis in [Component::X, Component::Y, Component::Z] {
                let near = pairing.shares.iter().filter(|it| it.1.abs() > ON_EDGE);
                let others: Option<Vec<usize>> = near.map(|(k, _)| clamp_of(*k, axis)).collect();
                let Some((first, others)) = clamp_of(*node, axis).zip(others) else {
                    continue;
                };
                let value = |clamp: usize| scene.clamps[clamp].value[axis as usize].at(at);
                let differs = |other: &usize| {
                    let size = value(first).abs().max(value(*other).abs());
                    (value(first) - value(*other)).abs() > UNIT_ROUNDING * size
                };
                if let Some(other) = others.iter().find(|other| differs(other)) {
                    return Err(InvalidValue {
                        key: format!("clamp.{other}.value"),
                        expected: format!(
                            "{}, which clamp.{first} says of the displacement along {} at {} on the other one of the glued faces {} and {}",
                            Written(&value(first)),
                            axis.name(),
                            place_words(at),
                            pair[0],
                            pair[1],
                        ),
                        found: Written(&value(*other)).to_string(),
                        help: "glued faces move as one: give both clamps the same value there, or hold one body alone".into(),
                    });
                }
            }
        }
        Ok(())
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
                "glued faces up to {allowed:.3e} {} apart, a quarter of an edge of their triangles and a tenth of the bodies at most, for nodes are moved by the gap",
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

/// The nodes of the edge that a point lies on with its shares of them, where all of them are `taken`.
fn on_edge_of(point: &NodePairing, taken: &BTreeSet<usize>) -> Option<BTreeMap<usize, f64>> {
    let near = point.shares.iter().filter(|(_, s)| s.abs() > ON_EDGE);
    let near: BTreeMap<usize, f64> = near.copied().collect();
    (point.least >= -ON_EDGE && near.keys().all(|node| taken.contains(node))).then_some(near)
}

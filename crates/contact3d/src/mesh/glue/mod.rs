//! Glued faces of two bodies, whose meshes need not match.
//!
//! The nodes of one face follow the other such that ∫ ψ_j (u_s − u_m) = 0 with dual functions ψ_j, ∫ ψ_j φ_i = δ_ij ∫ φ_j: that leaves
//! u_j = Σ_k ∫ ψ_j φ_k / ∫ φ_j u_k with few nodes k of the other face (B. I. Wohlmuth, *SIAM J. Numer. Anal.* 38 (2000) 989). On the common
//! part of a triangle ψ = D M⁻¹ φ with its masses M and D = diag ∫ φ_j. Functions of corners of quadratic triangles have no integral;
//! φ̃_a = φ_a + α Σ φ_m with the middles m of its edges has one, and φ̃_m = (1 − 2α) φ_m keeps their sum (A. Popp, B. I. Wohlmuth,
//! M. W. Gee, W. A. Wall, *SIAM J. Sci. Comput.* 34 (2012) B421): u_m = (1 − 2α) ũ_m + α (u_a + u_b), u_a = ũ_a.
//!
//! A face that follows several others has one row a node, as if these were one face: ψ_j are those of what all of them cover.
//!
//! Nodes t that clamps hold or that follow something else already, as on a line where joints meet, have no row. Their ψ_t go to functions
//! beside, for Σ ψ_j = 1 carries constant stress: ũ_j gains D_t/Σ D (Σ_k … u_k − ũ_t). The faces with the fewest nodes take them first. Where
//! nodes of the other face on that line follow nothing in the end, they follow the point of this one there, so that a ring of joints closes.
//! [`order`] says which of two faces follows.
//!
//! The same relations place the nodes, x_j = Σ_k … x_k: then no rigid motion strains the joint, whatever the gap was.

mod dual;
mod order;

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;
use units::Dimension;

pub(crate) use dual::whole;
use dual::{CORNER_SHARE, LEAST_COVER, ROUNDED_SHARE, Row, covered, dual_rows, parts, pass_on};

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

/// What a node of a face follows in a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct GluedNode {
    /// The node.
    pub node: usize,
    /// The contact of the scene that glues it.
    pub entry: usize,
    /// The nodes that it follows, u = Σ share u_k, with shares that sum to 1 over its joints, which come one after the other in a mesh;
    /// those of them that are glued themselves come later.
    pub shares: Vec<(usize, f64)>,
}

/// A pair of glued faces.
struct Joint<'a> {
    entry: usize,
    pair: &'a [String; 2],
    /// What triangles of each face have in common with the other one.
    overlaps: [Vec<Overlap>; 2],
    /// The nodes of each face that take part.
    nodes: [BTreeSet<usize>; 2],
    /// What lies opposite the nodes of each face.
    pairings: [BTreeMap<usize, NodePairing>; 2],
    /// The nodes of each face, whether they take part or not.
    n_nodes: [usize; 2],
    /// The face whose nodes follow the other one, at first as the joint alone would have it, and whether only that one is covered wholly.
    follows: usize,
    is_whole: bool,
    /// The distance between the faces in m, where it is largest, negative where they overlap.
    gap: f64,
    /// What triangles leave of such distances, in m.
    unresolved: f64,
    /// How far in m nodes of each face may be moved.
    allowed: [f64; 2],
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
    /// different values, pairs whose nodes follow each other in a circle or are all taken by others.
    pub(super) fn glue(&mut self, scene: &Scene, cut_faceting: f64) -> Result<(), InvalidValue> {
        let held = self.held_nodes(scene);
        let held = (0..held.len()).filter(|node| held[*node] == [true; 3]);
        // Nodes without rows: what they follow.
        let mut taken: BTreeMap<usize, Vec<usize>> = held.map(|node| (node, Vec::new())).collect();
        let joints = scene.glued_pairs();
        let joints = joints.map(|(entry, pair)| self.joint(scene, entry, pair));
        let mut joints: Vec<Joint<'_>> = joints.collect::<Result<_, _>>()?;
        let order = order::orient(self, scene, &mut joints, &taken);
        let in_order: Vec<&Joint<'_>> = order.iter().map(|&j| &joints[j]).collect();
        let mut faces: BTreeMap<(usize, &String), Vec<&Joint<'_>>> = BTreeMap::new();
        for joint in &in_order {
            self.refuse_torn(scene, joint)?;
            let face = joint.rank(joint.follows);
            faces.entry(face).or_default().push(joint);
        }
        self.close_rings(&in_order, &mut taken);
        let mut lost = BTreeMap::new();
        for ((_, face), joints) in &faces {
            lost.insert(*face, self.follow(joints, &mut taken));
        }
        self.close_rings(&in_order, &mut taken);
        self.order_glued(scene)?;
        let overlaps = joints.iter().flat_map(|it| it.overlaps.iter().flatten());
        let mut bonded = BTreeMap::new();
        for triangle in overlaps.map(|overlap| &overlap.triangle) {
            *bonded.entry(triangle.facet).or_insert(0.0) += triangle.area;
        }
        for joint in &joints {
            let lost = &lost[&joint.pair[joint.follows]];
            self.refuse_lost(scene, joint, lost, &taken)?;
            let gap = Some(joint.gap).filter(|gap| gap.abs() > joint.unresolved + cut_faceting);
            self.joint_gap.push(gap.unwrap_or(0.0));
            let cover = joint.overlaps.each_ref().map(|overlaps| {
                let facets = overlaps.iter().map(|it| it.triangle.facet);
                let shares = facets.map(|facet| bonded[&facet] / self.side_integrals(facet).0);
                shares.fold(0.0, f64::max)
            });
            self.joint_cover.push(cover);
        }
        self.close_gaps(scene, &joints, cut_faceting)
    }

    /// What each glued node follows in its joints.
    pub(crate) fn glued_runs(&self) -> impl DoubleEndedIterator<Item = &[GluedNode]> {
        self.glued.chunk_by(|a, b| a.node == b.node)
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

    /// What the faces of a pair have in common.
    fn joint<'a>(
        &self,
        scene: &Scene,
        entry: usize,
        pair: &'a [String; 2],
    ) -> Result<Joint<'a>, InvalidValue> {
        let faces = pair.each_ref().map(|name| self.pair_face(scene, name));
        let overlaps = [0, 1].map(|first| covered(&faces[first], &faces[1 - first]));
        if overlaps.iter().any(Vec::is_empty) {
            return Err(InvalidValue {
                key: format!("{}.between", scene.contact_key(entry)),
                expected: "faces that look at each other".into(),
                found: Written(pair).to_string(),
                help: "no triangle of one has a triangle of the other on the line along its normal: place the bodies with body.origin, or name the faces that are glued".into(),
            });
        }
        let pairings = [0, 1].map(|k| {
            let overlaps: Vec<&Overlap> = overlaps[k].iter().collect();
            NodePairing::of_nodes(&faces[k], &overlaps, &faces[1 - k])
        });
        let nodes = [0, 1].map(|k| {
            let own = overlaps[k].iter().map(|it| it.triangle.facet);
            let seen = overlaps[1 - k]
                .iter()
                .flat_map(|it| it.opposite.iter().copied());
            own.chain(seen)
                .flat_map(|facet| self.facet_nodes(facet))
                .collect()
        });
        let inside = pairings.iter().flat_map(BTreeMap::values);
        let inside = inside.filter(|pairing| pairing.least >= -ON_EDGE);
        let gap = inside.map(|pairing| pairing.distance);
        let size = faces.iter().map(Face::radius).fold(0.0, f64::max);
        let unresolved: f64 = faces.iter().map(|face| face.unresolved).sum();
        let [first, second] = [0, 1].map(|k| {
            let areas = faces[k].facets.iter().map(|&f| self.side_integrals(f).0);
            let common = overlaps[k].iter().map(|it| it.triangle.area);
            common.sum::<f64>() > (1.0 - ROUNDED_COVER) * areas.sum::<f64>()
        });
        let is_whole = first != second && scene.contacts[entry].panes_on.is_none();
        Ok(Joint {
            entry,
            pair,
            nodes,
            n_nodes: faces.each_ref().map(|face| face.normals.len()),
            follows: match is_whole {
                true => usize::from(second),
                false => self.side_with_panes(scene, entry, &faces),
            },
            is_whole,
            gap: gap.fold(
                0.0,
                |most: f64, d| if d.abs() > most.abs() { d } else { most },
            ),
            unresolved: unresolved + GEOMETRY_TOLERANCE * size,
            allowed: faces.each_ref().map(|face| {
                unresolved + (LARGEST_GAP * face.edge()).min(DEEPEST_INTERFERENCE * self.extent())
            }),
            overlaps,
            pairings,
        })
    }

    /// Lets the nodes of a face follow the other faces of its joints, and returns those whose ψ no other one takes.
    fn follow(
        &mut self,
        joints: &[&Joint<'_>],
        taken: &mut BTreeMap<usize, Vec<usize>>,
    ) -> BTreeSet<usize> {
        let overlaps = joints.iter().flat_map(|joint| {
            let own = joint.overlaps[joint.follows].iter();
            own.map(|overlap| (joint.entry, overlap))
        });
        let overlaps: Vec<(usize, &Overlap)> = overlaps.collect();
        let mut rows = dual_rows(self, &overlaps);
        let has_row = |(node, (_, row)): &(&usize, &Row)| {
            let others = row.keys().map(|(_, other)| *other);
            !taken.contains_key(node) && !lead_to(|it| it == **node, others, taken)
        };
        let rowless = rows.iter().filter(|row| !has_row(row));
        let rowless: BTreeSet<usize> = rowless.map(|(node, _)| *node).collect();
        let facets: BTreeSet<usize> = overlaps.iter().map(|it| it.1.triangle.facet).collect();
        let ends = self.middles_of(&facets);
        let lost = pass_on(self, &facets, &ends, &rowless, &mut rows);
        for (node, (_, mut shares)) in rows {
            if rowless.contains(&node) {
                continue;
            }
            if let Some(ends) = ends.get(&node) {
                let parts = parts(&shares);
                shares
                    .values_mut()
                    .for_each(|share| *share *= 1.0 - 2.0 * CORNER_SHARE);
                for (end, (entry, part)) in ends
                    .iter()
                    .flat_map(|end| parts.iter().map(move |it| (end, it)))
                {
                    *shares.entry((*entry, *end)).or_insert(0.0) += part * CORNER_SHARE;
                }
            }
            let shares = whole(shares);
            taken.insert(node, shares.iter().map(|((_, k), _)| *k).collect());
            let of_joints = shares.chunk_by(|a, b| a.0.0 == b.0.0);
            self.glued.extend(of_joints.map(|run| GluedNode {
                node,
                entry: run[0].0.0,
                shares: run.iter().map(|((_, k), share)| (*k, *share)).collect(),
            }));
        }
        lost
    }

    /// Lets nodes of other faces follow the points of those that follow where these lie on what follows something else, or is held.
    fn close_rings(&mut self, joints: &[&Joint<'_>], taken: &mut BTreeMap<usize, Vec<usize>>) {
        let n_before = taken.len();
        for joint in joints {
            for (&node, pairing) in &joint.pairings[1 - joint.follows] {
                let point = on_edge_of(pairing, taken).filter(|_| !taken.contains_key(&node));
                let is_own = |other: usize| self.body_of_node(other) == self.body_of_node(node);
                let is_tied =
                    |it: &BTreeMap<usize, f64>| lead_to(is_own, it.keys().copied(), taken);
                let Some(point) = point.filter(|it| !is_tied(it)) else {
                    continue;
                };
                taken.insert(node, point.keys().copied().collect());
                self.glued.push(GluedNode {
                    node,
                    entry: joint.entry,
                    shares: whole(point),
                });
            }
        }
        if taken.len() > n_before {
            self.close_rings(joints, taken);
        }
    }

    /// Refuses a joint with nodes whose ψ are lost where something opposite is free.
    fn refuse_lost(
        &self,
        scene: &Scene,
        joint: &Joint<'_>,
        lost: &BTreeSet<usize>,
        taken: &BTreeMap<usize, Vec<usize>>,
    ) -> Result<(), InvalidValue> {
        let overlaps = &joint.overlaps[joint.follows];
        let is_free = |facet: &usize| self.facet_nodes(*facet).any(|k| !taken.contains_key(&k));
        let open = overlaps.iter().filter(|it| it.opposite.iter().any(is_free));
        let of_lost = open.flat_map(|it| it.triangle.integrals.iter());
        let of_lost = of_lost
            .filter(|(node, _)| lost.contains(node))
            .map(|it| it.1);
        let whole = overlaps.iter().map(|it| it.triangle.area);
        let share = of_lost.sum::<f64>() / whole.sum::<f64>();
        if share <= LEAST_COVER {
            return Ok(());
        }
        let face = &joint.pair[joint.follows];
        Err(InvalidValue {
            key: format!("{}.between", scene.contact_key(joint.entry)),
            expected: format!("nodes of {face} that are free to follow {}", joint.pair[1 - joint.follows]),
            found: format!("none near {:.0} % of the joint, as clamps hold them or they follow other faces", 100.0 * share),
            help: "name the other face by panes_on, take more cells between the faces of that body, or body.element = \"P2\"".into(),
        })
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
                    let closed = (gap != 0.0).then(|| Warning::ClosedGap {
                        key: key.clone(),
                        is_overlap: gap < 0.0,
                        gap: units.of(Dimension::LENGTH).told(&[gap.abs()]),
                    });
                    narrow.chain(closed).collect::<Vec<_>>()
                });
        warnings.collect()
    }

    /// Refuses nodes that clamps hold where the nodes of the other face around them are held at other values.
    fn refuse_torn(&self, scene: &Scene, joint: &Joint<'_>) -> Result<(), InvalidValue> {
        let pair = joint.pair;
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
        let pairings = joint.pairings[joint.follows].iter();
        let inside = pairings.filter(|(_, it)| it.least >= -ON_EDGE);
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
    fn middles_of(&self, facets: &BTreeSet<usize>) -> BTreeMap<usize, [usize; 2]> {
        let middles = self.mid_edges.iter();
        let facets = middles.flat_map(|middles| facets.iter().map(|&f| (f, middles.facets[f])));
        let edges = facets.flat_map(|(facet, middles)| {
            let ends = TRIANGLE_EDGES.map(|ends| ends.map(|k| self.facets[facet][k]));
            middles.into_iter().zip(ends)
        });
        edges.collect()
    }

    /// Puts glued nodes before those that they follow.
    fn order_glued(&mut self, scene: &Scene) -> Result<(), InvalidValue> {
        self.glued.sort_by_key(|glued| (glued.node, glued.entry));
        let rows: BTreeMap<usize, &[GluedNode]> =
            self.glued_runs().map(|run| (run[0].node, run)).collect();
        // None while the nodes that one follows are looked at, and where they lead back.
        let mut depths: BTreeMap<usize, Option<usize>> = BTreeMap::new();
        let in_circle = |glued: &&GluedNode| depth(&rows, glued.node, &mut depths).is_none();
        let in_circle: BTreeSet<usize> = self
            .glued
            .iter()
            .filter(in_circle)
            .map(|glued| glued.entry)
            .collect();
        if !in_circle.is_empty() {
            let pairs = in_circle.into_iter().map(|entry| scene.contact_key(entry));
            let pairs: Vec<String> = pairs.collect();
            return Err(InvalidValue {
                key: format!("{}.panes_on", pairs[0]),
                expected: "glued faces whose nodes do not follow each other in a circle".into(),
                found: format!("a node that follows itself through {}", pairs.join(", ")),
                help: "leave out panes_on in one of these pairs, or name the other face there"
                    .into(),
            });
        }
        let depth = |glued: &GluedNode| std::cmp::Reverse(depths[&glued.node]);
        self.glued
            .sort_by_key(|glued| (depth(glued), glued.node, glued.entry));
        Ok(())
    }

    /// Moves glued nodes to where their shares say.
    fn close_gaps(
        &mut self,
        scene: &Scene,
        joints: &[Joint<'_>],
        cut_faceting: f64,
    ) -> Result<(), InvalidValue> {
        let allowed = |joint: &Joint<'_>| joint.allowed[joint.follows] + cut_faceting;
        let allowed: BTreeMap<usize, f64> = joints
            .iter()
            .map(|joint| (joint.entry, allowed(joint)))
            .collect();
        // The longest way over what is allowed, the node and its joint.
        let mut worst = (0.0, 0.0, 0, 0);
        let mut is_moved = vec![false; self.coordinates.len()];
        let mut coordinates = std::mem::take(&mut self.coordinates);
        for run in self.glued_runs().rev() {
            let terms = run.iter().flat_map(|glued| &glued.shares);
            let terms = terms.map(|(k, share)| Vector3::from(coordinates[*k]) * *share);
            let (GluedNode { node, entry, .. }, to) = (&run[0], terms.sum::<Vector3<f64>>());
            let way = (to - Vector3::from(coordinates[*node])).norm();
            if way > worst.0 * allowed[entry] {
                worst = (way / allowed[entry], way, *node, *entry);
            }
            // Roundings of places leave those of flat faces as they are.
            if way > ROUNDED_SHARE.sqrt() * allowed[entry] {
                coordinates[*node] = to.into();
                is_moved[*node] = true;
            }
        }
        self.coordinates = coordinates;
        let is_inverted = |corners: &[usize; 4]| {
            corners.iter().any(|node| is_moved[*node])
                && tetrahedron_volume(&self.corners(corners)) <= 0.0
        };
        let (relative, gap, node, entry) = worst;
        if relative <= 1.0 && !self.tetrahedra.iter().any(is_inverted) {
            return Ok(());
        }
        Err(InvalidValue {
            key: format!("{}.between", scene.contact_key(entry)),
            expected: format!(
                "glued faces up to {:.3e} {} apart, a quarter of an edge of their triangles and a tenth of the bodies at most, for nodes are moved by the gap",
                allowed[&entry],
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

/// Whether nodes follow others, which may follow others again, up to some that are looked for.
fn lead_to(
    is_wanted: impl Fn(usize) -> bool,
    from: impl Iterator<Item = usize>,
    taken: &BTreeMap<usize, Vec<usize>>,
) -> bool {
    let mut left: Vec<usize> = from.collect();
    let mut seen = BTreeSet::new();
    while let Some(node) = left.pop() {
        if is_wanted(node) {
            return true;
        }
        if seen.insert(node) {
            left.extend(taken.get(&node).into_iter().flatten());
        }
    }
    false
}

/// How many glued nodes follow one another from a node on; `None` where they follow each other in a circle.
fn depth(
    rows: &BTreeMap<usize, &[GluedNode]>,
    node: usize,
    known: &mut BTreeMap<usize, Option<usize>>,
) -> Option<usize> {
    let Some(run) = rows.get(&node) else {
        return Some(0);
    };
    if let Some(depth) = known.get(&node) {
        return *depth;
    }
    known.insert(node, None);
    let mut deepest = 0;
    for (next, _) in run.iter().flat_map(|glued| &glued.shares) {
        deepest = deepest.max(depth(rows, *next, known)?);
    }
    known.insert(node, Some(deepest + 1));
    Some(deepest + 1)
}

/// The nodes of the edge that a point lies on with its shares of them, where all of them are `taken`.
fn on_edge_of(
    point: &NodePairing,
    taken: &BTreeMap<usize, Vec<usize>>,
) -> Option<BTreeMap<usize, f64>> {
    let near = point.shares.iter().filter(|(_, s)| s.abs() > ON_EDGE);
    let near: BTreeMap<usize, f64> = near.copied().collect();
    (point.least >= -ON_EDGE && near.keys().all(|node| taken.contains_key(node))).then_some(near)
}

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
mod follow;
mod order;

use std::{
    cmp::Ordering,
    collections::{BTreeMap, BTreeSet},
};

use nalgebra::Vector3;
use units::Dimension;

pub(crate) use dual::whole;
use dual::{ROUNDED_SHARE, covered};

use super::{
    DEEPEST_INTERFERENCE, GEOMETRY_TOLERANCE, Mesh,
    opposite::{Face, NodePairing, Overlap},
    tetrahedron_volume,
};
use crate::{
    linalg::UNIT_ROUNDING,
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
    /// What lies opposite the nodes of each face.
    pairings: [BTreeMap<usize, NodePairing>; 2],
    /// The nodes of each face, whether they take part or not.
    n_nodes: [usize; 2],
    /// The face whose nodes follow the other one, at first as the joint alone would have it, and whether only that one is covered wholly.
    follows: usize,
    is_whole: bool,
    /// The distance between the faces in m where it is largest, negative where they overlap; 0 up to what triangles leave of it.
    gap: f64,
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
    /// different values, pairs without nodes that are free to follow near some place.
    pub(super) fn glue(&mut self, scene: &Scene, cut_faceting: f64) -> Result<(), InvalidValue> {
        let held = self.held_nodes(scene);
        let held = (0..held.len()).filter(|node| held[*node] == [true; 3]);
        // What nodes follow whose row is known; nothing where clamps hold them.
        let mut taken: BTreeMap<usize, Vec<usize>> = held.map(|node| (node, Vec::new())).collect();
        let joints = scene.glued_pairs();
        let joints = joints.map(|(entry, pair)| self.joint(scene, entry, pair, cut_faceting));
        let mut joints: Vec<Joint<'_>> = joints.collect::<Result<_, _>>()?;
        order::orient(self, scene, &mut joints, &taken);
        let mut faces: BTreeMap<_, Vec<&Joint<'_>>> = BTreeMap::new();
        let mut bonded: BTreeMap<usize, f64> = BTreeMap::new();
        for joint in &joints {
            self.refuse_torn(scene, joint)?;
            faces.entry(joint.rank()).or_default().push(joint);
            for Overlap { triangle, .. } in joint.overlaps.iter().flatten() {
                *bonded.entry(triangle.facet).or_default() += triangle.area;
            }
        }
        self.close_rings(&joints, &mut taken);
        let followed = faces.into_iter();
        let lost = followed.map(|((_, face), joints)| (face, self.follow(&joints, &mut taken)));
        let lost: BTreeMap<&String, BTreeSet<usize>> = lost.collect();
        self.close_rings(&joints, &mut taken);
        joints.sort_by_key(|joint| joint.entry);
        self.order_glued();
        for joint in &joints {
            self.refuse_lost(scene, joint, &lost[&joint.pair[joint.follows]], &taken)?;
            self.joint_gap.push(joint.gap);
            let cover = joint.overlaps.each_ref().map(|overlaps| {
                let facets = overlaps.iter().map(|it| it.triangle.facet);
                let shares = facets.map(|facet| bonded[&facet] / self.side_integrals(facet).0);
                shares.fold(0.0, f64::max)
            });
            self.joint_cover.push(cover);
        }
        self.close_gaps(scene, &joints)
    }

    /// What each glued node follows in its joints.
    pub(crate) fn glued_runs(&self) -> impl DoubleEndedIterator<Item = &[GluedNode]> {
        self.glued.chunk_by(|a, b| a.node == b.node)
    }

    /// The bodies that move as one, in groups: one body, or several that are glued together.
    #[must_use]
    pub fn glued_bodies(&self) -> Vec<Vec<usize>> {
        let bodies = 0..self.bodies.len().max(1);
        let mut groups: Vec<Vec<usize>> = bodies.map(|body| vec![body]).collect();
        let pairs = self
            .glued
            .iter()
            .flat_map(|glued| glued.shares.iter().map(|(k, _)| [glued.node, *k]));
        for bodies in pairs.map(|pair| pair.map(|node| self.body_of_node(node))) {
            let [a, b] = bodies.map(|body| groups.iter().position(|group| group.contains(&body)));
            if a != b {
                let (low, high) = (a.min(b).unwrap_or(0), a.max(b).unwrap_or(0));
                let joined = groups.remove(high);
                groups[low].extend(joined);
            }
        }
        groups.iter_mut().for_each(|group| group.sort_unstable());
        groups
    }

    /// What the faces of a pair have in common.
    fn joint<'a>(
        &self,
        scene: &Scene,
        entry: usize,
        pair: &'a [String; 2],
        cut_faceting: f64,
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
        let inside = pairings.iter().flat_map(BTreeMap::values);
        let inside = inside.filter(|pairing| pairing.least >= -ON_EDGE);
        let gaps = inside.map(|pairing| pairing.distance);
        let gap = gaps.max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let size = faces.iter().map(Face::radius).fold(0.0, f64::max);
        let unresolved = faces.iter().map(|face| face.unresolved).sum::<f64>() + cut_faceting;
        let told = unresolved + GEOMETRY_TOLERANCE * size;
        let [first, second] = [0, 1].map(|k| {
            let areas = faces[k].facets.iter().map(|&f| self.side_integrals(f).0);
            let common = overlaps[k].iter().map(|it| it.triangle.area);
            common.sum::<f64>() > (1.0 - ROUNDED_COVER) * areas.sum::<f64>()
        });
        let is_whole = first != second && scene.contacts[entry].panes_on.is_none();
        Ok(Joint {
            entry,
            pair,
            n_nodes: faces.each_ref().map(|face| face.normals.len()),
            follows: match is_whole {
                true => usize::from(second),
                false => self.side_with_panes(scene, entry, &faces),
            },
            is_whole,
            gap: gap.filter(|gap| gap.abs() > told).unwrap_or(0.0),
            allowed: faces.each_ref().map(|face| {
                unresolved + (LARGEST_GAP * face.edge()).min(DEEPEST_INTERFERENCE * self.extent())
            }),
            overlaps,
            pairings,
        })
    }

    /// Refuses a joint with nodes whose ψ are lost where something opposite is free.
    fn refuse_lost(
        &self,
        scene: &Scene,
        joint: &Joint<'_>,
        lost: &BTreeSet<usize>,
        taken: &BTreeMap<usize, Vec<usize>>,
    ) -> Result<(), InvalidValue> {
        let is_free = |facet: &usize| self.facet_nodes(*facet).any(|k| !taken.contains_key(&k));
        let overlaps = joint.overlaps[joint.follows].iter();
        let open = overlaps.filter(|it| it.opposite.iter().any(is_free));
        let mut nodes = open.flat_map(|it| self.facet_nodes(it.triangle.facet));
        let Some(node) = nodes.find(|node| lost.contains(node)) else {
            return Ok(());
        };
        let [face, other] = [joint.follows, 1 - joint.follows].map(|k| &joint.pair[k]);
        let place = place_words(self.coordinates[node]);
        Err(InvalidValue {
            key: format!("{}.between", scene.contact_key(joint.entry)),
            expected: format!("nodes of {face} that are free to follow {other}"),
            found: format!("none near {place}, for clamps hold them or they follow other faces"),
            help: "name the other face by panes_on, take more cells between the faces of that body, or body.element = \"P2\"".into(),
        })
    }

    /// What a scene does not show of its joints.
    pub(crate) fn joint_warnings(&self, scene: &Scene) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let joints = self.joint_gap.iter().zip(&self.joint_cover);
        for ((entry, pair), (&gap, cover)) in scene.glued_pairs().zip(joints) {
            let key = format!("{}.between", scene.contact_key(entry));
            let faces = pair.iter().zip(cover);
            for (face, &cover) in faces.filter(|(_, cover)| **cover < OWN_TRIANGLE) {
                let (key, face) = (key.clone(), face.clone());
                warnings.push(Warning::NarrowJoint { key, face, cover });
            }
            let size = scene.units.of(Dimension::LENGTH).told(&[gap.abs()]);
            let gap = match gap.total_cmp(&0.0) {
                Ordering::Equal => continue,
                Ordering::Less => format!("overlap by up to {size}"),
                Ordering::Greater => format!("are up to {size} apart"),
            };
            warnings.push(Warning::ClosedGap { key, gap });
        }
        warnings
    }

    /// Refuses nodes that clamps hold where the nodes of the other face around them are held at other values.
    fn refuse_torn(&self, scene: &Scene, joint: &Joint<'_>) -> Result<(), InvalidValue> {
        for axis in [Component::X, Component::Y, Component::Z] {
            let clamps = scene.clamps.iter().enumerate().rev();
            let clamps = clamps.filter(|(_, clamp)| clamp.components.contains(&axis));
            let held = clamps.flat_map(|(index, clamp)| {
                self.clamped_nodes(clamp).map(move |node| (node, index))
            });
            let held: BTreeMap<usize, usize> = held.collect();
            let inside = joint.pairings[joint.follows].iter();
            for (node, pairing) in inside.filter(|(_, it)| it.least >= -ON_EDGE) {
                let at = self.coordinates[*node];
                let near = pairing.shares.iter().filter(|it| it.1.abs() > ON_EDGE);
                let others: Option<Vec<usize>> = near.map(|(k, _)| held.get(k).copied()).collect();
                let Some((&first, others)) = held.get(node).zip(others) else {
                    continue;
                };
                let value = |clamp: usize| scene.clamps[clamp].value[axis as usize].at(at);
                let differs = |other: &usize| {
                    let size = value(first).abs().max(value(*other).abs());
                    (value(first) - value(*other)).abs() > UNIT_ROUNDING * size
                };
                if let Some(other) = others.iter().find(|other| differs(other)) {
                    let [along, at] = [axis.name().to_owned(), place_words(at)];
                    let (held, pair) = (Written(&value(first)), joint.pair.join(" and "));
                    return Err(InvalidValue {
                        key: format!("clamp.{other}.value"),
                        expected: format!("{held}, which clamp.{first} says of the displacement along {along} at {at} on the other one of the glued faces {pair}"),
                        found: Written(&value(*other)).to_string(),
                        help: "glued faces move as one: give both clamps the same value there, or hold one body alone".into(),
                    });
                }
            }
        }
        Ok(())
    }

    /// Moves glued nodes to where their shares say.
    fn close_gaps(&mut self, scene: &Scene, joints: &[Joint<'_>]) -> Result<(), InvalidValue> {
        let allowed = joints
            .iter()
            .map(|joint| (joint.entry, joint.allowed[joint.follows]));
        let allowed: BTreeMap<usize, f64> = allowed.collect();
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
        let [at, unit] = [
            place_words(self.coordinates[node]),
            scene.units.length().to_string(),
        ];
        let limit = allowed[&entry];
        Err(InvalidValue {
            key: format!("{}.between", scene.contact_key(entry)),
            expected: format!(
                "glued faces up to {limit:.3e} {unit} apart, a quarter of an edge of their triangles and a tenth of the bodies at most, for nodes are moved by the gap"
            ),
            found: format!("a gap of {} at {at}", Written(&gap)),
            help: "move one of the bodies with body.origin, or name the faces that are glued"
                .into(),
        })
    }
}

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
//! Each component of u has rows of its own, for clamps may hold one. No row has a node that clamps hold or that follows something else already,
//! as on a line where joints meet, that would mostly follow its own body through other joints, or that lies beyond what its triangles have in
//! common. These ψ go to the nearest others, for Σ ψ_j = 1 carries constant stress. Where none is near, nodes of the other face follow by them.
//! Of faces that share nodes the one with the fewest left takes them first. Where nodes of the other face on such a line follow nothing in the
//! end, they follow the point of this one there, so that a ring of joints closes. [`follow`] eliminates the rows.
//!
//! The same relations place the nodes, x_j = Σ_k … x_k: then no rigid motion strains the joint, whatever the gap was.

mod dual;
mod follow;

use std::{
    cmp::Ordering,
    collections::{BTreeMap, BTreeSet},
};

use nalgebra::Vector3;
use units::Dimension;

pub(crate) use dual::whole;
use dual::{ROUNDED_SHARE, Row, covered, dual_rows};
use follow::glued;

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
    /// The axes along which it follows.
    pub axes: [bool; 3],
    /// The nodes that it follows, u = Σ share u_k, with shares that sum to 1 over its joints, which come one after the other in a mesh;
    /// those of them that are glued themselves along these axes come later, or have no share in all of its joints together.
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
    /// The face whose nodes follow the other one.
    follows: usize,
    /// The number of its nodes and its middle in m, in the order of which faces take the nodes that they share: thin ones have hardly any others.
    rank: [f64; 4],
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
    /// different values.
    pub(super) fn glue(&mut self, scene: &Scene, cut_faceting: f64) -> Result<(), InvalidValue> {
        let joints = scene.glued_pairs();
        let joints = joints.map(|(entry, pair)| self.joint(scene, entry, pair, cut_faceting));
        let mut joints: Vec<Joint<'_>> = joints.collect::<Result<_, _>>()?;
        let mut bonded: BTreeMap<usize, f64> = BTreeMap::new();
        for joint in &joints {
            self.refuse_torn(scene, joint)?;
            for Overlap { triangle, .. } in joint.overlaps.iter().flatten() {
                *bonded.entry(triangle.facet).or_default() += triangle.area;
            }
        }
        joints.sort_by(|a, b| a.rank.partial_cmp(&b.rank).unwrap_or(Ordering::Equal));
        let faces = joints.chunk_by(|a, b| a.rank == b.rank);
        let faces: Vec<_> = faces.map(|it| (it, dual_rows(self, it))).collect();
        let all = self.held_nodes(scene);
        let mut clamped: BTreeMap<Vec<usize>, [bool; 3]> = BTreeMap::new();
        for axis in 0..3 {
            let on_joints = bonded.keys().flat_map(|facet| self.facet_nodes(*facet));
            let held: BTreeSet<usize> = on_joints.filter(|node| all[*node][axis]).collect();
            clamped.entry(held.into_iter().collect()).or_default()[axis] = true;
        }
        for (held, axes) in clamped {
            let held = held.into_iter().map(|node| (node, (0, Row::new())));
            let mut taken: BTreeMap<usize, (usize, Row)> = held.collect();
            self.close_rings(&joints, &mut taken);
            // Those with the fewest nodes left first.
            let mut left: Vec<_> = faces.iter().collect();
            while let Some(next) = (0..left.len()).min_by_key(|k| {
                let nodes = left[*k].1.keys();
                nodes.filter(|node| !taken.contains_key(node)).count()
            }) {
                let (joints, rows) = left.remove(next);
                self.follow(joints, rows, &mut taken);
            }
            self.close_rings(&joints, &mut taken);
            self.glued.extend(glued(taken, axes));
        }
        joints.sort_by_key(|joint| joint.entry);
        for joint in &joints {
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
        self.glued
            .chunk_by(|a, b| (a.node, a.axes) == (b.node, b.axes))
    }

    /// Triangles of glued faces with those of the other face that lie opposite.
    pub(crate) fn glued_facets(&self, scene: &Scene) -> BTreeMap<usize, BTreeSet<usize>> {
        let mut opposite: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
        for (_, pair) in scene.glued_pairs() {
            let [side, other] = pair.each_ref().map(|name| self.pair_face(scene, name));
            for overlap in covered(&side, &other) {
                let facet = overlap.triangle.facet;
                for other in overlap.opposite {
                    opposite.entry(facet).or_default().insert(other);
                    opposite.entry(other).or_default().insert(facet);
                }
            }
        }
        opposite
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
        let follows = match is_whole {
            true => usize::from(second),
            false => self.side_with_panes(scene, entry, &faces),
        };
        let n_nodes = faces[follows].normals.len() as f64;
        let [x, y, z] = (faces[follows].places().sum::<Vector3<f64>>() / n_nodes).into();
        Ok(Joint {
            entry,
            pair,
            follows,
            rank: [n_nodes, x, y, z],
            gap: gap.filter(|gap| gap.abs() > told).unwrap_or(0.0),
            allowed: faces.each_ref().map(|face| {
                unresolved + (LARGEST_GAP * face.edge()).min(DEEPEST_INTERFERENCE * self.extent())
            }),
            overlaps,
            pairings,
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
                    let [along, at] = [axis.word().to_owned(), place_words(at)];
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
            let GluedNode {
                node, entry, axes, ..
            } = &run[0];
            let terms = run.iter().flat_map(|glued| &glued.shares);
            let terms = terms.map(|(k, share)| Vector3::from(coordinates[*k]) * *share);
            let (sum, from) = (terms.sum::<Vector3<f64>>(), coordinates[*node]);
            let to = [0, 1, 2].map(|c| if axes[c] { sum[c] } else { from[c] });
            let way = (Vector3::from(to) - Vector3::from(from)).norm();
            if way > worst.0 * allowed[entry] {
                worst = (way / allowed[entry], way, *node, *entry);
            }
            // Roundings of places leave those of flat faces as they are.
            if way > ROUNDED_SHARE.sqrt() * allowed[entry] {
                coordinates[*node] = to;
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

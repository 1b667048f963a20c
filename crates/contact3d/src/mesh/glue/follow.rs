//! What each node of glued faces follows in the end, and in which order.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    GluedNode, Joint, ON_EDGE,
    dual::{CORNER_SHARE, Row, dual_rows, parts, pass_on, whole},
};
use crate::{
    mesh::{
        Mesh,
        opposite::{NodePairing, Overlap},
    },
    reference::TRIANGLE_EDGES,
    scene::{InvalidValue, Scene},
};

impl Mesh {
    /// Lets the nodes of a face follow the other faces of its joints, and returns those whose ψ no other one takes.
    pub(super) fn follow(
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
                for (entry, part) in &parts {
                    for end in ends {
                        *shares.entry((*entry, *end)).or_insert(0.0) += part * CORNER_SHARE;
                    }
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
    pub(super) fn close_rings(
        &mut self,
        joints: &[&Joint<'_>],
        taken: &mut BTreeMap<usize, Vec<usize>>,
    ) {
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
    pub(super) fn order_glued(&mut self, scene: &Scene) -> Result<(), InvalidValue> {
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

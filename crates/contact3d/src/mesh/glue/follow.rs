//! What each node of glued faces follows in the end, and in which order.

use std::{
    cmp::Reverse,
    collections::{BTreeMap, BTreeSet},
};

use super::{
    GluedNode, Joint, ON_EDGE,
    dual::{CORNER_SHARE, Row, dual_rows, pass_on, whole},
};
use crate::{
    mesh::{
        Mesh,
        opposite::{NodePairing, Overlap},
    },
    reference::TRIANGLE_EDGES,
};

impl Mesh {
    /// Lets the nodes of a face follow the other faces of its joints, and returns those whose ψ no other one takes, and those that would follow
    /// themselves.
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
        let mut lost = pass_on(self, &facets, &ends, &rowless, &mut rows);
        for (node, (_, mut shares)) in rows {
            if rowless.contains(&node) {
                continue;
            }
            if let Some(ends) = ends.get(&node) {
                let own = 1.0 - 2.0 * CORNER_SHARE;
                shares.values_mut().for_each(|share| *share *= own);
                let entry = shares.keys().next().map_or(0, |(entry, _)| *entry);
                for end in ends {
                    *shares.entry((entry, *end)).or_insert(0.0) += CORNER_SHARE;
                }
            }
            let shares = whole(shares);
            let others: Vec<usize> = shares.iter().map(|((_, k), _)| *k).collect();
            if lead_to(|it| it == node, others.iter().copied(), taken) {
                lost.insert(node);
                continue;
            }
            taken.insert(node, others);
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
        joints: &[Joint<'_>],
        taken: &mut BTreeMap<usize, Vec<usize>>,
    ) {
        let n_before = taken.len();
        for joint in joints {
            for (&node, pairing) in &joint.pairings[1 - joint.follows] {
                let point = on_edge_of(pairing, taken).filter(|_| !taken.contains_key(&node));
                let is_own = |other: usize| self.body_of_node(other) == self.body_of_node(node);
                let Some(point) = point.filter(|it| !lead_to(is_own, it.keys().copied(), taken))
                else {
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
    pub(super) fn order_glued(&mut self) {
        let mut depths: BTreeMap<usize, usize> = self.glued.iter().map(|it| (it.node, 0)).collect();
        let mut is_done = false;
        while !is_done {
            is_done = true;
            for glued in &self.glued {
                let others = glued.shares.iter().filter_map(|(k, _)| depths.get(k));
                let least = others.max().map_or(0, |depth| depth + 1);
                if least > depths[&glued.node] {
                    depths.insert(glued.node, least);
                    is_done = false;
                }
            }
        }
        let place = |it: &GluedNode| (Reverse(depths[&it.node]), it.node, it.entry);
        self.glued.sort_by_key(place);
    }
}

/// Whether nodes follow others, which may follow others again, up to some that are looked for.
pub(super) fn lead_to(
    is_wanted: impl Fn(usize) -> bool,
    from: impl IntoIterator<Item = usize>,
    taken: &BTreeMap<usize, Vec<usize>>,
) -> bool {
    let mut left: Vec<usize> = from.into_iter().collect();
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

/// The nodes of the edge that a point lies on with its shares of them, where all of them are `taken`.
fn on_edge_of(
    point: &NodePairing,
    taken: &BTreeMap<usize, Vec<usize>>,
) -> Option<BTreeMap<usize, f64>> {
    let near = point.shares.iter().filter(|(_, s)| s.abs() > ON_EDGE);
    let near: BTreeMap<usize, f64> = near.copied().collect();
    (point.least >= -ON_EDGE && near.keys().all(|node| taken.contains_key(node))).then_some(near)
}

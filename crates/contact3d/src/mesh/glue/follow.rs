//! What each node of glued faces follows in the end.
//!
//! Rows are eliminated one after the other: what is known already is put in for the nodes of a row, so that none comes to follow itself. The
//! parts of each joint keep their sum of 0, by which forces pass the joints in between.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    GluedNode, Joint, ON_EDGE,
    dual::{ROUNDED_SHARE, Row, whole},
};
use crate::mesh::{Mesh, opposite::NodePairing};

/// The part of a row that its node, and nodes of other bodies, must have for the node to follow.
const LEAST_PART: f64 = 0.5;

/// The size of a row over the part of its node from which on the node is beyond what the row sees: on a triangle that is covered by a quarter.
const EXTRAPOLATED: f64 = 5.0;

/// The part of a row that its node has over the largest one at least where it follows.
const LEAST_PIVOT: f64 = 0.25;

/// The part of a row that is left of one that follows from others.
const ROUNDED_ROW: f64 = 1e-9;

/// How many rings of triangles away ψ are taken before nodes of the other face follow: the corner of a face has two, whose nodes two other
/// faces take.
const NEAR: usize = 2;

impl Mesh {
    /// Lets the nodes of the face with some rows follow, or those of other faces. Rows that are left out go to the nearest ones by ∫ ψ. Nodes are
    /// `taken` by rows with −u of the node in the order of their numbers, or by clamps with an empty one.
    pub(super) fn follow(
        &self,
        joints: &[Joint<'_>],
        rows: &BTreeMap<usize, (f64, Row)>,
        taken: &mut BTreeMap<usize, (usize, Row)>,
    ) {
        let facets = joints.iter().flat_map(|it| &it.overlaps[it.follows]);
        let facets: BTreeSet<usize> = facets.map(|overlap| overlap.triangle.facet).collect();
        // The parts of a row, and the sums of those of other bodies, and of such nodes that follow nothing.
        let parts = |node: usize, row: &Row| {
            let parts = by_nodes(&substituted(row.clone(), taken));
            let others =
                (parts.iter()).filter(|(k, _)| self.body_of_node(**k) != self.body_of_node(node));
            let free = others.clone().filter(|(k, _)| !taken.contains_key(k));
            let [others, free]: [f64; 2] = [others.map(|it| it.1).sum(), free.map(|it| it.1).sum()];
            (parts, others, free)
        };
        let follows = |node: usize, integral: f64, row: &Row| {
            let (parts, others, _) = parts(node, row);
            let own = -parts.get(&node).copied().unwrap_or(0.0);
            let size: f64 = parts.values().map(|part| part.abs()).sum();
            !taken.contains_key(&node)
                && integral > 0.0
                && own.min(others) >= LEAST_PART * integral
                && size <= EXTRAPOLATED * own
        };
        let (mut keepers, mut left) = (BTreeSet::new(), Vec::new());
        for (node, (integral, row)) in rows {
            if follows(*node, *integral, row) {
                keepers.insert(*node);
            } else {
                left.push((*node, parts(*node, row).2 / integral));
            }
        }
        for (node, free) in &left {
            if rows[node].0 > 0.0
                && *free >= LEAST_PART
                && self.nearest(*node, &keepers, &facets, NEAR).is_empty()
            {
                keepers.insert(*node);
            }
        }
        if keepers.is_empty() {
            let most = left.iter().filter(|(node, _)| rows[node].0 > 0.0);
            let most = most.max_by(|a, b| a.1.total_cmp(&b.1));
            keepers.extend(most.map(|(node, _)| *node));
        }
        let mut sums: BTreeMap<usize, Row> = BTreeMap::new();
        for (node, (_, row)) in rows {
            let near = match keepers.contains(node) {
                true => BTreeSet::from([*node]),
                false => self.nearest(*node, &keepers, &facets, usize::MAX),
            };
            let whole: f64 = near.iter().map(|k| rows[k].0).sum();
            for k in near {
                add(sums.entry(k).or_default(), row, rows[&k].0 / whole);
            }
        }
        for (node, row) in sums {
            eliminate(node, row, taken);
        }
    }

    /// Those of some nodes that are nearest to another one on some triangles, over so many rings of these at most.
    fn nearest(
        &self,
        node: usize,
        of: &BTreeSet<usize>,
        facets: &BTreeSet<usize>,
        n_rings: usize,
    ) -> BTreeSet<usize> {
        let mut ring = BTreeSet::from([node]);
        for _ in 0..n_rings {
            let n_before = ring.len();
            let beside = (facets.iter())
                .filter(|&&facet| self.facet_nodes(facet).any(|node| ring.contains(&node)));
            let wider: Vec<usize> = beside.flat_map(|&facet| self.facet_nodes(facet)).collect();
            ring.extend(wider);
            let found: BTreeSet<usize> = ring.intersection(of).copied().collect();
            if !found.is_empty() || ring.len() == n_before {
                return found;
            }
        }
        BTreeSet::new()
    }

    /// Lets nodes of other faces follow the points of those that follow where these lie on what follows something else, or is held.
    pub(super) fn close_rings(
        &self,
        joints: &[Joint<'_>],
        taken: &mut BTreeMap<usize, (usize, Row)>,
    ) {
        let n_before = taken.len();
        for joint in joints {
            for (&node, pairing) in &joint.pairings[1 - joint.follows] {
                let point = on_edge_of(pairing, taken).filter(|_| !taken.contains_key(&node));
                let is_own = |other: usize| self.body_of_node(other) == self.body_of_node(node);
                let Some(point) = point else {
                    continue;
                };
                let row = point
                    .into_iter()
                    .map(|(k, share)| ((k, joint.entry), share));
                let row = substituted(row.chain([((node, joint.entry), -1.0)]).collect(), taken);
                let parts = by_nodes(&row);
                let mut own = parts
                    .iter()
                    .filter(|(k, part)| is_own(**k) && part.abs() > ROUNDED_ROW);
                if own.all(|(k, _)| *k == node) && parts[&node] < -LEAST_PART {
                    eliminate(node, row, taken);
                }
            }
        }
        if taken.len() > n_before {
            self.close_rings(joints, taken);
        }
    }
}

/// What nodes follow in the end, those that follow others net of which first.
pub(super) fn glued(taken: BTreeMap<usize, (usize, Row)>, axes: [bool; 3]) -> Vec<GluedNode> {
    let mut rows: Vec<(usize, (usize, Row))> = taken.into_iter().collect();
    rows.sort_by_key(|(_, (place, _))| *place);
    let glued = rows.into_iter().flat_map(|(node, (_, row))| {
        let others = row.into_iter().filter(|((k, _), _)| *k != node);
        let shares = whole(
            others
                .map(|((k, entry), share)| ((entry, k), share))
                .collect(),
        );
        let of_joints = shares.chunk_by(|a, b| a.0.0 == b.0.0);
        let of_joints = of_joints.map(|run| GluedNode {
            node,
            entry: run[0].0.0,
            axes,
            shares: run.iter().map(|((_, k), share)| (*k, *share)).collect(),
        });
        of_joints.collect::<Vec<_>>()
    });
    glued.collect()
}

/// Adds a multiple of a row to another one.
fn add(to: &mut Row, row: &Row, times: f64) {
    for (key, part) in row {
        *to.entry(*key).or_insert(0.0) += times * part;
    }
}

/// The sums of a row over its joints.
fn by_nodes(row: &Row) -> BTreeMap<usize, f64> {
    let mut parts = BTreeMap::new();
    for ((node, _), part) in row {
        *parts.entry(*node).or_insert(0.0) += part;
    }
    parts
}

/// A row with what follows others put in.
fn substituted(mut row: Row, taken: &BTreeMap<usize, (usize, Row)>) -> Row {
    let place = |node: usize| Some((taken.get(&node)?.0, node));
    let size = row
        .values()
        .fold(0.0, |most: f64, part| most.max(part.abs()));
    let mut left: BTreeSet<(usize, usize)> = row.keys().filter_map(|(k, _)| place(*k)).collect();
    while let Some((before, node)) = left.pop_first() {
        let part: f64 = row
            .range((node, 0)..=(node, usize::MAX))
            .map(|it| it.1)
            .sum();
        if part.abs() <= ROUNDED_SHARE * size {
            continue;
        }
        let (_, known) = &taken[&node];
        add(&mut row, known, part);
        let next = known.keys().filter_map(|(k, _)| place(*k));
        left.extend(next.filter(|it| it.0 > before));
    }
    row
}

/// Lets a node, or another one that has more of it, follow by a row, unless that follows from others or what clamps hold is all that is left.
fn eliminate(node: usize, row: Row, taken: &mut BTreeMap<usize, (usize, Row)>) {
    let size = row
        .values()
        .fold(0.0, |most: f64, part| most.max(part.abs()));
    let mut row = substituted(row, taken);
    let parts = by_nodes(&row)
        .into_iter()
        .filter(|(k, _)| !taken.contains_key(k));
    let parts: BTreeMap<usize, f64> = parts.collect();
    let most = parts.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let Some((&most, &largest)) = most.filter(|it| it.1.abs() > ROUNDED_ROW * size) else {
        return;
    };
    let own = parts.get(&node).copied().unwrap_or(0.0);
    let (follower, part) = match own.abs() >= LEAST_PIVOT * largest.abs() {
        true => (node, own),
        false => (most, largest),
    };
    row.values_mut().for_each(|it| *it /= -part);
    taken.insert(follower, (taken.len(), row));
}

/// The nodes of the edge that a point lies on with its shares of them, where all of them are `taken`.
fn on_edge_of(
    point: &NodePairing,
    taken: &BTreeMap<usize, (usize, Row)>,
) -> Option<BTreeMap<usize, f64>> {
    let near = point.shares.iter().filter(|(_, s)| s.abs() > ON_EDGE);
    let near: BTreeMap<usize, f64> = near.copied().collect();
    (point.least >= -ON_EDGE && near.keys().all(|node| taken.contains_key(node))).then_some(near)
}

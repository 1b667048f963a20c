//! Which one of two glued faces follows the other.
//!
//! Where joints meet at a line, nodes must not follow themselves through them, and each joint needs nodes that no other one takes. Joints
//! choose one after the other, those first that `panes_on` decides, then those that cover one face wholly: each lets follow the face that it
//! would choose alone unless that closes a circle of faces or leaves a joint without nodes, else the other one. If neither can, all choose
//! again without circles of bodies, for there always is an order of these. Names decide between equals, so that the order of `[[contact]]`
//! does not matter.

use std::collections::{BTreeMap, BTreeSet};

use super::Joint;
use crate::{mesh::Mesh, scene::Scene};

impl<'a> Joint<'a> {
    /// The order in which faces take the nodes that they share: thin ones have hardly any others.
    pub(super) fn rank(&self, side: usize) -> (usize, &'a String) {
        (self.n_nodes[side], &self.pair[side])
    }
}

/// Lets each joint choose the face that follows, and returns the order in which they choose. Held nodes are `taken`.
pub(super) fn orient(
    mesh: &Mesh,
    scene: &Scene,
    joints: &mut [Joint<'_>],
    taken: &BTreeMap<usize, Vec<usize>>,
) -> Vec<usize> {
    let class = |joint: &Joint<'_>| match scene.contacts[joint.entry].panes_on {
        Some(_) => 0,
        None => 2 - usize::from(joint.is_whole),
    };
    let wanted: Vec<usize> = joints.iter().map(|joint| joint.follows).collect();
    let mut order: Vec<usize> = (0..joints.len()).collect();
    order.sort_by_key(|&j| {
        let [a, b] = joints[j].pair;
        (class(&joints[j]), a.min(b), a.max(b))
    });
    for by_bodies in [false, true] {
        let mut is_done = true;
        for (place, &j) in order.iter().enumerate() {
            let sides = [wanted[j], 1 - wanted[j]];
            let tries = sides.map(|side| (side, true)).into_iter();
            let mut tries = tries.chain(sides.map(|side| (side, false)));
            let fits = tries.find(|(side, all_have_nodes)| {
                joints[j].follows = *side;
                let chosen = order[..=place].iter().map(|&j| &joints[j]);
                let chosen: Vec<&Joint<'_>> = chosen.collect();
                let has_nodes = |joint: &&Joint<'_>| has_nodes(joint, &chosen, taken);
                class(&joints[j]) == 0
                    || !closes_circle(mesh, &chosen, by_bodies)
                        && (!all_have_nodes || chosen.iter().all(has_nodes))
            });
            is_done &= fits.is_some_and(|(_, all_have_nodes)| all_have_nodes);
            joints[j].follows = fits.map_or(wanted[j], |(side, _)| side);
        }
        if is_done {
            break;
        }
    }
    order
}

/// Whether some nodes of a joint are neither held nor taken by other ones.
fn has_nodes(
    joint: &Joint<'_>,
    joints: &[&Joint<'_>],
    taken: &BTreeMap<usize, Vec<usize>>,
) -> bool {
    let rank = joint.rank(joint.follows);
    let before = joints.iter().filter(|it| it.rank(it.follows) < rank);
    let before: Vec<&BTreeSet<usize>> = before.map(|it| &it.nodes[it.follows]).collect();
    let is_own = |node: &usize| !before.iter().any(|nodes| nodes.contains(node));
    let mut nodes = joint.nodes[joint.follows].iter();
    nodes.any(|node| is_own(node) && !taken.contains_key(node))
}

/// Whether what follows in the last one of some joints follows itself through the others.
fn closes_circle(mesh: &Mesh, joints: &[&Joint<'_>], by_bodies: bool) -> bool {
    let body = |joint: &Joint<'_>, side: usize| {
        let node = joint.nodes[side].first();
        node.map(|node| mesh.body_of_node(*node))
    };
    let place = |joint: &&Joint<'_>| {
        let face = (!by_bodies).then_some(&joint.pair[joint.follows]);
        (body(joint, joint.follows), face.cloned())
    };
    let leads = |from: &Joint<'_>, to: &Joint<'_>| {
        let (own, next) = (from.follows, to.follows);
        let meets = |side: usize| !from.nodes[side].is_disjoint(&to.nodes[next]);
        if by_bodies {
            return body(from, 1 - own) == body(to, next);
        }
        meets(1 - own) || (from.rank(own) > to.rank(next) && meets(own))
    };
    let start = joints.last().map(place);
    let mut left: Vec<_> = start.iter().cloned().collect();
    let mut seen = BTreeSet::new();
    while let Some(at) = left.pop() {
        for from in joints.iter().filter(|joint| place(joint) == at) {
            let next = joints.iter().filter(|to| leads(from, to)).map(place);
            for next in next.filter(|next| *next != at) {
                if Some(&next) == start.as_ref() {
                    return true;
                }
                if seen.insert(next.clone()) {
                    left.push(next);
                }
            }
        }
    }
    false
}

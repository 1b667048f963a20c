//! Which one of two glued faces follows the other.
//!
//! Where joints meet at a line, nodes must not follow themselves through them, and each joint needs nodes of its own. Joints choose one after
//! the other, those first that `panes_on` decides, then those with nodes of their own on one side alone, then those that cover one face
//! wholly: each lets follow the face that it would choose alone unless that closes a circle of faces, else the other one. If neither can,
//! all choose again without circles of bodies, for there always is an order of these. Names decide between equals, so that the order of
//! `[[contact]]` does not matter.

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
    let mut first: BTreeMap<usize, (usize, &String)> = BTreeMap::new();
    for (joint, side) in joints.iter().flat_map(|joint| [(joint, 0), (joint, 1)]) {
        for node in &joint.nodes[side] {
            let rank = first.entry(*node).or_insert(joint.rank(side));
            *rank = joint.rank(side).min(*rank);
        }
    }
    let wishes = joints.iter().map(|joint| {
        let has_own = [0, 1].map(|side| {
            let mut nodes = joint.nodes[side].iter();
            nodes.any(|node| first[node] == joint.rank(side) && !taken.contains_key(node))
        });
        let of_nodes = has_own[0] != has_own[1];
        let class = match scene.contacts[joint.entry].panes_on {
            Some(_) => 0,
            None => 3 - 2 * usize::from(of_nodes) - usize::from(joint.is_whole && !of_nodes),
        };
        let wanted = match class {
            1 => usize::from(has_own[1]),
            _ => joint.follows,
        };
        (class, wanted)
    });
    let wishes: Vec<(usize, usize)> = wishes.collect();
    let mut order: Vec<usize> = (0..joints.len()).collect();
    order.sort_by_key(|&j| {
        let [a, b] = joints[j].pair;
        (wishes[j].0, a.min(b), a.max(b))
    });
    for by_bodies in [false, true] {
        let mut chosen: Vec<usize> = Vec::new();
        let mut is_done = true;
        for &j in &order {
            let (class, wanted) = wishes[j];
            chosen.push(j);
            let fits = [wanted, 1 - wanted].into_iter().find(|side| {
                joints[j].follows = *side;
                let chosen: Vec<&Joint<'_>> = chosen.iter().map(|&j| &joints[j]).collect();
                class == 0 || !closes_circle(mesh, &chosen, by_bodies)
            });
            is_done &= fits.is_some();
            joints[j].follows = fits.unwrap_or(wanted);
        }
        if is_done {
            break;
        }
    }
    order
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

//! Which one of two glued faces follows the other.
//!
//! Where joints meet at a line, nodes must not follow themselves through them, and each joint needs nodes that no other one takes. Joints
//! choose one after the other, those first that `panes_on` decides, then those that cover one face wholly: each lets follow the face that it
//! would choose alone unless that closes a circle of bodies or leaves a joint without nodes, else the other one. Without a circle one of
//! both never closes any. Names decide between equals, so that the order of `[[contact]]` does not matter.

use std::collections::BTreeMap;

use super::{Joint, follow::lead_to};
use crate::{mesh::Mesh, scene::Scene};

impl<'a> Joint<'a> {
    /// The order in which faces take the nodes that they share: thin ones have hardly any others.
    pub(super) fn rank(&self) -> (usize, &'a String) {
        (self.n_nodes[self.follows], &self.pair[self.follows])
    }

    /// Whether some of its nodes are neither held, which are `taken`, nor those of faces that take them before.
    fn has_nodes(&self, joints: &[Self], taken: &BTreeMap<usize, Vec<usize>>) -> bool {
        let before = joints.iter().filter(|it| it.rank() < self.rank());
        let before: Vec<_> = before.map(|it| &it.pairings[it.follows]).collect();
        self.pairings[self.follows].keys().any(|node| {
            !taken.contains_key(node) && !before.iter().any(|nodes| nodes.contains_key(node))
        })
    }
}

/// Puts joints in the order in which they choose, and lets each choose the face that follows. Held nodes are `taken`.
pub(super) fn orient(
    mesh: &Mesh,
    scene: &Scene,
    joints: &mut [Joint<'_>],
    taken: &BTreeMap<usize, Vec<usize>>,
) {
    let is_free = |joint: &Joint<'_>| scene.contacts[joint.entry].panes_on.is_none();
    joints.sort_by_key(|joint| {
        let [a, b] = joint.pair;
        let is_free = is_free(joint);
        (is_free, is_free && !joint.is_whole, a.min(b), a.max(b))
    });
    let mut leaders: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for j in 0..joints.len() {
        let first = |nodes: &BTreeMap<usize, _>| nodes.keys().next().copied();
        let first = joints[j].pairings.each_ref().map(first);
        let bodies = first.map(|node| mesh.body_of_node(node.unwrap_or(0)));
        let alone = joints[j].follows;
        let tries = [true, false].map(|all| [(alone, all), (1 - alone, all)]);
        let fits = tries.into_iter().flatten().find(|&(side, all_have_nodes)| {
            joints[j].follows = side;
            let chosen = &joints[..=j];
            let lacks = |joint: &Joint<'_>| !joint.has_nodes(chosen, taken);
            let has_circle = lead_to(|it| it == bodies[side], [bodies[1 - side]], &leaders);
            !(has_circle || all_have_nodes && chosen.iter().any(lacks))
        });
        let side = fits
            .filter(|_| is_free(&joints[j]))
            .map_or(alone, |it| it.0);
        joints[j].follows = side;
        leaders
            .entry(bodies[side])
            .or_default()
            .push(bodies[1 - side]);
    }
}

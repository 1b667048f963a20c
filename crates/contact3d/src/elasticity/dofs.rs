//! Free unknowns and prescribed ones.

use std::{collections::BTreeMap, sync::Arc};

use super::{
    Element, MaterialField,
    tools::{ToolPoint, held_rows, prescribed_rows, require_agreement, tied_nodes},
};
use crate::{
    linalg::{UNIT_ROUNDING, norm},
    mesh::{Mesh, whole},
    scene::{Component, InvalidValue, Scene, UNDEFINED, Written, place_words},
};

/// Numbering of the free degrees of freedom: node by node, x before y before z, held ones left out; with the
/// displacements at which these are held. Two rows for each tool follow the nodes ([`super::ToolPlace`]).
#[derive(Debug, Clone, PartialEq)]
pub struct DofMap {
    /// Degree of freedom of each row and component, `[n_rows, 3]`; `None` where held.
    pub dof: Vec<[Option<usize>; 3]>,
    /// Number of rows that are nodes of the mesh.
    pub n_nodes: usize,
    /// Number of free degrees of freedom.
    pub n_free: usize,
    /// Nodes of faces that are bonded to tools, which have no degrees of freedom of their own.
    pub tied: Arc<BTreeMap<usize, ToolPoint>>,
    /// Nodes that follow those of a face that theirs is glued to, with the shares of these in each component, none of which is glued itself; a
    /// component that clamps hold follows nothing.
    pub glued: BTreeMap<usize, Vec<(usize, [f64; 3])>>,
    /// u_c in m, `[n_rows, 3]`, zero where free; `None` where all clamps and tools hold at zero.
    pub prescribed: Option<Arc<Vec<[f64; 3]>>>,
}

impl DofMap {
    /// Eliminates the held components of each node, `[n_nodes, 3]`, which are held at zero.
    #[must_use]
    pub fn new(held: &[[bool; 3]]) -> Self {
        Self::with_rows(held.iter().copied(), held.len())
    }

    /// The same for the nodes and the tools of a scene.
    #[must_use]
    pub fn of_scene(scene: &Scene, mesh: &Mesh) -> Self {
        let mut nodes = mesh.held_nodes(scene);
        let n_nodes = nodes.len();
        let glued = glued_nodes(mesh, &nodes);
        for (node, (_, shares)) in glued
            .iter()
            .flat_map(|(node, all)| all.iter().map(move |it| (*node, it)))
        {
            (0..3).for_each(|c| nodes[node][c] |= shares[c] != 0.0);
        }
        Self {
            tied: Arc::new(tied_nodes(scene, mesh)),
            glued,
            ..Self::with_rows(nodes.into_iter().chain(held_rows(scene)), n_nodes)
        }
    }

    /// Gives a map that was read from a file what its nodes follow on the mesh of the scene.
    pub fn glue(&mut self, scene: &Scene, mesh: &Mesh) {
        self.glued = glued_nodes(mesh, &mesh.held_nodes(scene));
    }

    /// The same with degrees of freedom of their own for what follows other nodes, but not for what follows tools.
    pub(super) fn unglued(&self) -> Self {
        let held = self.dof.iter().enumerate().map(|(node, dofs)| {
            std::array::from_fn(|c| dofs[c].is_none() && !self.is_glued(node, c))
        });
        Self {
            tied: self.tied.clone(),
            ..Self::with_rows(held, self.n_nodes)
        }
    }

    fn with_rows(held: impl Iterator<Item = [bool; 3]>, n_nodes: usize) -> Self {
        let mut n_free = 0;
        let mut number = |is_held: bool| {
            (!is_held).then(|| {
                n_free += 1;
                n_free - 1
            })
        };
        let dof = held.map(|row| row.map(&mut number)).collect();
        Self {
            dof,
            n_nodes,
            n_free,
            tied: Arc::default(),
            glued: BTreeMap::new(),
            prescribed: None,
        }
    }

    /// The displacement of a node in m: free components from their degrees of freedom, the others as they are held.
    #[must_use]
    pub fn at_node(&self, node: usize, free: &[f64]) -> [f64; 3] {
        self.moved(node, free, &|held| self.held_at(held))
    }

    /// The same with held components at `held_at`.
    fn moved(&self, node: usize, free: &[f64], held_at: &impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
        let unglued = |node: usize| {
            if let Some(point) = self.tied.get(&node) {
                return point.moved(|row| self.moved(self.n_nodes + row, free, held_at));
            }
            let held = held_at(node);
            [0, 1, 2].map(|c| match self.dof[node][c] {
                Some(dof) => free[dof],
                None if self.is_glued(node, c) => 0.0,
                None => held[c],
            })
        };
        let follows = self.glued.get(&node).into_iter().flatten();
        follows.fold(unglued(node), |mut sum, (other, shares)| {
            add_share(&mut sum, shares, unglued(*other));
            sum
        })
    }

    /// Whether a component of a node follows other nodes.
    #[must_use]
    pub fn is_glued(&self, node: usize, component: usize) -> bool {
        let mut follows = self.glued.get(&node).into_iter().flatten();
        follows.any(|(_, shares)| shares[component] != 0.0)
    }

    /// The displacement u_c in m at which a node is held; zero for its free components.
    #[must_use]
    pub fn held_at(&self, node: usize) -> [f64; 3] {
        let prescribed = self.prescribed.as_ref();
        prescribed.map_or([0.0; 3], |held| held[node])
    }

    /// The change of a node's displacement in m with changes of the free degrees of freedom: zero where held.
    #[must_use]
    pub fn change_at_node(&self, node: usize, free: &[f64]) -> [f64; 3] {
        self.moved(node, free, &|_| [0.0; 3])
    }

    /// The derivatives of a node's displacement along a direction by the free degrees of freedom.
    pub(crate) fn terms(
        &self,
        node: usize,
        direction: [f64; 3],
    ) -> impl Iterator<Item = (usize, f64)> {
        let follows = self.glued.get(&node).into_iter().flatten();
        let followed = follows.flat_map(move |(other, shares)| {
            self.unglued_terms(*other, [0, 1, 2].map(|c| shares[c] * direction[c]))
        });
        self.unglued_terms(node, direction).chain(followed)
    }

    /// The same of what follows no other node.
    fn unglued_terms(
        &self,
        node: usize,
        direction: [f64; 3],
    ) -> impl Iterator<Item = (usize, f64)> {
        let own = self.dof[node].into_iter().zip(direction);
        let tied = self
            .tied
            .get(&node)
            .map(|point| self.tool_terms(*point, direction));
        let own = own.filter_map(|(dof, part)| Some((dof?, part)).filter(|(_, part)| *part != 0.0));
        own.chain(tied.into_iter().flatten())
    }

    /// The same of a point that moves with a tool.
    pub(crate) fn tool_terms(
        &self,
        point: ToolPoint,
        direction: [f64; 3],
    ) -> impl Iterator<Item = (usize, f64)> + use<> {
        let row = self.n_nodes + 2 * point.tool;
        let dofs = [self.dof[row], self.dof[row + 1]];
        let parts = point.on_rows(direction);
        let terms = [0, 1].map(|k| dofs[k].into_iter().zip(parts[k]));
        let terms = terms.into_iter().flatten();
        terms.filter_map(|(dof, part)| Some((dof?, part)).filter(|(_, part)| *part != 0.0))
    }

    /// Forces on the free degrees of freedom in N from those on the nodes, `[n_nodes]`, and on the rows of tools; none are none.
    #[must_use]
    pub fn forces(&self, nodal: &[[f64; 3]], tools: &[[f64; 3]]) -> Vec<f64> {
        let mut rows = nodal.to_vec();
        for (node, follows) in &self.glued {
            for (other, shares) in follows {
                add_share(&mut rows[*other], shares, nodal[*node]);
            }
        }
        if !(self.tied.is_empty() && tools.is_empty()) {
            rows.resize(self.n_nodes, [0.0; 3]);
            rows.extend(tools);
            rows.resize(self.dof.len(), [0.0; 3]);
        }
        for (node, point) in &*self.tied {
            for (k, force) in point.on_rows(rows[*node]).into_iter().enumerate() {
                let sum = &mut rows[self.n_nodes + 2 * point.tool + k];
                *sum = std::array::from_fn(|c| sum[c] + force[c]);
            }
        }
        self.to_free(&rows)
    }

    /// The displacement of all nodes in m, `[n_nodes]`, from the free degrees of freedom.
    #[must_use]
    pub fn to_nodes(&self, free: &[f64]) -> Vec<[f64; 3]> {
        let nodes = 0..self.n_nodes;
        nodes.map(|node| self.at_node(node, free)).collect()
    }

    /// The rows of the tools in m, from the free degrees of freedom.
    #[must_use]
    pub fn tool_rows(&self, free: &[f64]) -> Vec<[f64; 3]> {
        let rows = self.n_nodes..self.dof.len();
        rows.map(|row| self.at_node(row, free)).collect()
    }

    /// Whether a free degree of freedom is one of a tool, which come last.
    #[must_use]
    pub(crate) fn is_of_tool(&self, dof: usize) -> bool {
        let rows = &self.dof[self.n_nodes..];
        let mut dofs = rows.as_flattened().iter().flatten();
        dofs.next().is_some_and(|first| dof >= *first)
    }

    /// Gathers the free degrees of freedom of displacements of the nodes, and of the rows of tools where they are given.
    #[must_use]
    pub fn to_free(&self, nodal: &[[f64; 3]]) -> Vec<f64> {
        let mut free = vec![0.0; self.n_free];
        for (dofs, values) in self.dof.iter().zip(nodal) {
            for (dof, value) in dofs.iter().zip(values) {
                if let Some(d) = *dof {
                    free[d] = *value;
                }
            }
        }
        free
    }

    /// max |u_a| Σ |f_a| over the nodes and tools, in J for a motion in m and forces in N of the free degrees of freedom, by which the
    /// rounding of u·f is measured: where a body or tool rests in a motion of others, its own part of it is rounding of theirs.
    pub(crate) fn largest_work(&self, motion: &[f64], forces: &[f64]) -> f64 {
        let rows = 0..self.dof.len();
        let sizes = |values| {
            rows.clone()
                .map(move |row| norm(&self.change_at_node(row, values)))
        };
        sizes(motion).fold(0.0, f64::max) * sizes(forces).sum::<f64>()
    }
}

/// Adds a share of each component.
fn add_share(sum: &mut [f64; 3], shares: &[f64; 3], of: [f64; 3]) {
    (0..3).for_each(|c| sum[c] += shares[c] * of[c]);
}

/// What the components of glued nodes that are not held follow, none of it glued itself.
fn glued_nodes(mesh: &Mesh, held: &[[bool; 3]]) -> BTreeMap<usize, Vec<(usize, [f64; 3])>> {
    let mut all: BTreeMap<usize, BTreeMap<usize, [f64; 3]>> = BTreeMap::new();
    for c in 0..3 {
        let runs = || {
            mesh.glued_runs()
                .filter(|run| run[0].axes[c] && !held[run[0].node][c])
        };
        let mut known: BTreeMap<usize, Option<Vec<(usize, f64)>>> =
            runs().map(|run| (run[0].node, None)).collect();
        for run in runs().rev() {
            let mut sums = BTreeMap::new();
            for (node, share) in run.iter().flat_map(|glued| &glued.shares) {
                // The shares of those that come before are net of nothing.
                let own = (!known.contains_key(node)).then_some((*node, 1.0));
                let further = known.get(node).into_iter().flatten().flatten().copied();
                for (other, part) in further.chain(own) {
                    *sums.entry(other).or_insert(0.0) += share * part;
                }
            }
            known.insert(run[0].node, Some(whole(sums)));
        }
        for (node, follows) in known {
            for (other, share) in follows.into_iter().flatten() {
                all.entry(node).or_default().entry(other).or_default()[c] = share;
            }
        }
    }
    let all = all.into_iter();
    all.map(|(node, follows)| (node, follows.into_iter().collect()))
        .collect()
}

/// The displacement u_c in m at which the clamps hold each node, and the tools their rows, `[n_rows, 3]`, zero for free components;
/// `None` where all hold at zero.
///
/// # Errors
/// A formula that is not finite, two clamps that hold one component of a node at different values.
pub fn prescribed_displacements(
    scene: &Scene,
    mesh: &Mesh,
) -> Result<Option<Vec<[f64; 3]>>, InvalidValue> {
    let moves = scene.clamps.iter().any(|clamp| clamp.is_moved());
    let is_moved = moves || scene.tools.iter().any(|tool| tool.is_moved());
    if !is_moved && scene.tools.iter().all(|tool| tool.face.is_none()) {
        return Ok(None);
    }
    // The place of the clamp in the scene, and u_c in m.
    let mut found: Vec<[Option<(usize, f64)>; 3]> = vec![[None; 3]; mesh.coordinates.len()];
    let mut conflicts = Vec::new();
    for (index, clamp) in scene.clamps.iter().enumerate() {
        for node in mesh.clamped_nodes(clamp) {
            let at = mesh.coordinates[node];
            for &component in &clamp.components {
                let value = clamp.value[component as usize].at(at);
                if !value.is_finite() {
                    return Err(InvalidValue {
                        key: format!("clamp.{index}.value"),
                        expected: "a formula that is finite at every held node".into(),
                        found: format!("{} at {}", Written(&value), place_words(at)),
                        help: UNDEFINED.into(),
                    });
                }
                let held = (index, value);
                match found[node][component as usize].get_or_insert(held) {
                    first if first.1 == value => {}
                    first => conflicts.push((node, component, [*first, held])),
                }
            }
        }
    }
    let values: Vec<[f64; 3]> = found
        .iter()
        .map(|node| node.map(|held| held.map_or(0.0, |(_, value)| value)))
        .collect();
    let largest = values.as_flattened().iter();
    let largest = largest.fold(0.0, |most: f64, v| most.max(v.abs()));
    let contradicts = |[(_, first), (_, second)]: &[(usize, f64); 2]| {
        (first - second).abs() > UNIT_ROUNDING * largest.max(second.abs())
    };
    match conflicts.iter().find(|(_, _, held)| contradicts(held)) {
        None => {
            let tools = prescribed_rows(scene, mesh)?;
            let mut values = values;
            for (node, point) in tied_nodes(scene, mesh) {
                values[node] = point.moved(|row| tools[row]);
            }
            for (node, follows) in glued_nodes(mesh, &mesh.held_nodes(scene)) {
                // What is held has a value, and no shares.
                for (other, shares) in follows {
                    let there = values[other];
                    add_share(&mut values[node], &shares, there);
                }
            }
            require_agreement(scene, mesh, &found, &values)?;
            Ok(is_moved.then(|| [values, tools].concat()))
        }
        Some(&(node, component, held)) => {
            Err(contradiction(mesh.coordinates[node], component, held))
        }
    }
}

/// The nodal forces ∫ σ(u_c) : ε(φ) in N, `[n_nodes]`, that hold the body where its held nodes are displaced by u_c in m
/// and no other node moves; over the free degrees of freedom this is A_fc u_c.
#[must_use]
pub fn forces_of_prescribed(
    mesh: &Mesh,
    material: &MaterialField<'_>,
    prescribed: &[[f64; 3]],
) -> Vec<[f64; 3]> {
    let mut forces = vec![[0.0; 3]; mesh.coordinates.len()];
    for t in 0..mesh.tetrahedra.len() {
        let local: Vec<[f64; 3]> = mesh.tetrahedron_nodes(t).map(|n| prescribed[n]).collect();
        if local.iter().all(|u| *u == [0.0; 3]) {
            continue;
        }
        let own = Element::of(mesh, t).internal_forces(material.tensor(t), &local);
        for (node, force) in mesh.tetrahedron_nodes(t).zip(own) {
            for c in 0..3 {
                forces[node][c] += force[c];
            }
        }
    }
    forces
}

fn contradiction(at: [f64; 3], component: Component, held: [(usize, f64); 2]) -> InvalidValue {
    let [(clamp, first), (other, second)] = held;
    InvalidValue {
        key: format!("clamp.{}.value", other),
        expected: format!(
            "{}, the displacement along {} of the node at {} in clamp.{}",
            Written(&first),
            component.word(),
            place_words(at),
            clamp
        ),
        found: Written(&second).to_string(),
        help: "a node that two clamps hold has one displacement: give both the same value there, or leave the axis out of the components of one".into(),
    }
}

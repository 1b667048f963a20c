//! Assembly of A on the graph of nodes.

use nalgebra::{Matrix3, Matrix6};
use rayon::prelude::*;

use super::{
    DofMap, Element, MaterialField, SpringMatrix, dofs::forces_of_prescribed, element::CENTROID,
};
use crate::{linalg::CscMatrix, mesh::Mesh};

/// The stiffness matrix A over the free degrees of freedom, `[n_free, n_free]`, in N/m.
///
/// Each node gathers the blocks V G_aᵀ C G_b of its own tetrahedra in their order, so the result
/// has the same bits at any thread count; a block and its mirror image are the same numbers, so A
/// is symmetric to the last bit.
#[must_use]
pub fn stiffness(mesh: &Mesh, material: &MaterialField<'_>, dofs: &DofMap) -> CscMatrix {
    stiffness_on(&NodeGraph::new(mesh), mesh, material, None, dofs)
}

/// [`stiffness`] with the graph of the mesh, and with springs.
pub(crate) fn stiffness_on(
    graph: &NodeGraph,
    mesh: &Mesh,
    material: &MaterialField<'_>,
    springs: Option<&SpringMatrix>,
    dofs: &DofMap,
) -> CscMatrix {
    let of_nodes = if dofs.glued.is_empty() {
        stiffness_of_nodes(graph, mesh, material, springs, dofs)
    } else {
        let unglued = dofs.unglued();
        let apart = stiffness_of_nodes(graph, mesh, material, springs, &unglued);
        congruent(&apart, &followed_dofs(&unglued, dofs), dofs.n_free)
    };
    match dofs.tied.is_empty() {
        true => of_nodes,
        false => with_tied(&of_nodes, mesh, material, springs, dofs),
    }
}

/// T by rows: the free degrees of freedom that each one of the bodies apart follows, with its shares.
fn followed_dofs(apart: &DofMap, glued: &DofMap) -> Vec<Vec<(usize, f64)>> {
    let mut rows = vec![Vec::new(); apart.n_free];
    for (node, dofs) in apart.dof.iter().enumerate() {
        for (c, dof) in dofs.iter().enumerate() {
            let Some(dof) = *dof else { continue };
            let own = glued.dof[node][c].map(|own| (own, 1.0));
            let follows = glued.glued.get(&node).into_iter().flatten();
            let follows = follows.filter(|(_, shares)| shares[c] != 0.0);
            let free = follows.filter_map(|(other, of)| Some((glued.dof[*other][c]?, of[c])));
            rows[dof] = own.into_iter().chain(free).collect();
        }
    }
    rows
}

/// TᵀAT of a symmetric A and T by rows, `[n_free]` columns, symmetric to the last bit.
fn congruent(a: &CscMatrix, rows: &[Vec<(usize, f64)>], n_free: usize) -> CscMatrix {
    let mut columns = vec![Vec::new(); n_free];
    for (row, shares) in rows.iter().enumerate() {
        shares
            .iter()
            .for_each(|(column, share)| columns[*column].push((row, *share)));
    }
    // Rows from the diagonal on; those above it are the same numbers.
    let lower = columns.par_iter().enumerate().map(|(column, of_column)| {
        let mut terms = Vec::new();
        for (at, share) in of_column {
            for (row, value) in a.entries(*at) {
                let below = rows[row].iter().filter(|(free, _)| *free >= column);
                terms.extend(below.map(|(free, of_row)| (*free, share * of_row * value)));
            }
        }
        terms.sort_by_key(|(free, _)| *free);
        let sums = terms.chunk_by(|a, b| a.0 == b.0);
        let sums = sums.map(|terms| (terms[0].0, terms.iter().map(|(_, value)| value).sum()));
        sums.collect::<Vec<(usize, f64)>>()
    });
    let lower: Vec<Vec<(usize, f64)>> = lower.collect();
    let mut all: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n_free];
    for (column, entries) in lower.into_iter().enumerate() {
        for (row, value) in entries {
            all[column].push((row, value));
            if row != column {
                all[row].push((column, value));
            }
        }
    }
    CscMatrix::of_columns(n_free, all)
}

/// [`stiffness_on`] of nodes that follow no others.
fn stiffness_of_nodes(
    graph: &NodeGraph,
    mesh: &Mesh,
    material: &MaterialField<'_>,
    springs: Option<&SpringMatrix>,
    dofs: &DofMap,
) -> CscMatrix {
    let elements: Vec<Element> = (0..mesh.tetrahedra.len())
        .into_par_iter()
        .map(|t| Element::of(mesh, t))
        .collect();
    let free_at = |&node: &usize| dofs.dof[node].iter().flatten().count();
    let mut indptr = vec![0];
    for node in 0..mesh.coordinates.len() {
        let rows: usize = graph.neighbours(node).iter().map(free_at).sum();
        for _ in dofs.dof[node].iter().flatten() {
            indptr.push(indptr[indptr.len() - 1] + rows);
        }
    }
    let of_nodes = indptr.len() - 1;
    let entries = indptr[of_nodes];
    let (mut indices, mut data) = (vec![0; entries], vec![0.0; entries]);
    let columns = Columns {
        mesh,
        graph,
        elements: &elements,
        material,
        springs,
        dofs,
    };
    let nodes: Vec<usize> = (0..mesh.coordinates.len()).collect();
    let (mut rest, mut column) = ((&mut indices[..], &mut data[..]), 0);
    let chunks: Vec<_> = nodes
        .chunks(NODES_AT_ONCE)
        .map(|nodes| {
            let free: usize = nodes.iter().map(free_at).sum();
            let count = indptr[column + free] - indptr[column];
            column += free;
            let own_indices = rest.0.split_off_mut(..count).expect("counted before");
            let own_data = rest.1.split_off_mut(..count).expect("counted before");
            (nodes, own_indices, own_data)
        })
        .collect();
    chunks
        .into_par_iter()
        .for_each(|(nodes, indices, data)| columns.gather(nodes, indices, data));
    // Tools have no stiffness, but a place on the diagonal for the springs of their pins.
    for dof in of_nodes..dofs.n_free {
        indices.push(dof);
        data.push(0.0);
        indptr.push(indices.len());
    }
    CscMatrix {
        rows: dofs.n_free,
        cols: dofs.n_free,
        indptr,
        indices,
        data,
    }
}

/// A with what the motions of tools do to the faces that are bonded to them: their columns are the forces of motions by one.
fn with_tied(
    of_nodes: &CscMatrix,
    mesh: &Mesh,
    material: &MaterialField<'_>,
    springs: Option<&SpringMatrix>,
    dofs: &DofMap,
) -> CscMatrix {
    let n = dofs.n_free;
    let columns: Vec<(usize, Vec<f64>)> = (0..n)
        .filter(|dof| dofs.is_of_tool(*dof))
        .map(|dof| {
            let mut unit = vec![0.0; n];
            unit[dof] = 1.0;
            let mut moved = vec![[0.0; 3]; mesh.coordinates.len()];
            for &node in dofs.tied.keys().chain(dofs.glued.keys()) {
                moved[node] = dofs.change_at_node(node, &unit);
            }
            let mut forces = forces_of_prescribed(mesh, material, &moved);
            for own in springs
                .map(|springs| springs.forces(&moved))
                .iter()
                .flatten()
                .zip(&mut forces)
            {
                *own.1 = std::array::from_fn(|c| own.1[c] + own.0[c]);
            }
            (dof, dofs.forces(&forces, &[]))
        })
        .collect();
    let first = columns.first().map_or(n, |(dof, _)| *dof);
    let mut matrix = CscMatrix::empty(n);
    for column in 0..first {
        let own = of_nodes.entries(column);
        let of_tools = columns.iter().map(|(dof, forces)| (*dof, forces[column]));
        matrix.push_column(own.chain(of_tools.filter(|(_, value)| *value != 0.0)));
    }
    for (k, (dof, forces)) in columns.iter().enumerate() {
        let own = forces[..first].iter().copied().enumerate();
        // Both halves of the rows of tools are the same numbers.
        let of_tools = columns.iter().enumerate().map(|(l, (row, _))| {
            let (low, high) = (k.min(l), k.max(l));
            (*row, columns[high].1[columns[low].0])
        });
        let is_stored = |(row, value): &(usize, f64)| *value != 0.0 || row == dof;
        matrix.push_column(own.chain(of_tools).filter(is_stored));
    }
    matrix
}

/// What the columns of A are made from.
struct Columns<'a> {
    mesh: &'a Mesh,
    graph: &'a NodeGraph,
    elements: &'a [Element],
    material: &'a MaterialField<'a>,
    springs: Option<&'a SpringMatrix>,
    dofs: &'a DofMap,
}

impl Columns<'_> {
    /// Fills the columns that belong to the free components of some nodes, one after another.
    fn gather(&self, nodes: &[usize], indices: &mut [usize], data: &mut [f64]) {
        let dof = &self.dofs.dof;
        let mut entries = indices.iter_mut().zip(data);
        let mut blocks = Vec::new();
        for &node in nodes {
            self.gather_blocks(node, &mut blocks);
            for component in (0..3).filter(|&component| dof[node][component].is_some()) {
                for (&other, block) in self.graph.neighbours(node).iter().zip(&blocks) {
                    for (row, index) in dof[other].iter().enumerate() {
                        let Some(index) = index else { continue };
                        let (to_index, to_value) = entries.next().expect("counted before");
                        (*to_index, *to_value) = (*index, block[(row, component)]);
                    }
                }
            }
        }
    }

    /// The blocks that couple a node to each of its neighbours.
    fn gather_blocks(&self, node: usize, blocks: &mut Vec<Matrix3<f64>>) {
        let neighbours = self.graph.neighbours(node);
        blocks.clear();
        blocks.resize(neighbours.len(), Matrix3::zeros());
        for &(t, place) in self.graph.corners(node) {
            let tensor = self.material.tensor(t);
            for (a, other) in self.mesh.tetrahedron_nodes(t).enumerate() {
                let at = neighbours.partition_point(|&n| n < other);
                let order = other.cmp(&node);
                blocks[at] += symmetric_block(&self.elements[t], tensor, a, place, order);
            }
        }
        for (other, block) in self.springs.iter().flat_map(|springs| springs.row(node)) {
            blocks[neighbours.partition_point(|n| n < other)] += block;
        }
    }
}

/// Block (a, b), computed from the same operands as its mirror image (b, a).
fn symmetric_block(
    element: &Element,
    elasticity: &Matrix6<f64>,
    a: usize,
    b: usize,
    order: std::cmp::Ordering,
) -> Matrix3<f64> {
    match order {
        std::cmp::Ordering::Less => element.stiffness_block(elasticity, a, b),
        std::cmp::Ordering::Greater => element.stiffness_block(elasticity, b, a).transpose(),
        std::cmp::Ordering::Equal => {
            let block = element.stiffness_block(elasticity, a, a);
            Matrix3::from_fn(|i, j| block[(i.max(j), i.min(j))])
        }
    }
}

/// What a displacement does to the body.
#[derive(Debug, Clone, PartialEq)]
pub struct InternalForces {
    /// Nodal forces ∫ Gᵀσ(u) in N, `[n_nodes]`; at held nodes they are reactions plus applied loads.
    pub forces: Vec<[f64; 3]>,
    /// Voigt stress at the centroid of every tetrahedron in Pa, `[n_tetrahedra]`.
    pub stress: Vec<[f64; 6]>,
    /// Voigt stress at the four corners of every quadratic tetrahedron in Pa, `[n_tetrahedra]`;
    /// empty where stress is constant on tetrahedra.
    pub corner_stress: Vec<[[f64; 6]; 4]>,
}

impl InternalForces {
    /// Evaluates a nodal displacement in m, `[n_nodes]`.
    #[must_use]
    pub fn of(mesh: &Mesh, material: &MaterialField<'_>, displacement: &[[f64; 3]]) -> Self {
        let n_tetrahedra = mesh.tetrahedra.len();
        let mut found = Self {
            forces: vec![[0.0; 3]; mesh.coordinates.len()],
            stress: Vec::with_capacity(n_tetrahedra),
            corner_stress: Vec::new(),
        };
        let of_element = |t: usize| {
            let element = Element::of(mesh, t);
            let tensor = material.tensor(t);
            let local: Vec<[f64; 3]> = mesh.tetrahedron_nodes(t).map(|n| displacement[n]).collect();
            let corners = mesh.mid_edges.is_some().then(|| {
                let at = |k| std::array::from_fn(|j| f64::from(u8::from(j == k)));
                std::array::from_fn(|k| element.stress(tensor, &local, &at(k)).into())
            });
            let forces = element.internal_forces(tensor, &local);
            let centroid: [f64; 6] = element.stress(tensor, &local, &CENTROID).into();
            (forces, centroid, corners)
        };
        // Threads share the elements, and one adds their forces in order, so that bits do not depend on the threads.
        for start in (0..n_tetrahedra).step_by(ELEMENTS_AT_ONCE) {
            let block = start..n_tetrahedra.min(start + ELEMENTS_AT_ONCE);
            let elements: Vec<_> = block.clone().into_par_iter().map(of_element).collect();
            for (t, (forces, centroid, corners)) in block.zip(elements) {
                for (node, force) in mesh.tetrahedron_nodes(t).zip(forces) {
                    for component in 0..3 {
                        found.forces[node][component] += force[component];
                    }
                }
                found.stress.push(centroid);
                found.corner_stress.extend(corners);
            }
        }
        found
    }
}

/// Nodes that one thread treats.
const NODES_AT_ONCE: usize = 512;

/// Elements that threads share before their forces are added.
const ELEMENTS_AT_ONCE: usize = 1 << 14;

/// The graph of a mesh: nodes are neighbours that share a tetrahedron, and each is its own.
#[derive(Debug)]
pub(crate) struct NodeGraph {
    offsets: Vec<usize>,
    neighbours: Vec<usize>,
    corner_offsets: Vec<usize>,
    /// A tetrahedron of the node, and the place of the node there.
    corners: Vec<(usize, usize)>,
}

impl NodeGraph {
    /// The graph of the nodes of a mesh.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let (corner_offsets, corners) = corners(mesh);
        let nodes: Vec<usize> = (0..mesh.coordinates.len()).collect();
        let chunks: Vec<(Vec<usize>, Vec<usize>)> = nodes
            .par_chunks(NODES_AT_ONCE)
            .map(|nodes| {
                let (mut counts, mut neighbours) = (Vec::new(), Vec::new());
                let mut found = Vec::new();
                for &node in nodes {
                    let around = &corners[corner_offsets[node]..corner_offsets[node + 1]];
                    found.clear();
                    let nodes = |(t, _): &(usize, usize)| mesh.tetrahedron_nodes(*t);
                    found.extend(around.iter().flat_map(nodes));
                    found.sort_unstable();
                    found.dedup();
                    counts.push(found.len());
                    neighbours.extend_from_slice(&found);
                }
                (counts, neighbours)
            })
            .collect();
        let mut offsets = Vec::with_capacity(nodes.len() + 1);
        offsets.push(0);
        let mut neighbours = Vec::with_capacity(chunks.iter().map(|(_, found)| found.len()).sum());
        for (counts, found) in chunks {
            let mut end = neighbours.len();
            offsets.extend(counts.iter().map(|count| {
                end += count;
                end
            }));
            neighbours.extend(found);
        }
        Self {
            offsets,
            neighbours,
            corner_offsets,
            corners,
        }
    }

    /// The neighbours of a node and itself, increasing.
    pub(crate) fn neighbours(&self, node: usize) -> &[usize] {
        &self.neighbours[self.offsets[node]..self.offsets[node + 1]]
    }

    /// The node in each of its tetrahedra, which increase.
    fn corners(&self, node: usize) -> &[(usize, usize)] {
        &self.corners[self.corner_offsets[node]..self.corner_offsets[node + 1]]
    }
}

/// The corners of every node, and where they begin.
fn corners(mesh: &Mesh) -> (Vec<usize>, Vec<(usize, usize)>) {
    let mut offsets = vec![0; mesh.coordinates.len() + 1];
    let nodes = |t: usize| mesh.tetrahedron_nodes(t);
    for node in (0..mesh.tetrahedra.len()).flat_map(nodes) {
        offsets[node + 1] += 1;
    }
    for node in 0..mesh.coordinates.len() {
        offsets[node + 1] += offsets[node];
    }
    let mut next = offsets.clone();
    let mut corners = vec![(0, 0); mesh.nodes_per_tetrahedron() * mesh.tetrahedra.len()];
    for tetrahedron in 0..mesh.tetrahedra.len() {
        for (place, node) in nodes(tetrahedron).enumerate() {
            corners[next[node]] = (tetrahedron, place);
            next[node] += 1;
        }
    }
    (offsets, corners)
}

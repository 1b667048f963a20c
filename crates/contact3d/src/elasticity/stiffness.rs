//! The stiffness matrix, gathered node by node, and the forces and stresses of a displacement.

use nalgebra::{Matrix3, Matrix6, Vector3};
use rayon::prelude::*;

use super::{DofMap, Element, MaterialField};
use crate::{linalg::CscMatrix, mesh::Mesh};

/// Tetrahedra around each node, as offsets and (tetrahedron, place in it) pairs in increasing order.
struct Stars {
    offsets: Vec<usize>,
    corners: Vec<(usize, usize)>,
}

impl Stars {
    fn new(mesh: &Mesh) -> Self {
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
        for t in 0..mesh.tetrahedra.len() {
            for (place, node) in nodes(t).enumerate() {
                corners[next[node]] = (t, place);
                next[node] += 1;
            }
        }
        Self { offsets, corners }
    }

    fn of(&self, node: usize) -> &[(usize, usize)] {
        &self.corners[self.offsets[node]..self.offsets[node + 1]]
    }

    /// The node and its neighbours, increasing.
    fn neighbours(&self, mesh: &Mesh, node: usize) -> Vec<usize> {
        let mut found: Vec<usize> = self
            .of(node)
            .iter()
            .flat_map(|&(t, _)| mesh.tetrahedron_nodes(t))
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    }
}

/// Node graph of the mesh in compressed rows (offsets, neighbours), without loops.
#[must_use]
pub(crate) fn node_adjacency(mesh: &Mesh) -> (Vec<usize>, Vec<usize>) {
    let stars = Stars::new(mesh);
    let mut offsets = vec![0];
    let mut neighbours = Vec::new();
    for node in 0..mesh.coordinates.len() {
        neighbours.extend(
            stars
                .neighbours(mesh, node)
                .into_iter()
                .filter(|&n| n != node),
        );
        offsets.push(neighbours.len());
    }
    (offsets, neighbours)
}

/// The stiffness matrix A over the free degrees of freedom, `[n_free, n_free]`, in N/m.
///
/// Each node gathers the blocks V G_aᵀ C G_b of its own tetrahedra in their order, so the result
/// has the same bits at any thread count; a block and its mirror image are the same numbers, so A
/// is symmetric to the last bit.
#[must_use]
pub fn stiffness(mesh: &Mesh, material: &MaterialField<'_>, dofs: &DofMap) -> CscMatrix {
    let elements: Vec<Element> = (0..mesh.tetrahedra.len())
        .into_par_iter()
        .map(|t| Element::of(mesh, t))
        .collect();
    let stars = Stars::new(mesh);
    let columns: Vec<Vec<(Vec<usize>, Vec<f64>)>> = (0..mesh.coordinates.len())
        .into_par_iter()
        .map(|node| node_columns(node, mesh, &elements, material, &stars, dofs))
        .collect();
    let mut matrix = CscMatrix {
        rows: dofs.n_free,
        cols: dofs.n_free,
        indptr: vec![0],
        indices: Vec::new(),
        data: Vec::new(),
    };
    for (indices, data) in columns.into_iter().flatten() {
        matrix.indices.extend(indices);
        matrix.data.extend(data);
        matrix.indptr.push(matrix.indices.len());
    }
    matrix
}

/// The columns of A that belong to the free components of one node.
fn node_columns(
    node: usize,
    mesh: &Mesh,
    elements: &[Element],
    material: &MaterialField<'_>,
    stars: &Stars,
    dofs: &DofMap,
) -> Vec<(Vec<usize>, Vec<f64>)> {
    let neighbours = stars.neighbours(mesh, node);
    let mut blocks = vec![Matrix3::<f64>::zeros(); neighbours.len()];
    for &(t, b) in stars.of(node) {
        for (a, other) in mesh.tetrahedron_nodes(t).enumerate() {
            let at = neighbours.partition_point(|&n| n < other);
            blocks[at] += symmetric_block(&elements[t], material.tensor(t), a, b, other.cmp(&node));
        }
    }
    (0..3)
        .filter(|&component| dofs.dof[node][component].is_some())
        .map(|component| {
            let entries = neighbours.iter().zip(&blocks).flat_map(|(&other, block)| {
                (0..3).filter_map(move |row| Some((dofs.dof[other][row]?, block[(row, component)])))
            });
            entries.unzip()
        })
        .collect()
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
        for t in 0..n_tetrahedra {
            let element = Element::of(mesh, t);
            let tensor = material.tensor(t);
            let local: Vec<[f64; 3]> = mesh.tetrahedron_nodes(t).map(|n| displacement[n]).collect();
            let mut forces = vec![Vector3::zeros(); local.len()];
            element.add_internal_forces(tensor, &local, &mut forces);
            for (node, force) in mesh.tetrahedron_nodes(t).zip(&forces) {
                for component in 0..3 {
                    found.forces[node][component] += force[component];
                }
            }
            found
                .stress
                .push(element.centroid_stress(tensor, &local).into());
            if mesh.mid_edges.is_some() {
                let at = |k| std::array::from_fn(|j| f64::from(u8::from(j == k)));
                let corner = |k| element.stress(tensor, &local, &at(k)).into();
                found.corner_stress.push(std::array::from_fn(corner));
            }
        }
        found
    }
}

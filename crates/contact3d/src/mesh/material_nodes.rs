//! Nodes of materials: where two materials meet a node has a stress in each.

use std::collections::HashMap;

use super::Mesh;

/// The nodes of the mesh in their order, each with the first region there is at it, then again the nodes on interfaces with each further one.
#[derive(Debug, Clone)]
pub struct MaterialNodes {
    /// The node of each row, `[n_material_nodes]`.
    pub nodes: Vec<usize>,
    /// The region of each row.
    regions: Vec<usize>,
    /// The rows of the nodes of each tetrahedron, one after the other.
    rows: Vec<usize>,
    n_nodes: usize,
    nodes_per_tetrahedron: usize,
}

impl MaterialNodes {
    /// Those of a mesh.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let n_nodes = mesh.coordinates.len();
        let region = |t: usize| mesh.tetrahedron_region.get(t).copied().unwrap_or(0);
        let mut regions = vec![usize::MAX; n_nodes];
        for t in 0..mesh.tetrahedra.len() {
            for node in mesh.tetrahedron_nodes(t) {
                regions[node] = regions[node].min(region(t));
            }
        }
        let mut nodes: Vec<usize> = (0..n_nodes).collect();
        let mut rows = Vec::new();
        let mut further = HashMap::new();
        for t in 0..mesh.tetrahedra.len() {
            for node in mesh.tetrahedron_nodes(t) {
                if regions[node] == region(t) {
                    rows.push(node);
                    continue;
                }
                rows.push(*further.entry((node, region(t))).or_insert_with(|| {
                    nodes.push(node);
                    regions.push(region(t));
                    nodes.len() - 1
                }));
            }
        }
        Self {
            nodes,
            regions,
            rows,
            n_nodes,
            nodes_per_tetrahedron: mesh.nodes_per_tetrahedron(),
        }
    }

    /// The rows of the nodes of a tetrahedron, first those of its corners.
    #[must_use]
    pub fn of_tetrahedron(&self, t: usize) -> &[usize] {
        &self.rows[t * self.nodes_per_tetrahedron..][..self.nodes_per_tetrahedron]
    }

    /// Node and region of each row, `[n_material_nodes]`; `None` where no node has two.
    #[must_use]
    pub fn regions(&self) -> Option<Vec<[usize; 2]>> {
        let rows = self.nodes.iter().zip(&self.regions);
        (self.nodes.len() > self.n_nodes)
            .then(|| rows.map(|(node, region)| [*node, *region]).collect())
    }

    /// Values of nodes as values of rows.
    #[must_use]
    pub fn of_nodes<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.nodes.iter().map(|&node| values[node]).collect()
    }

    /// The largest of the values that each node has, `[n_nodes]`.
    #[must_use]
    pub fn largest(&self, values: &[f64]) -> Vec<f64> {
        let mut largest = values[..self.n_nodes].to_vec();
        for (&node, &value) in self.nodes.iter().zip(values) {
            largest[node] = largest[node].max(value);
        }
        largest
    }
}

//! Which nodes act on each other.

use rayon::prelude::*;

use crate::mesh::Mesh;

/// Nodes that one thread treats.
pub(super) const CHUNK: usize = 512;

/// The graph of a mesh: nodes are neighbours that share a tetrahedron, and each is its own.
#[derive(Debug)]
pub(crate) struct NodeGraph {
    offsets: Vec<usize>,
    neighbours: Vec<usize>,
    corner_offsets: Vec<usize>,
    corners: Vec<Corner>,
}

/// A node as one of a tetrahedron's.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Corner {
    pub(super) tetrahedron: usize,
    /// Place of the node in the tetrahedron.
    pub(super) place: usize,
}

impl NodeGraph {
    /// The graph of the nodes of a mesh.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let (corner_offsets, corners) = corners(mesh);
        let nodes: Vec<usize> = (0..mesh.coordinates.len()).collect();
        let chunks: Vec<(Vec<usize>, Vec<usize>)> = nodes
            .par_chunks(CHUNK)
            .map(|nodes| {
                let (mut counts, mut neighbours) = (Vec::new(), Vec::new());
                let mut found = Vec::new();
                for &node in nodes {
                    let around = &corners[corner_offsets[node]..corner_offsets[node + 1]];
                    found.clear();
                    found.extend(
                        around
                            .iter()
                            .flat_map(|corner| mesh.tetrahedron_nodes(corner.tetrahedron)),
                    );
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
    pub(super) fn corners(&self, node: usize) -> &[Corner] {
        &self.corners[self.corner_offsets[node]..self.corner_offsets[node + 1]]
    }
}

/// The corners of every node, and where they begin.
fn corners(mesh: &Mesh) -> (Vec<usize>, Vec<Corner>) {
    let mut offsets = vec![0; mesh.coordinates.len() + 1];
    let nodes = |t: usize| mesh.tetrahedron_nodes(t);
    for node in (0..mesh.tetrahedra.len()).flat_map(nodes) {
        offsets[node + 1] += 1;
    }
    for node in 0..mesh.coordinates.len() {
        offsets[node + 1] += offsets[node];
    }
    let mut next = offsets.clone();
    let mut corners = vec![Corner::default(); mesh.nodes_per_tetrahedron() * mesh.tetrahedra.len()];
    for tetrahedron in 0..mesh.tetrahedra.len() {
        for (place, node) in nodes(tetrahedron).enumerate() {
            corners[next[node]] = Corner { tetrahedron, place };
            next[node] += 1;
        }
    }
    (offsets, corners)
}

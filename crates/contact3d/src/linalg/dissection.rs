//! Nested dissection of a mesh's node graph, with separators sought along planes and along
//! breadth-first levels.

use faer::{
    dyn_stack::{MemBuffer, MemStack},
    sparse::{SymbolicSparseColMatRef, linalg::amd as faer_amd},
};
use thiserror::Error;

use super::{separator::best_split, sparse::CscMatrix};

/// Parts of at most this many nodes are ordered by minimum degree.
const LEAF_NODES: usize = 100;

/// Parts above this many nodes are dissected in parallel.
const PARALLEL_NODES: usize = 2000;

/// Edges shorter along an axis than this share of the longest count as lying across it.
const ACROSS: f64 = 1e-6;

/// Adjacency and cell-scaled coordinates of some nodes of the mesh, numbered from 0.
#[derive(Default)]
pub(super) struct Subgraph {
    /// The mesh's number of each node.
    nodes: Vec<usize>,
    /// Start of each node's neighbours.
    pub(super) indptr: Vec<usize>,
    /// Neighbours, without the node itself, increasing.
    pub(super) indices: Vec<usize>,
    /// Coordinates in units of a typical cell.
    pub(super) points: Vec<[f64; 3]>,
}

/// Fill-reducing ordering of a mesh's nodes by nested dissection, new → old.
///
/// The graph is given by pointers `indptr` (nodes + 1) and neighbours `indices`, symmetric; an
/// entry of a node with itself is ignored. Each part is cut across the three axes, the four body
/// diagonals or the levels of a breadth-first search, whichever promises least work; coordinates
/// are measured in median edge extents along each axis, so stretching the body changes nothing. The
/// result does not depend on the number of threads. Complexity O(n log² n).
///
/// # Errors
/// [`OrderingError`] when the arrays do not describe a graph with one point per node, or memory
/// runs out.
pub fn nested_dissection(
    indptr: &[usize],
    indices: &[usize],
    points: &[[f64; 3]],
) -> Result<Vec<usize>, OrderingError> {
    let nodes = points.len();
    let rising = indptr.windows(2).all(|pair| pair[0] <= pair[1]);
    let ends = indptr.first() == Some(&0) && indptr.last() == Some(&indices.len());
    if indptr.len() != nodes + 1 || !rising || !ends || indices.iter().any(|&node| node >= nodes) {
        return Err(OrderingError::NotAGraph { nodes });
    }
    Subgraph::whole(indptr, indices, points).dissect()
}

/// The ordering of unknowns that takes each node's unknowns together, new → old.
///
/// `unknowns(node)` are the unknowns of a node, none for a clamped one.
#[must_use]
pub fn expand_to_unknowns<I: IntoIterator<Item = usize>>(
    node_order: &[usize],
    unknowns: impl Fn(usize) -> I,
) -> Vec<usize> {
    node_order.iter().flat_map(|&node| unknowns(node)).collect()
}

impl Subgraph {
    /// The whole mesh, its graph made symmetric and free of loops.
    fn whole(indptr: &[usize], indices: &[usize], points: &[[f64; 3]]) -> Self {
        let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); points.len()];
        for node in 0..points.len() {
            for &other in indices[indptr[node]..indptr[node + 1]]
                .iter()
                .filter(|&&other| other != node)
            {
                neighbours[node].push(other);
                neighbours[other].push(node);
            }
        }
        let mut part = Self {
            nodes: (0..points.len()).collect(),
            indptr: vec![0],
            ..Self::default()
        };
        for list in &mut neighbours {
            list.sort_unstable();
            list.dedup();
            part.indices.extend_from_slice(list);
            part.indptr.push(part.indices.len());
        }
        part.points = cell_scaled(&part.indptr, &part.indices, points);
        part
    }

    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    pub(super) fn neighbours(&self, node: usize) -> &[usize] {
        &self.indices[self.indptr[node]..self.indptr[node + 1]]
    }

    /// The ordering of this part's nodes in the mesh's numbers: one side, the other side, the
    /// separator.
    fn dissect(self) -> Result<Vec<usize>, OrderingError> {
        let is_leaf = self.len() <= LEAF_NODES;
        let Some(split) = (!is_leaf).then(|| best_split(&self)).flatten() else {
            let order = amd_of_pattern(&self.indptr, &self.indices)?;
            return Ok(order.into_iter().map(|node| self.nodes[node]).collect());
        };
        let parallel = self.len() > PARALLEL_NODES;
        let (a, b) = (self.restrict(&split.first), self.restrict(&split.second));
        let separator = split.separator.iter().map(|&node| self.nodes[node]);
        let separator: Vec<usize> = separator.collect();
        drop((self, split));
        let (a, b) = if parallel {
            rayon::join(|| a.dissect(), || b.dissect())
        } else {
            (a.dissect(), b.dissect())
        };
        let mut order = a?;
        order.extend(b?);
        order.extend(separator);
        Ok(order)
    }

    /// The subgraph of the given nodes (increasing).
    fn restrict(&self, nodes: &[usize]) -> Self {
        let mut number = vec![usize::MAX; self.len()];
        nodes
            .iter()
            .enumerate()
            .for_each(|(new, &old)| number[old] = new);
        let mut part = Self {
            indptr: vec![0],
            ..Self::default()
        };
        for &old in nodes {
            let kept = self
                .neighbours(old)
                .iter()
                .map(|&other| number[other])
                .filter(|&new| new != usize::MAX);
            part.indices.extend(kept);
            part.indptr.push(part.indices.len());
            part.nodes.push(self.nodes[old]);
            part.points.push(self.points[old]);
        }
        part
    }
}

/// Coordinates divided by the median extent of the edges along each axis (those across it left
/// out), so that stretched bodies look as if they were not and the planes of a lattice stay planes.
fn cell_scaled(indptr: &[usize], indices: &[usize], points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let scale: [f64; 3] = std::array::from_fn(|axis| {
        let mut extents = Vec::with_capacity(indices.len());
        for (node, range) in indptr.windows(2).enumerate() {
            let extent = |&other: &usize| (points[node][axis] - points[other][axis]).abs();
            extents.extend(indices[range[0]..range[1]].iter().map(extent));
        }
        let longest = extents.iter().copied().fold(0.0, f64::max);
        extents.retain(|&extent| extent > ACROSS * longest);
        let middle = extents.len() / 2;
        if extents.is_empty() {
            0.0
        } else {
            extents
                .select_nth_unstable_by(middle, f64::total_cmp)
                .1
                .recip()
        }
    });
    points
        .iter()
        .map(|point| std::array::from_fn(|axis| on_grid(point[axis] * scale[axis])))
        .collect()
}

/// The nearest multiple of 2⁻¹⁶ cells, so that nodes of one lattice plane stay in one plane
/// whatever roundings their coordinates carry.
fn on_grid(coordinate: f64) -> f64 {
    const STEPS: f64 = 65536.0;
    (coordinate * STEPS).round() / STEPS
}

/// Why no ordering was made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum OrderingError {
    /// The matrix is not square.
    #[error("an ordering needs a square matrix, got {rows} × {cols}")]
    NotSquare {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        cols: usize,
    },
    /// Pointers and neighbours do not describe a graph of the given nodes.
    #[error("adjacency arrays do not describe a graph of {nodes} nodes")]
    NotAGraph {
        /// Number of nodes.
        nodes: usize,
    },
    /// Work space could not be allocated, or an index overflowed.
    #[error("not enough memory to order {rows} rows")]
    OutOfMemory {
        /// Number of rows.
        rows: usize,
    },
}

/// Approximate minimum degree ordering of a symmetric matrix, new → old: row i of PAPᵀ is row
/// `result[i]` of A.
///
/// # Errors
/// [`OrderingError`] for a matrix that is not square or too large for memory.
pub fn amd(a: &CscMatrix) -> Result<Vec<usize>, OrderingError> {
    if a.rows != a.cols {
        return Err(OrderingError::NotSquare {
            rows: a.rows,
            cols: a.cols,
        });
    }
    amd_of_pattern(&a.indptr, &a.indices)
}

/// [`amd`] of a square pattern given by pointers and sorted indices.
pub(super) fn amd_of_pattern(
    indptr: &[usize],
    indices: &[usize],
) -> Result<Vec<usize>, OrderingError> {
    let n = indptr.len() - 1;
    let failure = OrderingError::OutOfMemory { rows: n };
    let mut order = vec![0_usize; n];
    let mut inverse = vec![0_usize; n];
    let scratch = faer_amd::order_scratch::<usize>(n, indices.len());
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| failure.clone())?;
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, indptr, None, indices);
    let control = faer_amd::Control::default();
    faer_amd::order(
        &mut order,
        &mut inverse,
        pattern,
        control,
        MemStack::new(&mut memory),
    )
    .map_err(|_| failure)?;
    Ok(order)
}

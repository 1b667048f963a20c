//! Nested dissection of a mesh's node graph: every cut of a few sweeps over its nodes, along planes and breadth-first levels, is
//! weighed, and the cheapest is taken.

use faer::{
    dyn_stack::{MemBuffer, MemStack},
    sparse::{SymbolicSparseColMatRef, linalg::amd as faer_amd},
};

use super::{sparse::CscMatrix, structure::FactorError};

/// The sweeps that look at coordinates go along the axes and the body diagonals: even nodes of the
/// mesh of five tetrahedra per cube form a face-centred lattice, whose sparsest planes are {111}.
const DIRECTIONS: [[f64; 3]; 7] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Adjacency and cell-scaled coordinates of some nodes of the mesh, numbered from 0.
#[derive(Default)]
struct Subgraph {
    /// The mesh's number of each node.
    nodes: Vec<usize>,
    /// Start of each node's neighbours.
    indptr: Vec<usize>,
    /// Neighbours, without the node itself, increasing.
    indices: Vec<usize>,
    /// Coordinates in units of a typical cell.
    points: Vec<[f64; 3]>,
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
/// [`FactorError`] when the arrays do not describe a graph with one point per node, or memory
/// runs out.
pub fn nested_dissection(
    indptr: &[usize],
    indices: &[usize],
    points: &[[f64; 3]],
) -> Result<Vec<usize>, FactorError> {
    let nodes = points.len();
    let rising = indptr.windows(2).all(|pair| pair[0] <= pair[1]);
    let ends = indptr.first() == Some(&0) && indptr.last() == Some(&indices.len());
    if indptr.len() != nodes + 1 || !rising || !ends || indices.iter().any(|&node| node >= nodes) {
        return Err(FactorError::NotAGraph { nodes });
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

    fn len(&self) -> usize {
        self.nodes.len()
    }

    fn neighbours(&self, node: usize) -> &[usize] {
        &self.indices[self.indptr[node]..self.indptr[node + 1]]
    }

    /// The ordering of this part's nodes in the mesh's numbers: one side, the other side, the
    /// separator. Parts of at most 100 nodes are ordered by minimum degree.
    fn dissect(self) -> Result<Vec<usize>, FactorError> {
        let is_leaf = self.len() <= 100;
        let Some([first, second, separator]) = (!is_leaf).then(|| best_split(&self)).flatten()
        else {
            let order = amd_of_pattern(&self.indptr, &self.indices)?;
            return Ok(order.into_iter().map(|node| self.nodes[node]).collect());
        };
        let parallel = self.len() > 2000;
        let (a, b) = (self.restrict(&first), self.restrict(&second));
        let separator: Vec<usize> = separator.iter().map(|&node| self.nodes[node]).collect();
        drop((self, first, second));
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
        extents.retain(|&extent| extent > 1e-6 * longest);
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
    let steps = 65536.0;
    (coordinate * steps).round() / steps
}

/// A cut of a sweep: the nodes before `position` against the others, the separator being the
/// boundary of one of them.
#[derive(Clone, Copy)]
struct Cut {
    cost: f64,
    position: usize,
    /// The separator consists of the nodes before `position` that have a neighbour after it (else
    /// the reverse).
    separator_before: bool,
}

/// Both sides of the cheapest separator found and itself, each increasing, or `None` when every cut leaves a side empty or takes half
/// of the nodes.
fn best_split(part: &Subgraph) -> Option<[Vec<usize>; 3]> {
    let planes = DIRECTIONS
        .iter()
        .map(|direction| places_along(part, direction));
    let sweeps = planes.chain(std::iter::once(levels(part)));
    let mut best: Option<(Cut, Vec<usize>)> = None;
    for places in sweeps {
        let rank = ranks(&places);
        if let Some(cut) = best_cut(part, &rank)
            && best.as_ref().is_none_or(|(found, _)| cut.cost < found.cost)
        {
            best = Some((cut, rank));
        }
    }
    best.map(|(cut, rank)| split_at(part, &cut, &rank))
}

/// Work of factorising: s³ for the dense separator and n²/8 for a three-dimensional part of n nodes.
fn cost(separator: usize, first: usize, second: usize) -> f64 {
    (separator as f64).powi(3) + 0.125 * ((first as f64).powi(2) + (second as f64).powi(2))
}

/// Number of the plane across `direction` each node lies in: planes are a thousandth of a cell thick.
fn places_along(part: &Subgraph, direction: &[f64; 3]) -> Vec<i64> {
    let place = |point: &[f64; 3]| point.iter().zip(direction).map(|(x, d)| x * d).sum::<f64>();
    part.points
        .iter()
        .map(|point| (place(point) / 1e-3).round() as i64)
        .collect()
}

/// Breadth-first level of each node from a pseudo-peripheral one; further components follow with
/// higher levels.
fn levels(part: &Subgraph) -> Vec<i64> {
    let mut level = vec![-1; part.len()];
    let mut next_level = 0;
    for start in 0..part.len() {
        if level[start] < 0 {
            let mut scratch = level.clone();
            let far = *breadth_first(part, start, 0, &mut scratch)
                .last()
                .unwrap_or(&start);
            let visited = breadth_first(part, far, next_level, &mut level);
            next_level = visited.last().map_or(next_level, |&node| level[node]) + 1;
        }
    }
    level
}

/// Numbers the levels of one component from `start` on; returns its nodes in the order they were
/// met.
fn breadth_first(part: &Subgraph, start: usize, first_level: i64, level: &mut [i64]) -> Vec<usize> {
    let mut met = vec![start];
    level[start] = first_level;
    let mut done = 0;
    while done < met.len() {
        let node = met[done];
        done += 1;
        for &other in part.neighbours(node) {
            if level[other] < 0 {
                level[other] = level[node] + 1;
                met.push(other);
            }
        }
    }
    met
}

/// Rank of each node in the order of the places, equal places in the order of the nodes.
fn ranks(places: &[i64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by_key(|&node| (places[node], node));
    let mut rank = vec![0; places.len()];
    order
        .into_iter()
        .enumerate()
        .for_each(|(place, node)| rank[node] = place);
    rank
}

/// The cheapest cut of a sweep. The boundary sizes of all cuts come from one pass: a node belongs
/// to the boundary of the far side of the cuts between its first neighbour and itself, and of the
/// near side of those between itself and its last.
fn best_cut(part: &Subgraph, rank: &[usize]) -> Option<Cut> {
    let nodes = part.len();
    let mut after = vec![0_isize; nodes + 2];
    let mut before = vec![0_isize; nodes + 2];
    for node in 0..nodes {
        let own = rank[node];
        let (mut lowest, mut highest) = (own, own);
        for &other in part.neighbours(node) {
            lowest = lowest.min(rank[other]);
            highest = highest.max(rank[other]);
        }
        after[lowest + 1] += 1;
        after[own + 1] -= 1;
        before[own + 1] += 1;
        before[highest + 1] -= 1;
    }
    // Neither side of a cut has fewer than this fraction of the nodes.
    let smallest = (nodes as f64 * 0.22) as usize;
    let (mut size_after, mut size_before) = (0, 0);
    let mut best: Option<Cut> = None;
    for position in 1..nodes {
        size_after += after[position];
        size_before += before[position];
        if position < smallest || nodes - position < smallest {
            continue;
        }
        for (size, separator_before) in [(size_after, false), (size_before, true)] {
            let size = size.unsigned_abs();
            let (mut first, mut second) = (position, nodes - position);
            let side = if separator_before {
                &mut first
            } else {
                &mut second
            };
            *side -= size;
            let cost = cost(size, first, second);
            let useful = first > 0 && second > 0 && 2 * size < nodes;
            if useful && best.is_none_or(|found| cost < found.cost) {
                best = Some(Cut {
                    cost,
                    position,
                    separator_before,
                });
            }
        }
    }
    best
}

fn split_at(part: &Subgraph, cut: &Cut, rank: &[usize]) -> [Vec<usize>; 3] {
    let [mut first, mut second, mut separator] = <[Vec<usize>; 3]>::default();
    for node in 0..part.len() {
        let is_before = rank[node] < cut.position;
        let crosses = |&other: &usize| (rank[other] < cut.position) != is_before;
        if is_before == cut.separator_before && part.neighbours(node).iter().any(crosses) {
            separator.push(node);
        } else if is_before {
            first.push(node);
        } else {
            second.push(node);
        }
    }
    [first, second, separator]
}

/// Approximate minimum degree ordering of a symmetric matrix, new → old: row i of PAPᵀ is row
/// `result[i]` of A.
///
/// # Errors
/// [`FactorError`] for a matrix that is not square or too large for memory.
pub fn amd(a: &CscMatrix) -> Result<Vec<usize>, FactorError> {
    if a.rows != a.cols {
        return Err(FactorError::NotSquare {
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
) -> Result<Vec<usize>, FactorError> {
    let n = indptr.len() - 1;
    let failure = FactorError::OutOfMemory { size: n };
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

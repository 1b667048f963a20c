//! Vertex separators of a part of a mesh: every cut of a few sweeps over its nodes is weighed, the
//! cheapest is taken.

use super::dissection::Subgraph;

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

/// Nodes whose places along a sweep differ by less than this share of a cell lie in one plane.
const PLANE_TOLERANCE: f64 = 1e-3;

/// The smallest share of a part's nodes on either side of a cut.
const SMALLEST_SHARE: f64 = 0.22;

/// Weight of the work inside the two sides against that of the separator in [`cost`].
const SIDE_WEIGHT: f64 = 0.125;

/// A part's nodes in three sets, each increasing, no edge joining the first two.
#[derive(Default)]
pub(super) struct Split {
    pub(super) first: Vec<usize>,
    pub(super) second: Vec<usize>,
    pub(super) separator: Vec<usize>,
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

/// The cheapest separator found, or `None` when every cut leaves a side empty or takes half of the
/// nodes.
pub(super) fn best_split(part: &Subgraph) -> Option<Split> {
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

/// Work of factorising: s³ for the dense separator and n² for a three-dimensional part of n nodes.
fn cost(separator: usize, first: usize, second: usize) -> f64 {
    (separator as f64).powi(3) + SIDE_WEIGHT * ((first as f64).powi(2) + (second as f64).powi(2))
}

/// Number of the plane across `direction` each node lies in.
fn places_along(part: &Subgraph, direction: &[f64; 3]) -> Vec<i64> {
    let place = |point: &[f64; 3]| point.iter().zip(direction).map(|(x, d)| x * d).sum::<f64>();
    part.points
        .iter()
        .map(|point| (place(point) / PLANE_TOLERANCE).round() as i64)
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
    let smallest = (nodes as f64 * SMALLEST_SHARE) as usize;
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

fn split_at(part: &Subgraph, cut: &Cut, rank: &[usize]) -> Split {
    let mut split = Split::default();
    for node in 0..part.len() {
        let is_before = rank[node] < cut.position;
        let crosses = |&other: &usize| (rank[other] < cut.position) != is_before;
        if is_before == cut.separator_before && part.neighbours(node).iter().any(crosses) {
            split.separator.push(node);
        } else if is_before {
            split.first.push(node);
        } else {
            split.second.push(node);
        }
    }
    split
}

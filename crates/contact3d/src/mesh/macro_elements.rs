//! Panes on any triangulated contact face.
//!
//! With multipliers constant on panes, B has full row rank (HKL condition (3.1)) when every pane
//! holds the whole star, that is all contact triangles, of a free node of its own: the column of
//! this node in N_ij = ∫_{Rⁱ} φ_j is zero in all other rows.
//!
//! So a front chooses free nodes inside the face, no two of them neighbours, as long as there are
//! any. For P2 the mid-edge nodes take that part. Their stars are the cores of the panes, and panes grow over the triangles left between
//! them, the smallest first. The squared singular values of |R|^(-1/2) N m^(-1/2) with the masses
//! m_j = ∫ φ_j are then at least |star|/(3|R|), for the pane where this is smallest.

use std::{
    cmp::Reverse,
    collections::{BTreeMap, BTreeSet},
};

use nalgebra::Vector3;

use super::{quadratic::edge, triangle_area};
use crate::{reference::TRIANGLE_EDGES, scene::InvalidValue};

/// The pane of each contact triangle; panes are numbered row by row along increasing z, y, x.
///
/// `carriers` are the nodes of each triangle that can stand inside a pane of their own: its corners
/// for P1, the middles of its edges for P2, whose stars are the two triangles at an edge. `is_free`
/// says which nodes can move.
///
/// # Errors
/// When a part of the contact face has no free node inside it.
pub fn macro_elements(
    coordinates: &[[f64; 3]],
    triangles: &[[usize; 3]],
    carriers: &[[usize; 3]],
    is_free: impl Fn(usize) -> bool,
) -> Result<Vec<usize>, InvalidValue> {
    let surface = Adjacency::new(coordinates, triangles, carriers, is_free);
    if surface.inner.is_empty() {
        let found = format!(
            "{} triangles whose nodes are all on its edge or held",
            triangles.len()
        );
        return Err(unusable(found));
    }
    let mut cores = surface.cores();
    cores.sort_unstable_by_key(|core| surface.inner[core].row_rank);
    surface.grow(&cores)
}

fn unusable(found: String) -> InvalidValue {
    InvalidValue {
        key: "contact.face".to_owned(),
        expected: "a free node inside every part of the contact face".to_owned(),
        found,
        help: "refine the mesh of the contact face or use nodal multipliers".to_owned(),
    }
}

/// Contact triangles with what lies next to what.
struct Adjacency<'a> {
    triangles: &'a [[usize; 3]],
    area: Vec<f64>,
    centre: Vec<Vector3<f64>>,
    /// Triangles across the edges of each triangle.
    next: Vec<Vec<usize>>,
    /// The free nodes inside the face.
    inner: BTreeMap<usize, InnerNode>,
    /// Mean area of the stars of these nodes.
    mean_star: f64,
}

/// A free node inside the contact face.
struct InnerNode {
    at: Vector3<f64>,
    star: Vec<usize>,
    neighbours: BTreeSet<usize>,
    star_area: f64,
    /// Its place in the numbering by rows.
    row_rank: usize,
}

impl<'a> Adjacency<'a> {
    fn new(
        coordinates: &[[f64; 3]],
        triangles: &'a [[usize; 3]],
        carriers: &[[usize; 3]],
        is_free: impl Fn(usize) -> bool,
    ) -> Self {
        let corners = |t: &[usize; 3]| t.map(|n| coordinates[n]);
        let (next, edge_nodes) = adjacency(triangles, carriers);
        let mut surface = Self {
            triangles,
            area: triangles
                .iter()
                .map(|t| triangle_area(&corners(t)))
                .collect(),
            centre: triangles
                .iter()
                .map(|t| corners(t).map(Vector3::from).iter().sum::<Vector3<f64>>() / 3.0)
                .collect(),
            next,
            inner: BTreeMap::new(),
            mean_star: 0.0,
        };
        for (t, nodes) in carriers.iter().enumerate() {
            for &node in nodes {
                if edge_nodes.contains(&node) || !is_free(node) {
                    continue;
                }
                let inner = surface.inner.entry(node).or_insert_with(|| InnerNode {
                    at: coordinates[node].into(),
                    star: Vec::new(),
                    neighbours: BTreeSet::new(),
                    star_area: 0.0,
                    row_rank: 0,
                });
                inner.star.push(t);
                inner.star_area += surface.area[t];
                inner
                    .neighbours
                    .extend(nodes.iter().filter(|n| **n != node));
            }
        }
        surface.number_by_rows();
        surface
    }

    /// Orders the inner nodes by layers of z, rows of y and then x; layers and rows are as high as
    /// a star is wide, so that unevenness and roundings below that do not matter.
    fn number_by_rows(&mut self) {
        let stars = self.inner.values().map(|inner| inner.star_area);
        self.mean_star = stars.sum::<f64>() / self.inner.len() as f64;
        let height = self.mean_star.sqrt();
        let places = self.inner.values().map(|inner| inner.at);
        let low = places.reduce(|a, b| a.inf(&b)).unwrap_or_default();
        let row = |at: &Vector3<f64>, axis: usize| ((at[axis] - low[axis]) / height) as u64;
        let mut ranked: Vec<&mut InnerNode> = self.inner.values_mut().collect();
        ranked.sort_by(|a, b| {
            let rows = |inner: &InnerNode| (row(&inner.at, 2), row(&inner.at, 1));
            let along = |i: usize| a.at[i].total_cmp(&b.at[i]);
            let rows = rows(a).cmp(&rows(b));
            rows.then(along(0)).then(along(1)).then(along(2))
        });
        for (rank, inner) in ranked.into_iter().enumerate() {
            inner.row_rank = rank;
        }
    }

    /// An area or a square of a length as a whole number of millionths of the mean star, so that
    /// equal ones compare equal whatever their roundings.
    fn rounded(&self, area: f64) -> u64 {
        (area / self.mean_star * 1e6).round() as u64
    }

    /// A maximal set of inner nodes of which no two are neighbours.
    ///
    /// Each next node is the one with most neighbours already in a star, which packs the stars
    /// closely; then the one with the largest star, which finds the eight-triangle stars of a brick.
    fn cores(&self) -> Vec<usize> {
        let key = |node: usize, touched: usize| {
            let inner = &self.inner[&node];
            let size = self.rounded(inner.star_area);
            (Reverse(touched), Reverse(size), inner.row_rank, node)
        };
        let mut touched: BTreeMap<usize, usize> = self.inner.keys().map(|&n| (n, 0)).collect();
        let mut front: BTreeSet<_> = self.inner.keys().map(|&n| key(n, 0)).collect();
        let mut neighbours: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (&node, inner) in &self.inner {
            for &other in &inner.neighbours {
                neighbours.entry(other).or_default().push(node);
            }
        }
        let mut in_star = BTreeSet::new();
        let mut cores = Vec::new();
        while let Some((.., core)) = front.pop_first() {
            cores.push(core);
            touched.remove(&core);
            for &covered in &self.inner[&core].neighbours {
                if let Some(count) = touched.remove(&covered) {
                    front.remove(&key(covered, count));
                }
                if !in_star.insert(covered) {
                    continue;
                }
                for &node in neighbours.get(&covered).into_iter().flatten() {
                    if let Some(count) = touched.get_mut(&node) {
                        front.remove(&key(node, *count));
                        *count += 1;
                        front.insert(key(node, *count));
                    }
                }
            }
        }
        cores
    }

    /// Gives each core its star and the triangles between the stars to their neighbours: the
    /// smallest pane takes the nearest triangle next to it, until none is left.
    fn grow(&self, cores: &[usize]) -> Result<Vec<usize>, InvalidValue> {
        let mut pane: Vec<Option<usize>> = vec![None; self.triangles.len()];
        let mut area = vec![0.0; cores.len()];
        for (p, core) in cores.iter().enumerate() {
            for &t in &self.inner[core].star {
                pane[t] = Some(p);
            }
            area[p] = self.inner[core].star_area;
        }
        let distance = |t: usize, p: usize| {
            let square = (self.centre[t] - self.inner[&cores[p]].at).norm_squared();
            (self.rounded(square), t)
        };
        let mut reachable = vec![BTreeSet::new(); cores.len()];
        for (p, core) in cores.iter().enumerate() {
            let next = self.inner[core].star.iter().flat_map(|&t| &self.next[t]);
            reachable[p].extend(next.map(|&t| distance(t, p)));
        }
        let mut panes: BTreeSet<(u64, usize)> = (0..cores.len())
            .map(|p| (self.rounded(area[p]), p))
            .collect();
        while let Some((_, p)) = panes.pop_first() {
            let Some((_, t)) = reachable[p].pop_first() else {
                continue;
            };
            if pane[t].is_none() {
                pane[t] = Some(p);
                area[p] += self.area[t];
                reachable[p].extend(self.next[t].iter().map(|&s| distance(s, p)));
            }
            panes.insert((self.rounded(area[p]), p));
        }
        let lost = pane.iter().filter(|p| p.is_none()).count();
        pane.iter()
            .zip(&self.centre)
            .map(|(pane, centre)| {
                pane.ok_or_else(|| {
                    let [x, y, z] = (*centre).into();
                    unusable(format!(
                        "{lost} triangles in parts without one, such as that at x, y, z = {x:.6e}, {y:.6e}, {z:.6e}"
                    ))
                })
            })
            .collect()
    }
}

/// The triangles across each triangle's edges, and the carriers on the edge of the whole face.
fn adjacency(
    triangles: &[[usize; 3]],
    carriers: &[[usize; 3]],
) -> (Vec<Vec<usize>>, BTreeSet<usize>) {
    let mut edges: Vec<([usize; 2], usize, usize)> = triangles
        .iter()
        .enumerate()
        .flat_map(|(t, nodes)| {
            let sides = TRIANGLE_EDGES.into_iter().enumerate();
            sides.map(move |(side, [a, b])| (edge(nodes[a], nodes[b]), t, side))
        })
        .collect();
    edges.sort_unstable();
    let mut next = vec![Vec::new(); triangles.len()];
    let mut edge_nodes = BTreeSet::new();
    for shared in edges.chunk_by(|a, b| a.0 == b.0) {
        if let &[(_, s, _), (_, t, _)] = shared {
            next[s].push(t);
            next[t].push(s);
        } else {
            for &(ends, t, side) in shared {
                let on_edge = carriers[t].contains(&ends[0]);
                if on_edge {
                    edge_nodes.extend(ends);
                } else {
                    edge_nodes.insert(carriers[t][side]);
                }
            }
        }
    }
    (next, edge_nodes)
}

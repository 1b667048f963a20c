//! Panes on any triangulated contact face.
//!
//! With multipliers constant on panes, B has full row rank (HKL condition (3.1)) when every pane
//! holds the whole star, that is all contact triangles, of a free node of its own: the column of
//! this node in N_ij = ∫_{Rⁱ} φ_j is zero in all other rows.
//!
//! So a front chooses free nodes inside the face, no two of them neighbours, as long as there are
//! any. Their stars are the cores of the panes, and panes grow over the triangles left between
//! them, the smallest first. The squared singular values of |R|^(-1/2) N m^(-1/2) with the masses
//! m_j = ∫ φ_j are then at least |star|/(3|R|), for the pane where this is smallest.

use std::{
    cmp::Reverse,
    collections::{BTreeMap, BTreeSet},
};

use nalgebra::Vector3;

use super::triangle_area;
use crate::scene::Invalid;

/// The pane of each contact triangle; panes are numbered row by row along increasing z, y, x.
///
/// `facets` are the contact triangles among `mesh_facets`, and `is_free` says which nodes can move.
///
/// # Errors
/// When a part of the contact face has no free node inside it.
pub(super) fn build(
    coordinates: &[[f64; 3]],
    mesh_facets: &[[usize; 3]],
    facets: &[usize],
    is_free: impl Fn(usize) -> bool,
) -> Result<Vec<usize>, Invalid> {
    let triangles: Vec<[usize; 3]> = facets.iter().map(|&f| mesh_facets[f]).collect();
    let surface = Surface::new(coordinates, &triangles, is_free);
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

fn unusable(found: String) -> Invalid {
    Invalid {
        key: "contact.face".to_owned(),
        expected: "a free node inside every part of the contact face".to_owned(),
        found,
        help: "refine the mesh of the contact face or use nodal multipliers".to_owned(),
    }
}

/// Contact triangles with what lies next to what.
struct Surface<'a> {
    triangles: &'a [[usize; 3]],
    area: Vec<f64>,
    centre: Vec<Vector3<f64>>,
    /// Triangles across the edges of each triangle.
    next: Vec<Vec<usize>>,
    /// The free nodes inside the face.
    inner: BTreeMap<usize, Inner>,
    /// Mean area of the stars of these nodes.
    mean_star: f64,
}

/// A free node inside the contact face.
struct Inner {
    at: Vector3<f64>,
    star: Vec<usize>,
    neighbours: BTreeSet<usize>,
    star_area: f64,
    /// Its place in the numbering by rows.
    row_rank: usize,
}

impl<'a> Surface<'a> {
    fn new(
        coordinates: &[[f64; 3]],
        triangles: &'a [[usize; 3]],
        is_free: impl Fn(usize) -> bool,
    ) -> Self {
        let corners = |t: &[usize; 3]| t.map(|n| coordinates[n]);
        let (next, edge_nodes) = adjacency(triangles);
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
        for (t, nodes) in triangles.iter().enumerate() {
            for &node in nodes {
                if edge_nodes.contains(&node) || !is_free(node) {
                    continue;
                }
                let inner = surface.inner.entry(node).or_insert_with(|| Inner {
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
        let mut ranked: Vec<&mut Inner> = self.inner.values_mut().collect();
        ranked.sort_by(|a, b| {
            let rows = |inner: &Inner| (row(&inner.at, 2), row(&inner.at, 1));
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
    fn grow(&self, cores: &[usize]) -> Result<Vec<usize>, Invalid> {
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
                        "{lost} triangles in parts without one, such as that at ({x:.6e}, {y:.6e}, {z:.6e}) m"
                    ))
                })
            })
            .collect()
    }
}

/// The triangles across each triangle's edges, and the nodes on the edge of the whole face.
fn adjacency(triangles: &[[usize; 3]]) -> (Vec<Vec<usize>>, BTreeSet<usize>) {
    let mut edges: Vec<([usize; 2], usize)> = triangles
        .iter()
        .enumerate()
        .flat_map(|(t, &[a, b, c])| {
            [[a, b], [b, c], [c, a]].map(|[p, q]| ([p.min(q), p.max(q)], t))
        })
        .collect();
    edges.sort_unstable();
    let mut next = vec![Vec::new(); triangles.len()];
    let mut edge_nodes = BTreeSet::new();
    for shared in edges.chunk_by(|a, b| a.0 == b.0) {
        if let &[(_, s), (_, t)] = shared {
            next[s].push(t);
            next[t].push(s);
        } else {
            edge_nodes.extend(shared[0].0);
        }
    }
    (next, edge_nodes)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use nalgebra::DMatrix;
    use proptest::prelude::*;

    use super::*;
    use crate::mesh::gmsh::parse;

    /// A contact face on its own, all of its triangles in contact.
    #[derive(Debug, Clone)]
    struct Flat {
        coordinates: Vec<[f64; 3]>,
        triangles: Vec<[usize; 3]>,
    }

    impl Flat {
        fn build(&self, is_free: impl Fn(usize) -> bool) -> Result<Vec<usize>, Invalid> {
            let all: Vec<usize> = (0..self.triangles.len()).collect();
            build(&self.coordinates, &self.triangles, &all, is_free)
        }

        fn area(&self, t: usize) -> f64 {
            triangle_area(&self.triangles[t].map(|n| self.coordinates[n]))
        }

        fn of_sample(bytes: &[u8]) -> Self {
            let mesh = parse(bytes).expect("a sample");
            let contact = mesh.face_names.iter().position(|n| n == "contact");
            let on_contact = mesh.facet_face.iter().map(|f| Some(*f) == contact);
            let triangles = mesh.facets.iter().zip(on_contact).filter(|(_, on)| *on);
            Self {
                triangles: triangles.map(|(f, _)| *f).collect(),
                coordinates: mesh.coordinates,
            }
        }

        /// The face of a brick of five tetrahedra a cell, in the plane of two axes, and the 2 × 2
        /// macro-face of each triangle: diagonals join nodes (i, j) with i + j even.
        fn of_brick(cell: [f64; 2], [nx, ny]: [usize; 2], axes: [usize; 2]) -> (Self, Vec<usize>) {
            let diagonals: Vec<bool> = (0..(nx + 1) * (ny + 1))
                .map(|n| (n % (nx + 1) + n / (nx + 1)) % 2 == 0)
                .collect();
            let mut flat = Self::uneven([nx, ny], &[0.0], &diagonals);
            for x in &mut flat.coordinates {
                let [i, j, _] = *x;
                *x = [0.7; 3];
                [x[axes[0]], x[axes[1]]] = [i * cell[0], j * cell[1]];
            }
            let cells = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
            let macro_face = cells.flat_map(|(i, j)| [i / 2 + nx / 2 * (j / 2); 2]);
            (flat, macro_face.collect())
        }

        /// A grid whose nodes are moved by up to a fifth of a cell and whose diagonals are random.
        fn uneven([nx, ny]: [usize; 2], shifts: &[f64], diagonals: &[bool]) -> Self {
            let node = |i: usize, j: usize| i + (nx + 1) * j;
            let shift = |k: usize| 0.2 * shifts[k % shifts.len()];
            let coordinates = (0..(nx + 1) * (ny + 1)).map(|n| {
                let [i, j] = [n % (nx + 1), n / (nx + 1)].map(|i| i as f64);
                [i + shift(2 * n), j + shift(2 * n + 1), 0.0]
            });
            let mut triangles = Vec::new();
            for (j, i) in (0..ny).flat_map(|j| (0..nx).map(move |i| (j, i))) {
                let [a, b, c, d] = [
                    node(i, j),
                    node(i + 1, j),
                    node(i + 1, j + 1),
                    node(i, j + 1),
                ];
                if diagonals[node(i, j) % diagonals.len()] {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, b, d], [b, c, d]]);
                }
            }
            Self {
                coordinates: coordinates.collect(),
                triangles,
            }
        }
    }

    /// Area of the largest star of a free node that lies in a pane, by brute force.
    fn largest_own_star(flat: &Flat, panes: &[usize], pane: usize, free: &[bool]) -> f64 {
        (0..flat.coordinates.len())
            .filter(|&node| free[node])
            .map(|node| {
                let star: Vec<usize> = (0..panes.len())
                    .filter(|&t| flat.triangles[t].contains(&node))
                    .collect();
                let own = star.iter().all(|&t| panes[t] == pane);
                if own {
                    star.iter().map(|&t| flat.area(t)).sum()
                } else {
                    0.0
                }
            })
            .fold(0.0, f64::max)
    }

    /// Smallest singular value of |R|^(-1/2) N m^(-1/2) over the free nodes.
    fn smallest_singular_value(flat: &Flat, panes: &[usize], free: &[bool]) -> f64 {
        let n_panes = panes.iter().max().unwrap() + 1;
        let mut n = DMatrix::zeros(n_panes, flat.coordinates.len());
        for (t, nodes) in flat.triangles.iter().enumerate() {
            for &node in nodes.iter().filter(|n| free[**n]) {
                n[(panes[t], node)] += flat.area(t) / 3.0;
            }
        }
        let mass: Vec<f64> = n.column_iter().map(|c| c.sum()).collect();
        let mut area = vec![0.0; n_panes];
        (0..panes.len()).for_each(|t| area[panes[t]] += flat.area(t));
        let scaled = DMatrix::from_fn(n_panes, mass.len(), |i, j| {
            if mass[j] > 0.0 {
                n[(i, j)] / (area[i] * mass[j]).sqrt()
            } else {
                0.0
            }
        });
        scaled.singular_values().min()
    }

    fn is_connected(flat: &Flat, members: &[usize]) -> bool {
        let edges = |t: usize| {
            let [a, b, c] = flat.triangles[t];
            [[a, b], [b, c], [c, a]].map(|[p, q]| [p.min(q), p.max(q)])
        };
        let mut reached = HashSet::from([members[0]]);
        let mut last = 0;
        while reached.len() > last {
            last = reached.len();
            let border: HashSet<_> = reached.iter().flat_map(|&t| edges(t)).collect();
            let more = members
                .iter()
                .filter(|t| edges(**t).iter().any(|e| border.contains(e)));
            reached.extend(more);
        }
        last == members.len()
    }

    /// Everything panes promise; gives the spread of their areas (largest over smallest).
    fn assert_sound(flat: &Flat, free: &[bool]) -> f64 {
        let panes = flat.build(|n| free[n]).expect("panes");
        assert_eq!(panes.len(), flat.triangles.len());
        let n_panes = panes.iter().max().unwrap() + 1;
        let mut bound = f64::INFINITY;
        let mut areas = Vec::new();
        for pane in 0..n_panes {
            let members: Vec<usize> = (0..panes.len()).filter(|&t| panes[t] == pane).collect();
            assert!(is_connected(flat, &members), "pane {pane} is torn");
            let star = largest_own_star(flat, &panes, pane, free);
            assert!(star > 0.0, "pane {pane} has no star of its own");
            areas.push(members.iter().map(|&t| flat.area(t)).sum::<f64>());
            bound = bound.min((star / (3.0 * areas[pane])).sqrt());
        }
        let smallest = smallest_singular_value(flat, &panes, free);
        // The bound is proven above the module; the singular values, at most 1, carry roundings.
        assert!(smallest > bound - 1e-12, "{smallest} < {bound}");
        areas.iter().copied().fold(0.0, f64::max) / areas.iter().copied().fold(f64::MAX, f64::min)
    }

    fn all_free(flat: &Flat) -> Vec<bool> {
        vec![true; flat.coordinates.len()]
    }

    const FOOT: &[u8] = include_bytes!("../../tests/meshes/foot_41.msh");
    const BRACKET: &[u8] = include_bytes!("../../tests/meshes/bracket_41.msh");

    #[test]
    fn panes_of_gmsh_faces_have_full_row_rank() {
        for sample in [FOOT, BRACKET] {
            let flat = Flat::of_sample(sample);
            let spread = assert_sound(&flat, &all_free(&flat));
            // Measured 1.65 and 1.87; at 2 a pane would be as large as two others.
            assert!(spread < 2.0, "{spread}");
        }
    }

    #[test]
    fn cubes_get_their_macro_faces_in_order() {
        for axes in [[0, 1], [0, 2], [1, 2]] {
            let (flat, macro_faces) = Flat::of_brick([0.1, 0.1], [6, 4], axes);
            assert_eq!(flat.build(|_| true).unwrap(), macro_faces, "{axes:?}");
        }
    }

    #[test]
    fn flattened_bricks_get_their_macro_faces() {
        /// Panes numbered as they first appear.
        fn renumbered(panes: &[usize]) -> Vec<usize> {
            let mut seen = Vec::new();
            let mut number = |pane: &usize| {
                seen.iter().position(|p| p == pane).unwrap_or_else(|| {
                    seen.push(*pane);
                    seen.len() - 1
                })
            };
            panes.iter().map(&mut number).collect()
        }
        for cell in [[0.5, 0.4], [0.3, 0.9], [1.0, 0.01]] {
            let (flat, macro_faces) = Flat::of_brick(cell, [6, 8], [0, 1]);
            let panes = flat.build(|_| true).unwrap();
            assert_eq!(renumbered(&panes), renumbered(&macro_faces), "{cell:?}");
        }
    }

    #[test]
    fn panes_do_not_depend_on_the_unit() {
        let uneven = Flat::uneven([9, 7], &[0.3, -0.8, 0.5, 0.1, -0.4], &[true, false, false]);
        let (regular, _) = Flat::of_brick([0.05, 0.05], [6, 4], [0, 1]);
        for flat in [uneven, regular, Flat::of_sample(FOOT)] {
            let panes = flat.build(|_| true).unwrap();
            for unit in [1e-3, 0.0254, 7e8] {
                let mut other = flat.clone();
                other
                    .coordinates
                    .as_flattened_mut()
                    .iter_mut()
                    .for_each(|x| *x *= unit);
                assert_eq!(other.build(|_| true).unwrap(), panes);
            }
        }
    }

    #[test]
    fn held_nodes_are_no_cores() {
        let (flat, _) = Flat::of_brick([1.0, 1.0], [6, 4], [0, 1]);
        let free: Vec<bool> = flat.coordinates.iter().map(|x| x[0] > 2.5).collect();
        assert_sound(&flat, &free);
    }

    #[test]
    fn faces_without_free_inner_nodes_are_refused() {
        let square = Flat::uneven([1, 1], &[0.0], &[true]);
        let error = square.build(|_| true).unwrap_err();
        assert!(error.found.contains("2 triangles"), "{error:?}");
        let (brick, _) = Flat::of_brick([0.25, 0.25], [4, 4], [0, 1]);
        let error = brick.build(|_| false).unwrap_err();
        assert!(error.help.contains("refine"), "{error:?}");
    }

    #[test]
    fn parts_without_free_inner_nodes_are_refused() {
        let (mut flat, _) = Flat::of_brick([0.25, 0.25], [4, 4], [0, 1]);
        let first = flat.coordinates.len();
        flat.coordinates
            .extend([[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 1.0, 0.0]]);
        flat.triangles.push([first, first + 1, first + 2]);
        let error = flat.build(|_| true).unwrap_err();
        assert!(error.found.starts_with("1 triangles"), "{error:?}");
    }

    proptest! {
        #[test]
        fn panes_of_uneven_faces_have_full_row_rank(
            cells in prop::array::uniform2(2..9_usize),
            shifts in prop::collection::vec(-1.0..1.0_f64, 50),
            diagonals in prop::collection::vec(any::<bool>(), 50),
        ) {
            let flat = Flat::uneven(cells, &shifts, &diagonals);
            assert_sound(&flat, &all_free(&flat));
        }
    }
}

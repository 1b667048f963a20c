//! Macro-patches of any triangulated face.

use std::collections::HashSet;

use contact3d::{
    mesh::{macro_elements, parse_gmsh, triangle_area},
    scene::InvalidValue,
};
use nalgebra::DMatrix;
use proptest::prelude::*;

/// A contact face on its own, all of its triangles in contact.
#[derive(Debug, Clone)]
struct Flat {
    coordinates: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
}

impl Flat {
    fn build(&self, is_free: impl Fn(usize) -> bool) -> Result<Vec<usize>, InvalidValue> {
        macro_elements(&self.coordinates, &self.triangles, &self.triangles, is_free)
    }

    fn area(&self, t: usize) -> f64 {
        triangle_area(&self.triangles[t].map(|n| self.coordinates[n]))
    }

    fn of_sample(bytes: &[u8]) -> Self {
        let mesh = parse_gmsh(bytes).expect("a sample");
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

const FOOT: &[u8] = include_bytes!("../../meshes/foot_41.msh");
const BRACKET: &[u8] = include_bytes!("../../meshes/bracket_41.msh");

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

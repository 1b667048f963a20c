//! The mesh of a box, five tetrahedra per cell (HKL §4, Fig. 4).

use super::{RawMesh, tetrahedron_volume};
use crate::scene::{Brick, BrickFace, ElementOrder};

/// The mesh of a box: every cell between its planes is five tetrahedra (HKL §4, Fig. 4).
///
/// The central tetrahedron of a cell joins its four even corners and each of the other four sits
/// at an odd corner, so every face diagonal joins even nodes and the mesh is conforming. A node
/// (i, j, k) is even when i + j + k + k_c is, where k_c is the grid index of the contact face;
/// so the centre (odd, odd) of every 2 × 2 macro-face of the contact face is even, and all eight
/// triangles of the pane meet there.
///
/// Nodes are numbered with i fastest, panes likewise along the in-plane axes.
#[must_use]
pub fn brick(spec: &Brick, contact_face: Option<BrickFace>) -> RawMesh {
    let grid = BrickGrid::new(spec, contact_face);
    let coordinates = grid.coordinates(spec);
    let tetrahedra = grid.tetrahedra(&coordinates);
    let (facets, facet_face) = grid.boundary(&tetrahedra);
    RawMesh {
        coordinates,
        tetrahedra,
        facets,
        facet_face,
        face_names: BrickFace::ALL.map(|face| face.word().to_owned()).to_vec(),
        ..RawMesh::default()
    }
}

/// Nodes, tetrahedra and boundary triangles of a brick; `None` where an index would overflow.
///
/// Quadratic tetrahedra have a node more on each edge; there are V + T + (boundary triangles)/2 − 1
/// edges by Euler's formula.
#[must_use]
pub fn brick_counts(spec: &Brick, element: ElementOrder) -> Option<[u64; 3]> {
    let [nx, ny, nz] = spec.cells.map(|cells| cells as u64);
    let product = |factors: [u64; 3]| factors.into_iter().try_fold(1, u64::checked_mul);
    let next = |cells: u64| cells.checked_add(1);
    let corners = product([next(nx)?, next(ny)?, next(nz)?])?;
    let tetrahedra = product([nx, ny, nz])?.checked_mul(5)?;
    let mut faces = [(nx, ny), (ny, nz), (nz, nx)].into_iter();
    let triangles = faces.try_fold(0_u64, |sum, (p, q)| sum.checked_add(product([4, p, q])?))?;
    let edges = || {
        corners
            .checked_add(tetrahedra)?
            .checked_add(triangles / 2 - 1)
    };
    let nodes = match element {
        ElementOrder::P1 => corners,
        ElementOrder::P2 => corners.checked_add(edges()?)?,
    };
    Some([nodes, tetrahedra, triangles])
}

/// The pane that each of some triangles on the contact face lies in: a square of cells.
#[must_use]
pub(super) fn panes(
    spec: &Brick,
    contact_face: BrickFace,
    cells_per_pane: usize,
    triangles: impl Iterator<Item = [usize; 3]>,
) -> Vec<usize> {
    let grid = BrickGrid::new(spec, Some(contact_face));
    triangles
        .map(|nodes| grid.pane(contact_face, cells_per_pane, &nodes))
        .collect()
}

struct BrickGrid {
    cells: [usize; 3],
    /// Grid index k_c of the contact face, which fixes the parity of nodes.
    shift: usize,
}

impl BrickGrid {
    fn new(spec: &Brick, contact_face: Option<BrickFace>) -> Self {
        let shift = contact_face
            .filter(|face| face.is_max())
            .map_or(0, |face| spec.cells[face.axis()]);
        Self {
            cells: spec.cells,
            shift,
        }
    }

    fn node(&self, [i, j, k]: [usize; 3]) -> usize {
        i + (self.cells[0] + 1) * (j + (self.cells[1] + 1) * k)
    }

    fn position(&self, node: usize) -> [usize; 3] {
        let (px, py) = (self.cells[0] + 1, self.cells[1] + 1);
        [node % px, node / px % py, node / (px * py)]
    }

    fn coordinates(&self, spec: &Brick) -> Vec<[f64; 3]> {
        let planes = [0, 1, 2].map(|axis| spec.planes(axis));
        let n_nodes = self.cells.iter().map(|c| c + 1).product();
        (0..n_nodes)
            .map(|node| {
                let at = self.position(node);
                std::array::from_fn(|axis| planes[axis][at[axis]])
            })
            .collect()
    }

    fn tetrahedra(&self, coordinates: &[[f64; 3]]) -> Vec<[usize; 4]> {
        let mut tetrahedra = Vec::with_capacity(5 * self.cells.iter().product::<usize>());
        for k in 0..self.cells[2] {
            for j in 0..self.cells[1] {
                for i in 0..self.cells[0] {
                    self.push_cell([i, j, k], coordinates, &mut tetrahedra);
                }
            }
        }
        tetrahedra
    }

    fn push_cell(&self, at: [usize; 3], coordinates: &[[f64; 3]], out: &mut Vec<[usize; 4]>) {
        let corner =
            |bits: usize| self.node(std::array::from_fn(|axis| at[axis] + (bits >> axis & 1)));
        let odd = |bits: usize| {
            (at.iter().sum::<usize>() + bits.count_ones() as usize + self.shift) % 2 == 1
        };
        let mut push = |mut nodes: [usize; 4]| {
            if tetrahedron_volume(&nodes.map(|n| coordinates[n])) < 0.0 {
                nodes.swap(2, 3);
            }
            out.push(nodes);
        };
        let even_corners: Vec<usize> = (0..8).filter(|&b| !odd(b)).map(corner).collect();
        push([
            even_corners[0],
            even_corners[1],
            even_corners[2],
            even_corners[3],
        ]);
        for bits in (0..8).filter(|&b| odd(b)) {
            push([
                corner(bits),
                corner(bits ^ 1),
                corner(bits ^ 2),
                corner(bits ^ 4),
            ]);
        }
    }

    /// The brick face that contains all three nodes, if any.
    fn face_of(&self, nodes: &[usize; 3]) -> Option<BrickFace> {
        let at = nodes.map(|n| self.position(n));
        BrickFace::ALL.into_iter().find(|face| {
            let axis = face.axis();
            let end = if face.is_max() { self.cells[axis] } else { 0 };
            at.iter().all(|p| p[axis] == end)
        })
    }

    fn boundary(&self, tetrahedra: &[[usize; 4]]) -> (Vec<[usize; 3]>, Vec<usize>) {
        tetrahedra
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, c, b], [a, b, d], [a, d, c], [b, c, d]])
            .filter_map(|facet| Some((facet, self.face_of(&facet)? as usize)))
            .unzip()
    }

    /// The square of cells that a contact triangle lies in.
    fn pane(&self, face: BrickFace, cells_per_pane: usize, nodes: &[usize; 3]) -> usize {
        let at = nodes.map(|n| self.position(n));
        let [p, q] = match face.axis() {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        };
        let least = |axis: usize| at.iter().map(|c| c[axis]).min().unwrap_or(0);
        let place = |axis: usize| least(axis) / cells_per_pane;
        place(p) + self.cells[p] / cells_per_pane * place(q)
    }
}

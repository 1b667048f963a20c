//! Balanced tractions whose stress comes closer to that of the solution.
//!
//! The error bound is the distance of the two stresses in the energy norm, ∫ (σ − C ε) : C⁻¹ (σ − C ε) = zᵀKz − 2 wᵀz + ∫ ε : C ε in the
//! data z of σ. It falls by exact minimisation over the forces on the sides around one edge after the other, subject to the balance of
//! force and moment of each tetrahedron, which keeps σ in equilibrium. Edges that share no tetrahedron are treated side by side.

use contact3d::{mesh::Mesh, reference::TETRAHEDRON_EDGES};
use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;

use super::{
    macro_stress::{Data, MacroElement, SIDE_DATA, Target},
    sides::{MeshSides, SideForces},
};

/// The minimisation.
pub(super) struct Descent<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) sides: &'a MeshSides,
    pub(super) elements: &'a [MacroElement],
    pub(super) target: &'a Target<'a>,
    /// f in N/m³.
    pub(super) body_force: Vector3<f64>,
    /// Components of forces that may change, `[n_sides]`.
    pub(super) is_free: &'a [[bool; 3]],
}

impl Descent<'_> {
    /// Sweeps over all edges until one lowers the distance by less than a hundredth, since bounds are read to two digits, to the data of
    /// the stress of each tetrahedron. Cubes need three sweeps; flat cells, across which forces pass slowly, take all twenty.
    pub(super) fn improve(&self, forces: &mut SideForces) -> Vec<Data> {
        let colours = self.colours();
        let elements = self.elements.par_iter().enumerate();
        let data =
            elements.map(|(t, element)| self.sides.data(t, element, forces, self.body_force));
        let mut data: Vec<Data> = data.collect();
        let mut distance = self.target.distance(&data);
        for _ in 0..20 {
            for colour in &colours {
                let edges = colour.par_iter();
                let changes = edges.map(|(around, sides)| self.changes(around, sides, &data));
                let changes: Vec<_> = changes.collect();
                for ((around, _), changes) in colour.iter().zip(changes) {
                    for ((side, place, component), by) in changes {
                        forces[side][place][component] += by;
                    }
                    for &t in around {
                        data[t] = self
                            .sides
                            .data(t, &self.elements[t], forces, self.body_force);
                    }
                }
            }
            let before = std::mem::replace(&mut distance, self.target.distance(&data));
            if distance.sqrt() > 0.99 * before.sqrt() {
                break;
            }
        }
        data
    }

    /// The edges in groups that share no tetrahedron: the tetrahedra around each and the sides that have it, both increasing.
    fn colours(&self) -> Vec<Vec<(Vec<usize>, Vec<usize>)>> {
        let mut seen: Vec<([usize; 2], usize, usize)> = Vec::new();
        for (t, corners) in self.mesh.tetrahedra.iter().enumerate() {
            for (k, [a, b]) in TETRAHEDRON_EDGES.into_iter().enumerate() {
                let [a, b] = [corners[a], corners[b]];
                seen.push(([a.min(b), a.max(b)], t, k));
            }
        }
        seen.sort_unstable();
        let mut taken: Vec<Vec<usize>> = vec![Vec::new(); self.mesh.tetrahedra.len()];
        let mut colours: Vec<Vec<(Vec<usize>, Vec<usize>)>> = Vec::new();
        for edge in seen.chunk_by(|a, b| a.0 == b.0) {
            let tetrahedra: Vec<usize> = edge.iter().map(|it| it.1).collect();
            let is_taken = |colour: &usize| tetrahedra.iter().any(|t| taken[*t].contains(colour));
            let colour = (0..colours.len())
                .find(|c| !is_taken(c))
                .unwrap_or(colours.len());
            tetrahedra.iter().for_each(|t| taken[*t].push(colour));
            let mut sides: Vec<usize> = Vec::new();
            for &(_, t, k) in edge {
                // The sides that have an edge are opposite to the corners that it has not.
                let away = (0..4).filter(|c| !TETRAHEDRON_EDGES[k].contains(c));
                sides.extend(away.map(|c| self.sides.of_tetrahedra[t][c].side));
            }
            sides.sort_unstable();
            sides.dedup();
            if colour == colours.len() {
                colours.push(Vec::new());
            }
            colours[colour].push((tetrahedra, sides));
        }
        colours
    }

    /// The best changes in N of the forces around an edge by side, place of the corner and component; none where rounding leaves none.
    fn changes(
        &self,
        around: &[usize],
        sides: &[usize],
        data: &[Data],
    ) -> Vec<((usize, usize, usize), f64)> {
        let free = |side: usize| {
            let places = (0..3).flat_map(move |place| (0..3).map(move |c| (side, place, c)));
            places.filter(|(side, _, c)| self.is_free[*side][*c])
        };
        let unknowns: Vec<(usize, usize, usize)> =
            sides.iter().flat_map(|side| free(*side)).collect();
        let mut hessian = DMatrix::zeros(unknowns.len(), unknowns.len());
        let mut slope = DVector::zeros(unknowns.len());
        let mut balance = DMatrix::zeros(6 * around.len(), unknowns.len());
        for (row, &t) in around.iter().enumerate() {
            self.add_energy(t, &unknowns, data, &mut hessian, &mut slope);
            self.add_balance(t, &unknowns, balance.rows_mut(6 * row, 6));
        }
        let space = null_space(balance);
        let reduced = space.transpose() * hessian * &space;
        let Some(reduced) = reduced.cholesky() else {
            return Vec::new();
        };
        let best = &space * reduced.solve(&(space.transpose() * -slope));
        unknowns.into_iter().zip(best.iter().copied()).collect()
    }

    /// Adds the energy of a tetrahedron in the unknown forces: its second derivative over 2 and its slope over 2.
    fn add_energy(
        &self,
        t: usize,
        unknowns: &[(usize, usize, usize)],
        data: &[Data],
        hessian: &mut DMatrix<f64>,
        slope: &mut DVector<f64>,
    ) {
        let element = &self.elements[t];
        let mut rows = Vec::new();
        let mut columns = Vec::new();
        for (k, seen) in self.sides.of_tetrahedra[t].iter().enumerate() {
            for (corner, place) in seen.places.into_iter().enumerate() {
                let own = unknowns.iter().enumerate();
                let own = own.filter(|(_, it)| (it.0, it.1) == (seen.side, place));
                let mut is_moved = false;
                for (column, (_, _, c)) in own {
                    columns.push((column, rows.len(), element.inverse.column(*c) * seen.sign));
                    is_moved = true;
                }
                if is_moved {
                    rows.extend((0..3).map(|c| k * SIDE_DATA + corner * 3 + c));
                }
            }
        }
        let energy = element.energy(&rows);
        let rest =
            &energy * data[t] - DVector::from_fn(rows.len(), |i, _| self.target.work[t][rows[i]]);
        let among = energy.select_columns(&rows);
        for (i, row, by) in &columns {
            slope[*i] += rest.fixed_rows::<3>(*row).dot(by);
            for (j, column, other) in &columns {
                let block = among.fixed_view::<3, 3>(*row, *column);
                hessian[(*i, *j)] += by.dot(&(block * other));
            }
        }
    }

    /// Writes what the unknown forces do to the balance of force and, over the size of the tetrahedron, moment.
    fn add_balance(
        &self,
        t: usize,
        unknowns: &[(usize, usize, usize)],
        mut rows: nalgebra::DMatrixViewMut<'_, f64>,
    ) {
        let corners = self
            .mesh
            .corners(&self.mesh.tetrahedra[t])
            .map(Vector3::from);
        let centre: Vector3<f64> = corners.iter().sum::<Vector3<f64>>() / 4.0;
        let size = corners
            .iter()
            .map(|x| (x - centre).norm())
            .fold(0.0, f64::max);
        for (column, &(side, place, c)) in unknowns.iter().enumerate() {
            let seen = self.sides.of_tetrahedra[t]
                .iter()
                .find(|it| it.side == side);
            let Some(seen) = seen else { continue };
            let node = self.sides.sides[side].nodes[place];
            let arm = (Vector3::from(self.mesh.coordinates[node]) - centre) / size;
            let mut force = Vector3::zeros();
            force[c] = seen.sign;
            rows.fixed_view_mut::<3, 1>(0, column).copy_from(&force);
            rows.fixed_view_mut::<3, 1>(3, column)
                .copy_from(&arm.cross(&force));
        }
    }
}

/// A basis of the null space of a matrix, as columns, by elimination with complete pivoting.
fn null_space(mut matrix: DMatrix<f64>) -> DMatrix<f64> {
    let (n_rows, n) = matrix.shape();
    let mut order: Vec<usize> = (0..n).collect();
    let mut rank = 0;
    let mut first = 0.0;
    while rank < n_rows.min(n) {
        let rest = matrix.view((rank, rank), (n_rows - rank, n - rank));
        let (i, j) = rest.iamax_full();
        let pivot = rest[(i, j)].abs();
        first = f64::max(first, pivot);
        // Entries are ratios of lengths in a tetrahedron, or 1; so small a pivot is of an equation that follows from others.
        if pivot <= 1e-9 * first {
            break;
        }
        matrix.swap_rows(rank, rank + i);
        matrix.swap_columns(rank, rank + j);
        order.swap(rank, rank + j);
        let row = matrix.row(rank) / matrix[(rank, rank)];
        matrix.set_row(rank, &row);
        for other in (0..n_rows).filter(|other| *other != rank) {
            let factor = matrix[(other, rank)];
            if factor != 0.0 {
                for column in rank..n {
                    matrix[(other, column)] -= factor * row[column];
                }
            }
        }
        rank += 1;
    }
    let mut space = DMatrix::zeros(n, n - rank);
    for (k, column) in (rank..n).enumerate() {
        space[(order[column], k)] = 1.0;
        for row in 0..rank {
            space[(order[row], k)] = -matrix[(row, column)];
        }
    }
    space
}

//! Tractions between tetrahedra that are in equilibrium with the loads.
//!
//! Around a corner a with hat function λ_a the forces r = ∫ λ_a σν of the sides balance each tetrahedron: Σ ± r = ∫ σ_h ∇λ_a − ∫ f λ_a.
//! Since u_h is a Galerkin solution, these equations have solutions; taken is the one closest to the mean of σ_h on both sides, with
//! weights V/|F|² that measure its energy (P. Ladevèze, D. Leguillon, SIAM J. Numer. Anal. 20 (1983) 485).

use contact3d::{
    elasticity::{Simplex, traction},
    mesh::{Mesh, tetrahedron_volume},
};
use nalgebra::{DMatrix, DVector, Vector3, Vector6};
use rayon::prelude::*;

use super::sides::{MeshSides, SideForces};

/// Stress and loads that tractions are made for.
pub(super) struct Balanced<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) sides: &'a MeshSides,
    /// Stress in Pa at the corners of each tetrahedron, between which it is linear.
    pub(super) stress: &'a [[Vector6<f64>; 4]],
    /// f in N/m³.
    pub(super) body_force: Vector3<f64>,
    /// Traction in Pa on the boundary sides, `[n_sides]`.
    pub(super) traction: &'a [Vector3<f64>],
    /// Components whose traction is unknown, `[n_sides]`: all inside the body, those that are held on its boundary.
    pub(super) is_free: &'a [[bool; 3]],
}

impl Balanced<'_> {
    /// The forces; `None` where none balance what acts around a corner, such as reactions of points.
    pub(super) fn forces(&self) -> Option<SideForces> {
        let mut forces: SideForces = (0..self.sides.sides.len()).map(|s| self.mean(s)).collect();
        let n_corners = self
            .mesh
            .tetrahedra
            .iter()
            .flatten()
            .max()
            .map_or(0, |n| n + 1);
        let mut around: Vec<Vec<(usize, usize)>> = vec![Vec::new(); n_corners];
        for (t, corners) in self.mesh.tetrahedra.iter().enumerate() {
            for (k, &node) in corners.iter().enumerate() {
                around[node].push((t, k));
            }
        }
        let corners = around.par_iter().enumerate();
        let found = corners.map(|(node, star)| self.around(node, star, &forces));
        let found = found.collect::<Option<Vec<_>>>()?;
        let size = |force: &Vector3<f64>| force.amax();
        let largest = forces.iter().flatten().map(size).fold(0.0, f64::max);
        // Rounding and the residual of the linear solve stay below 1e-12; reactions of held points are of the size of the loads.
        if found.iter().any(|(_, missing)| *missing > 1e-8 * largest) {
            return None;
        }
        for (side, place, force) in found.into_iter().flat_map(|(changes, _)| changes) {
            forces[side][place] += force;
        }
        Some(forces)
    }

    /// The moments of the mean traction of both sides, or of that on the boundary.
    fn mean(&self, side: usize) -> [Vector3<f64>; 3] {
        let it = &self.sides.sides[side];
        let area = it.area.norm();
        let normal = it.area / area;
        let of = |t: usize| -> [Vector3<f64>; 3] {
            let corners = &self.mesh.tetrahedra[t];
            it.nodes.map(|node| {
                let corner = corners.iter().position(|n| *n == node).unwrap_or(0);
                traction(&normal, &self.stress[t][corner])
            })
        };
        let inside = of(it.inside);
        let mut nodal = match it.outside {
            Some(outside) => {
                let outside = of(outside);
                std::array::from_fn(|k| (inside[k] + outside[k]) / 2.0)
            }
            None => inside,
        };
        for c in (0..3).filter(|c| !self.is_free[side][*c]) {
            nodal.iter_mut().for_each(|t| t[c] = self.traction[side][c]);
        }
        let sum: Vector3<f64> = nodal.iter().sum();
        nodal.map(|traction| (traction + sum) * (area / 12.0))
    }

    /// What balances the tetrahedra around a corner, by side and place of the corner, and what is missing then, in N.
    fn around(
        &self,
        node: usize,
        star: &[(usize, usize)],
        forces: &SideForces,
    ) -> Option<(Vec<Change>, f64)> {
        let mut seen: Vec<usize> = Vec::new();
        for &(t, corner) in star {
            let own = self.sides.of_tetrahedra[t].iter().enumerate();
            seen.extend(own.filter(|(k, _)| *k != corner).map(|(_, side)| side.side));
        }
        seen.sort_unstable();
        seen.dedup();
        let place = |side: usize| {
            let nodes = &self.sides.sides[side].nodes;
            nodes.iter().position(|n| *n == node).unwrap_or(0)
        };
        let unchanged = |&side: &usize| (side, place(side), Vector3::zeros());
        let mut changes: Vec<_> = seen.iter().map(unchanged).collect();
        let mut imbalance = 0.0_f64;
        for c in 0..3 {
            let mut missing = DVector::zeros(star.len());
            let mut incidence = DMatrix::zeros(star.len(), seen.len());
            for (row, &(t, corner)) in star.iter().enumerate() {
                missing[row] = self.needed(t, corner)[c];
                for (k, side) in self.sides.of_tetrahedra[t].iter().enumerate() {
                    if k == corner {
                        continue;
                    }
                    let column = seen.partition_point(|s| *s < side.side);
                    let force = forces[side.side][changes[column].1][c];
                    missing[row] -= side.sign * force;
                    if self.is_free[side.side][c] {
                        incidence[(row, column)] = side.sign;
                    }
                }
            }
            let weights =
                DVector::from_iterator(seen.len(), seen.iter().map(|&side| self.weight(side)));
            let found = least_change(&incidence, &weights, &missing)?;
            let rest = &incidence * &found - &missing;
            imbalance = imbalance.max(rest.amax());
            for (change, force) in changes.iter_mut().zip(found.iter()) {
                change.2[c] = *force;
            }
        }
        Some((changes, imbalance))
    }

    /// ∫ σ_h ∇λ_a − ∫ f λ_a in N.
    fn needed(&self, t: usize, corner: usize) -> Vector3<f64> {
        let corners = self.mesh.corners(&self.mesh.tetrahedra[t]);
        let simplex = Simplex::new(&corners);
        let mean = self.stress[t].iter().sum::<Vector6<f64>>() / 4.0;
        let stress = traction(&simplex.gradients[corner], &mean);
        (stress - self.body_force / 4.0) * simplex.volume
    }

    /// |F|²/V: the inverse of what a unit force on a side costs.
    fn weight(&self, side: usize) -> f64 {
        let it = &self.sides.sides[side];
        let volume = |t: usize| tetrahedron_volume(&self.mesh.corners(&self.mesh.tetrahedra[t]));
        let volumes = [Some(it.inside), it.outside].into_iter().flatten();
        it.area.norm_squared() / volumes.map(volume).sum::<f64>()
    }
}

/// A side, the place of a corner, and what its force changes by in N.
type Change = (usize, usize, Vector3<f64>);

/// The x that minimises Σ x²/w subject to B x = b, or comes closest; `None` where rounding leaves none.
fn least_change(
    incidence: &DMatrix<f64>,
    weights: &DVector<f64>,
    missing: &DVector<f64>,
) -> Option<DVector<f64>> {
    let weighted = incidence * DMatrix::from_diagonal(weights);
    let mut laplacian = &weighted * incidence.transpose();
    let spring = weights.amax();
    for row in unsupported(incidence) {
        laplacian[(row, row)] += spring;
    }
    let y = laplacian.cholesky()?.solve(missing);
    Some(weighted.transpose() * y)
}

/// One tetrahedron of each group that is joined by free sides and has none on the boundary: its balance follows from the others'.
fn unsupported(incidence: &DMatrix<f64>) -> Vec<usize> {
    let n = incidence.nrows();
    let mut group: Vec<usize> = (0..n).collect();
    let mut is_supported = vec![false; n];
    for column in incidence.column_iter() {
        let mut rows = (0..n).filter(|row| column[*row] != 0.0);
        match (rows.next(), rows.next()) {
            (Some(a), Some(b)) => {
                let (kept, joined) = (group[a], group[b]);
                group
                    .iter_mut()
                    .filter(|g| **g == joined)
                    .for_each(|g| *g = kept);
            }
            (Some(a), None) => is_supported[a] = true,
            (None, _) => {}
        }
    }
    let stands = |first: usize| (0..n).any(|row| group[row] == first && is_supported[row]);
    (0..n)
        .filter(|&row| group[row] == row && !stands(row))
        .collect()
}

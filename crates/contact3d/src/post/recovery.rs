//! A smoother stress from that of linear tetrahedra.
//!
//! Superconvergent patch recovery (O. Zienkiewicz, J. Zhu, Int. J. Numer. Methods Eng. 33 (1992)
//! 1331): around each node inside a material a linear polynomial is fitted to the stresses at the
//! centroids of its tetrahedra; its value is the node's stress. Nodes on the boundary of a material,
//! around which there is too little to fit, take the mean of what the polynomials of their neighbours
//! say at their place.

use nalgebra::{Cholesky, Const, Matrix4, SMatrix, Vector3, Vector4, Vector6};
use rayon::prelude::*;

use crate::{
    elasticity::InternalForces,
    mesh::{GEOMETRY_TOLERANCE, MaterialNodes, Mesh, tetrahedron_volume},
    reference::TETRAHEDRON_EDGES,
};

/// What the recovery of stresses needs of a mesh, made once for all solutions on it.
pub(crate) struct StressRecovery {
    /// Where stresses are recovered.
    pub(super) nodes: MaterialNodes,
    /// Of the tetrahedra in m, `[n_tetrahedra]`.
    centroids: Vec<Vector3<f64>>,
    /// Of the tetrahedra in m³, `[n_tetrahedra]`.
    volumes: Vec<f64>,
    /// The tetrahedra around each row of `nodes`, increasing, `[n_material_nodes]`; mid-edge nodes have none.
    stars: Vec<Vec<usize>>,
    /// The factor of the least-squares problem about each row, in lengths over the given one in m; `None` on the boundary of a material, and
    /// where the points do not determine a polynomial.
    fits: Vec<Option<(Cholesky<f64, Const<4>>, f64)>>,
}

impl StressRecovery {
    /// That of a mesh.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let nodes = MaterialNodes::new(mesh);
        let corners = mesh.tetrahedra.iter().map(|corners| mesh.corners(corners));
        let middle =
            |corners: [[f64; 3]; 4]| corners.map(Vector3::from).iter().sum::<Vector3<f64>>() / 4.0;
        let mut recovery = Self {
            centroids: corners.clone().map(middle).collect(),
            volumes: corners
                .map(|corners| tetrahedron_volume(&corners))
                .collect(),
            stars: Vec::new(),
            fits: Vec::new(),
            nodes,
        };
        if mesh.mid_edges.is_none() {
            recovery.add_fits(mesh);
        }
        recovery
    }

    fn add_fits(&mut self, mesh: &Mesh) {
        let nodes = &self.nodes;
        self.stars = vec![Vec::new(); nodes.nodes.len()];
        for t in 0..mesh.tetrahedra.len() {
            for &row in &nodes.of_tetrahedron(t)[..4] {
                self.stars[row].push(t);
            }
        }
        let is_inside = inside_materials(mesh, nodes);
        let rows = (0..nodes.nodes.len()).into_par_iter();
        let fits = rows.map(|row| is_inside[nodes.nodes[row]].then(|| self.fit(mesh, row))?);
        self.fits = fits.collect();
    }

    /// From the place of a row to the centroids around it in m.
    fn arms(&self, mesh: &Mesh, row: usize) -> impl Iterator<Item = (usize, Vector3<f64>)> {
        let origin = Vector3::from(mesh.coordinates[self.nodes.nodes[row]]);
        let star = self.stars[row].iter();
        star.map(move |&t| (t, self.centroids[t] - origin))
    }

    fn fit(&self, mesh: &Mesh, row: usize) -> Option<(Cholesky<f64, Const<4>>, f64)> {
        let lengths = self.arms(mesh, row).map(|(_, arm)| arm.norm());
        let size = lengths.fold(0.0, f64::max);
        let mut gram = Matrix4::zeros();
        for (t, arm) in self.arms(mesh, row) {
            let terms = terms(&arm, size);
            gram += terms * terms.transpose() * self.volumes[t];
        }
        let factor = gram.cholesky()?;
        // Points in a plane do not determine a polynomial.
        let pivots = factor.l_dirty().diagonal();
        (pivots.min().powi(2) > GEOMETRY_TOLERANCE * gram.trace()).then_some((factor, size))
    }

    /// The polynomial about a row, weighted by volume: value and slopes of the six components of a stress in Pa.
    fn polynomial(
        &self,
        mesh: &Mesh,
        row: usize,
        stress: &[[f64; 6]],
    ) -> Option<SMatrix<f64, 4, 6>> {
        let (factor, size) = self.fits[row].as_ref()?;
        let mut right = SMatrix::<f64, 4, 6>::zeros();
        for (t, arm) in self.arms(mesh, row) {
            right += terms(&arm, *size) * Vector6::from(stress[t]).transpose() * self.volumes[t];
        }
        factor.solve_mut(&mut right);
        right.rows_mut(1, 3).unscale_mut(*size);
        Some(right)
    }

    /// The stress in Pa at each row, `[n_material_nodes]`, of linear tetrahedra with these, `[n_tetrahedra]`.
    pub(super) fn recovered(&self, mesh: &Mesh, stress: &[[f64; 6]]) -> Vec<[f64; 6]> {
        let rows = (0..self.nodes.nodes.len()).into_par_iter();
        let polynomials = rows.clone().map(|row| self.polynomial(mesh, row, stress));
        let polynomials: Vec<_> = polynomials.collect();
        let at_row = |row: usize| match &polynomials[row] {
            Some(polynomial) => polynomial.row(0).transpose().into(),
            None => self.on_boundary(mesh, row, stress, &polynomials).into(),
        };
        rows.map(at_row).collect()
    }

    /// The mean of the polynomials around a row at its place; of the stresses of its tetrahedra where there are none.
    fn on_boundary(
        &self,
        mesh: &Mesh,
        row: usize,
        stress: &[[f64; 6]],
        polynomials: &[Option<SMatrix<f64, 4, 6>>],
    ) -> Vector6<f64> {
        let star = &self.stars[row];
        let rows = star
            .iter()
            .flat_map(|&t| &self.nodes.of_tetrahedron(t)[..4]);
        let mut around: Vec<usize> = rows.copied().collect();
        around.sort_unstable_by_key(|&other| self.nodes.nodes[other]);
        around.dedup();
        let place = |row: usize| Vector3::from(mesh.coordinates[self.nodes.nodes[row]]);
        let about = |&other: &usize| {
            let arm = place(row) - place(other);
            Some(polynomials[other].as_ref()?.transpose() * terms(&arm, 1.0))
        };
        let values: Vec<Vector6<f64>> = around.iter().filter_map(about).collect();
        if values.is_empty() {
            let whole: f64 = star.iter().map(|&t| self.volumes[t]).sum();
            let parts = star
                .iter()
                .map(|&t| Vector6::from(stress[t]) * self.volumes[t]);
            return parts.sum::<Vector6<f64>>() / whole;
        }
        values.iter().sum::<Vector6<f64>>() / values.len() as f64
    }

    /// The stresses of a displacement at the nodes of each material, `[n_material_nodes]`, in Pa.
    pub(super) fn nodal_stress(&self, mesh: &Mesh, internal: &InternalForces) -> Vec<[f64; 6]> {
        match mesh.mid_edges {
            Some(_) => self.averaged(&internal.corner_stress),
            None => self.recovered(mesh, &internal.stress),
        }
    }

    /// Means of the stresses of quadratic tetrahedra at their nodes, which are linear between the corners.
    fn averaged(&self, corner_stress: &[[[f64; 6]; 4]]) -> Vec<[f64; 6]> {
        let mut sums = vec![(Vector6::zeros(), 0.0); self.nodes.nodes.len()];
        for (t, (corners, volume)) in corner_stress.iter().zip(&self.volumes).enumerate() {
            let corners = corners.map(Vector6::from);
            let middles = TETRAHEDRON_EDGES.map(|[a, b]| (corners[a] + corners[b]) / 2.0);
            for (&row, stress) in self
                .nodes
                .of_tetrahedron(t)
                .iter()
                .zip(corners.into_iter().chain(middles))
            {
                sums[row].0 += stress * *volume;
                sums[row].1 += volume;
            }
        }
        let means = sums.into_iter().map(|(sum, volume)| (sum / volume).into());
        means.collect()
    }
}

/// The terms of a linear polynomial at a place, in lengths over a size.
fn terms(arm: &Vector3<f64>, size: f64) -> Vector4<f64> {
    Vector4::new(1.0, arm.x / size, arm.y / size, arm.z / size)
}

/// Whether each node is inside a material: on no side that only one tetrahedron of it has, `[n_nodes]`.
fn inside_materials(mesh: &Mesh, nodes: &MaterialNodes) -> Vec<bool> {
    let mut is_inside = vec![true; mesh.coordinates.len()];
    let between_materials = &nodes.nodes[is_inside.len()..];
    for &node in mesh.facets.as_flattened().iter().chain(between_materials) {
        is_inside[node] = false;
    }
    is_inside
}

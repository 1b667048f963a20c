//! A smoother stress from that of linear tetrahedra.
//!
//! Superconvergent patch recovery (O. Zienkiewicz, J. Zhu, Int. J. Numer. Methods Eng. 33 (1992)
//! 1331): around each node inside a material a linear polynomial is fitted to the stresses at the
//! centroids of its tetrahedra; its value is the node's stress. Nodes on the boundary of a material,
//! around which there is too little to fit, take the mean of what the polynomials of their neighbours
//! say at their place.

use nalgebra::{Matrix4, SMatrix, Vector3, Vector4, Vector6};
use rayon::prelude::*;

use crate::mesh::{GEOMETRY_TOLERANCE, MaterialNodes, Mesh, tetrahedron_volume};

/// The recovered stresses of several fields.
pub(super) struct RecoveredStress<'a> {
    mesh: &'a Mesh,
    nodes: &'a MaterialNodes,
    /// Stresses of the tetrahedra in Pa, `[n_fields][n_tetrahedra]`.
    stresses: &'a [&'a [[f64; 6]]],
    /// Where the tetrahedra around each row of `nodes` begin and end in `star`, `[n_material_nodes + 1]`; mid-edge nodes have none.
    offsets: Vec<usize>,
    star: Vec<usize>,
    /// Linear polynomials of all fields about each row, value and slopes of the six components of stress; `None` on the boundary of a material, and where the points do not determine them.
    fits: Vec<Option<Vec<SMatrix<f64, 4, 6>>>>,
}

impl<'a> RecoveredStress<'a> {
    /// Fits the polynomials.
    pub(super) fn new(
        mesh: &'a Mesh,
        nodes: &'a MaterialNodes,
        stresses: &'a [&'a [[f64; 6]]],
    ) -> Self {
        let corners = |t: usize| &nodes.of_tetrahedron(t)[..4];
        let mut offsets = vec![0; nodes.nodes.len() + 1];
        for &row in (0..mesh.tetrahedra.len()).flat_map(corners) {
            offsets[row + 1] += 1;
        }
        for row in 0..nodes.nodes.len() {
            offsets[row + 1] += offsets[row];
        }
        let mut next = offsets.clone();
        let mut star = vec![0; 4 * mesh.tetrahedra.len()];
        for t in 0..mesh.tetrahedra.len() {
            for &row in corners(t) {
                star[next[row]] = t;
                next[row] += 1;
            }
        }
        let mut recovered = Self {
            mesh,
            nodes,
            stresses,
            offsets,
            star,
            fits: Vec::new(),
        };
        let is_inside = inside_materials(mesh, nodes);
        let rows = (0..nodes.nodes.len()).into_par_iter();
        recovered.fits = rows
            .map(|row| {
                let (node, star) = (nodes.nodes[row], recovered.star(row));
                let is_fitted = !star.is_empty() && is_inside[node];
                is_fitted.then(|| fit(mesh, node, star, stresses))?
            })
            .collect();
        recovered
    }

    /// The tetrahedra around a row, increasing.
    fn star(&self, row: usize) -> &[usize] {
        &self.star[self.offsets[row]..self.offsets[row + 1]]
    }

    /// The stresses of all fields at a row in Pa.
    pub(super) fn at(&self, row: usize) -> Vec<Vector6<f64>> {
        if let Some(fits) = &self.fits[row] {
            return fits.iter().map(|fit| fit.row(0).transpose()).collect();
        }
        let star = self.star(row);
        let place = |row: usize| Vector3::from(self.mesh.coordinates[self.nodes.nodes[row]]);
        let rows = star
            .iter()
            .flat_map(|&t| &self.nodes.of_tetrahedron(t)[..4]);
        let mut around: Vec<usize> = rows.copied().collect();
        around.sort_unstable_by_key(|&other| self.nodes.nodes[other]);
        around.dedup();
        let about = |&other: &usize| {
            let arm = place(row) - place(other);
            let fits = self.fits[other].as_ref()?;
            Some((Vector4::new(1.0, arm.x, arm.y, arm.z), fits.as_slice()))
        };
        let fitted: Vec<(Vector4<f64>, &[SMatrix<f64, 4, 6>])> =
            around.iter().filter_map(about).collect();
        let volume = |t: usize| tetrahedron_volume(&self.mesh.corners(&self.mesh.tetrahedra[t]));
        let whole: f64 = star.iter().map(|&t| volume(t)).sum();
        let of_field = |(field, stress): (usize, &&[[f64; 6]])| -> Vector6<f64> {
            if fitted.is_empty() {
                let parts = star.iter().map(|&t| Vector6::from(stress[t]) * volume(t));
                return parts.sum::<Vector6<f64>>() / whole;
            }
            let values = fitted
                .iter()
                .map(|(row, fits)| fits[field].transpose() * row);
            values.sum::<Vector6<f64>>() / fitted.len() as f64
        };
        self.stresses.iter().enumerate().map(of_field).collect()
    }
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

fn centroid(mesh: &Mesh, t: usize) -> Vector3<f64> {
    let corners = mesh.corners(&mesh.tetrahedra[t]).map(Vector3::from);
    corners.iter().sum::<Vector3<f64>>() / 4.0
}

/// The least-squares polynomials of all fields around a node, weighted by volume; `None` where the points do not determine
/// them.
fn fit(
    mesh: &Mesh,
    node: usize,
    star: &[usize],
    stresses: &[&[[f64; 6]]],
) -> Option<Vec<SMatrix<f64, 4, 6>>> {
    let origin = Vector3::from(mesh.coordinates[node]);
    let arms: Vec<Vector3<f64>> = star.iter().map(|&t| centroid(mesh, t) - origin).collect();
    let size = arms.iter().map(Vector3::norm).fold(0.0, f64::max);
    let mut gram = Matrix4::zeros();
    let mut rights = vec![SMatrix::zeros(); stresses.len()];
    for (&t, arm) in star.iter().zip(&arms) {
        let volume = tetrahedron_volume(&mesh.corners(&mesh.tetrahedra[t]));
        let row = Vector4::new(1.0, arm.x / size, arm.y / size, arm.z / size);
        gram += row * row.transpose() * volume;
        for (right, stress) in rights.iter_mut().zip(stresses) {
            *right += row * Vector6::from(stress[t]).transpose() * volume;
        }
    }
    let factor = gram.cholesky()?;
    // Points in a plane do not determine a polynomial.
    let pivots = factor.l_dirty().diagonal();
    if pivots.min().powi(2) <= GEOMETRY_TOLERANCE * gram.trace() {
        return None;
    }
    for right in &mut rights {
        factor.solve_mut(right);
        right.rows_mut(1, 3).unscale_mut(size);
    }
    Some(rights)
}

//! A smoother stress from that of linear tetrahedra, and how far the two are apart.
//!
//! Superconvergent patch recovery (O. Zienkiewicz, J. Zhu, Int. J. Numer. Methods Eng. 33 (1992)
//! 1331): around each node inside a material a linear polynomial is fitted to the stresses at the
//! centroids of its tetrahedra; its value is the node's stress. Nodes on the boundary of a material,
//! around which there is too little to fit, take the mean of what the polynomials of their neighbours
//! say at their place.

use nalgebra::{Matrix4, SMatrix, Vector3, Vector4, Vector6};
use rayon::prelude::*;

use super::Field;
use crate::{
    elasticity::MaterialField,
    mesh::{GEOMETRY_TOLERANCE, Mesh, tetrahedron_volume},
    reference::quadrature,
};

/// A linear polynomial for the six components of stress: value and slopes about a node.
type StressPolynomial = SMatrix<f64, 4, 6>;

/// The tetrahedra of each material around each node.
struct Stars {
    /// Node and region of each star, increasing.
    places: Vec<(usize, usize)>,
    /// Where the tetrahedra of each star begin and end, `[n_stars + 1]`.
    offsets: Vec<usize>,
    /// Tetrahedra, increasing in each star.
    tetrahedra: Vec<usize>,
    /// The first star of each node, `[n_nodes + 1]`.
    first: Vec<usize>,
}

impl Stars {
    fn new(mesh: &Mesh, material: &MaterialField<'_>) -> Self {
        let mut corners: Vec<(usize, usize, usize)> = mesh
            .tetrahedra
            .iter()
            .enumerate()
            .flat_map(|(t, nodes)| nodes.map(|node| (node, material.region(t), t)))
            .collect();
        corners.par_sort_unstable();
        let mut stars = Self {
            places: Vec::new(),
            offsets: vec![0],
            tetrahedra: corners.iter().map(|corner| corner.2).collect(),
            first: Vec::with_capacity(mesh.coordinates.len() + 1),
        };
        for star in corners.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (node, region, _) = star[0];
            // Nodes in the middle of edges have no star.
            stars.first.resize(node + 1, stars.places.len());
            stars.places.push((node, region));
            stars
                .offsets
                .push(stars.offsets[stars.offsets.len() - 1] + star.len());
        }
        stars
            .first
            .resize(mesh.coordinates.len() + 1, stars.places.len());
        stars
    }

    fn of(&self, star: usize) -> &[usize] {
        &self.tetrahedra[self.offsets[star]..self.offsets[star + 1]]
    }

    /// The star of a node in a region; `None` where the node has no tetrahedron of it.
    fn find(&self, (node, region): (usize, usize)) -> Option<usize> {
        let stars = self.first[node]..self.first[node + 1];
        let found = self.places[stars.clone()]
            .iter()
            .position(|place| place.1 == region);
        found.map(|k| stars.start + k)
    }
}

/// The recovered stresses of several fields at the corners of every tetrahedron in Pa, `[n_fields][n_tetrahedra]`.
fn recovered(
    mesh: &Mesh,
    material: &MaterialField<'_>,
    stresses: &[&[[f64; 6]]],
) -> Vec<Vec<[Vector6<f64>; 4]>> {
    let stars = Stars::new(mesh, material);
    let fits: Vec<Option<Vec<StressPolynomial>>> = (0..stars.places.len())
        .into_par_iter()
        .map(|k| {
            let (node, star) = (stars.places[k].0, stars.of(k));
            is_inside(mesh, node, star).then(|| fit(mesh, node, star, stresses))?
        })
        .collect();
    let values: Vec<Vec<Vector6<f64>>> = (0..stars.places.len())
        .into_par_iter()
        .map(|k| values(mesh, &stars, k, stresses, &fits))
        .collect();
    let at_corner = |t: usize, node: usize| -> &[Vector6<f64>] {
        let star = stars.find((node, material.region(t)));
        &values[star.expect("a tetrahedron is in the stars of its corners")]
    };
    let of_field = |field: usize| -> Vec<[Vector6<f64>; 4]> {
        let corners = mesh.tetrahedra.par_iter().enumerate();
        corners
            .map(|(t, nodes)| nodes.map(|node| at_corner(t, node)[field]))
            .collect()
    };
    (0..stresses.len()).map(of_field).collect()
}

/// Whether a node is inside its material: not on a side that only one tetrahedron of it has.
fn is_inside(mesh: &Mesh, node: usize, star: &[usize]) -> bool {
    let mut sides: Vec<[usize; 2]> = star
        .iter()
        .flat_map(|&t| {
            let nodes = mesh.tetrahedra[t];
            let at = nodes.iter().position(|n| *n == node).unwrap_or(0);
            let mut others = [1, 2, 3].map(|k| nodes[(at + k) % 4]);
            others.sort_unstable();
            let [a, b, c] = others;
            [[a, b], [a, c], [b, c]]
        })
        .collect();
    sides.sort_unstable();
    sides.chunk_by(|a, b| a == b).all(|same| same.len() == 2)
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
) -> Option<Vec<StressPolynomial>> {
    let origin = Vector3::from(mesh.coordinates[node]);
    let arms: Vec<Vector3<f64>> = star.iter().map(|&t| centroid(mesh, t) - origin).collect();
    let size = arms.iter().map(Vector3::norm).fold(0.0, f64::max);
    let mut gram = Matrix4::zeros();
    let mut rights = vec![StressPolynomial::zeros(); stresses.len()];
    for (&t, arm) in star.iter().zip(&arms) {
        let volume = tetrahedron_volume(&mesh.corners(&mesh.tetrahedra[t]));
        let row = Vector4::new(1.0, arm.x / size, arm.y / size, arm.z / size);
        gram += row * row.transpose() * volume;
        for (right, stress) in rights.iter_mut().zip(stresses) {
            *right += row * Vector6::from(stress[t]).transpose() * volume;
        }
    }
    // Points in a plane do not determine a polynomial.
    let eigenvalues = gram.symmetric_eigenvalues();
    if eigenvalues.min() <= GEOMETRY_TOLERANCE * eigenvalues.max() {
        return None;
    }
    let factor = gram.cholesky()?;
    for right in &mut rights {
        factor.solve_mut(right);
        right.rows_mut(1, 3).unscale_mut(size);
    }
    Some(rights)
}

/// The stresses of all fields at a node in one material.
fn values(
    mesh: &Mesh,
    stars: &Stars,
    number: usize,
    stresses: &[&[[f64; 6]]],
    fits: &[Option<Vec<StressPolynomial>>],
) -> Vec<Vector6<f64>> {
    if let Some(fits) = &fits[number] {
        return fits.iter().map(|fit| fit.row(0).transpose()).collect();
    }
    let ((node, region), star) = (stars.places[number], stars.of(number));
    let mut neighbours: Vec<usize> = star.iter().flat_map(|&t| mesh.tetrahedra[t]).collect();
    neighbours.sort_unstable();
    neighbours.dedup();
    let at = Vector3::from(mesh.coordinates[node]);
    let fitted: Vec<(Vector4<f64>, &[StressPolynomial])> = neighbours
        .iter()
        .filter_map(|&other| {
            let fits = fits[stars.find((other, region))?].as_ref()?;
            let arm = at - Vector3::from(mesh.coordinates[other]);
            Some((Vector4::new(1.0, arm.x, arm.y, arm.z), fits.as_slice()))
        })
        .collect();
    let volume = |t: usize| tetrahedron_volume(&mesh.corners(&mesh.tetrahedra[t]));
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
    stresses.iter().enumerate().map(of_field).collect()
}

/// ∫ (σ* − σ_h):C⁻¹(σ* − σ_h)_k over every tetrahedron for the first field and each, `[n_tetrahedra][n_fields]`, in J for the first
/// itself.
pub(super) fn products(
    mesh: &Mesh,
    material: &MaterialField<'_>,
    fields: &[Field<'_>],
) -> Vec<Vec<f64>> {
    let stresses: Vec<&[[f64; 6]]> = fields.iter().map(|it| &it.internal.stress[..]).collect();
    let recovered = recovered(mesh, material, &stresses);
    let compliances = material.compliances();
    (0..mesh.tetrahedra.len())
        .into_par_iter()
        .map(|t| {
            let volume = tetrahedron_volume(&mesh.corners(&mesh.tetrahedra[t]));
            let difference = |k: usize, at: &[f64; 4]| -> Vector6<f64> {
                let smooth: Vector6<f64> = (0..4).map(|c| recovered[k][t][c] * at[c]).sum();
                smooth - Vector6::from(fields[k].internal.stress[t])
            };
            let product = |k: usize| -> f64 {
                let at = |(at, weight): ([f64; 4], f64)| {
                    let strain = compliances[material.region(t)] * difference(k, &at);
                    weight * difference(0, &at).dot(&strain)
                };
                volume * quadrature::TETRAHEDRON_2.into_iter().map(at).sum::<f64>()
            };
            (0..fields.len()).map(product).collect()
        })
        .collect()
}

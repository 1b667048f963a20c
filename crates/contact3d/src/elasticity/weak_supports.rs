//! Rigid motions that springs resist, but far less than the body resists being strained.

use nalgebra::{DMatrix, Matrix6, Vector3, Vector6};

use super::{
    MaterialField, SpringMatrix,
    free_motions::Motion,
    rigid_motion::{
        RigidMotion, clamped, farthest, free_rigid_motions, middle_and_spread,
        motions_left_to_contact, telling_motions,
    },
};
use crate::{
    mesh::{Mesh, tetrahedron_volume},
    scene::{Invalid, Scene},
};

/// Stiffness of the springs in a rigid motion, as a share of the body's own, below which the motion is an unknown of its own: S would
/// hold it and the face's compliance in one number, and lose as many digits.
const WEAK: f64 = 1e-4;

/// The rigid motions that are unknowns beside the multipliers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LooseMotions {
    /// Those that clamps and springs leave free, and those that springs hold weakly.
    pub(crate) motions: Vec<RigidMotion>,
    /// Whether springs resist any of them.
    pub(crate) resisted: bool,
}

/// The rigid motions that clamps leave and springs hold weakly, or not at all.
///
/// A motion is weak where its energy ½ ∫ u·K u is below [`WEAK`] times c V / r², what uniform strains of the softest kind
/// (least eigenvalue c of C) take for the same mean square displacement, for the volume V and the radius of gyration r: a ratio
/// without units, the same on every mesh.
///
/// # Errors
/// As [`super::refuse_rigid_motions`].
pub(crate) fn loose_motions(scene: &Scene, mesh: &Mesh) -> Result<LooseMotions, Invalid> {
    let free = LooseMotions {
        motions: motions_left_to_contact(scene, mesh)?,
        resisted: false,
    };
    let springs = match scene.contacts.is_empty() {
        true => None,
        false => SpringMatrix::of(scene, mesh)?,
    };
    let Some(springs) = springs else {
        return Ok(free);
    };
    let coordinates = &mesh.coordinates;
    let unclamped = free_rigid_motions(coordinates, &clamped(coordinates, &mesh.held_nodes(scene)));
    if unclamped.is_empty() {
        return Ok(free);
    }
    let loose = softer_than(
        WEAK * own_stiffness(scene, mesh),
        &unclamped,
        &springs,
        mesh,
    );
    if loose.len() <= free.motions.len() {
        return Ok(free);
    }
    let (centre, _) = middle_and_spread(coordinates);
    Ok(LooseMotions {
        motions: telling_motions(&loose, &centre, farthest(coordinates, &centre)),
        resisted: true,
    })
}

/// Combinations of motions in which springs take less than a stiffness in N/m for a mean square displacement of one.
fn softer_than(
    stiffness: f64,
    motions: &[RigidMotion],
    springs: &SpringMatrix,
    mesh: &Mesh,
) -> Vec<Motion> {
    let n = motions.len();
    let velocities = |motion: &RigidMotion| -> Vec<Vector3<f64>> {
        let places = mesh.coordinates.iter();
        places.map(|x| motion.at(x).into()).collect()
    };
    let mut shapes: Vec<_> = motions.iter().map(velocities).collect();
    let mut units = Vec::with_capacity(n);
    for shape in &mut shapes {
        let unit = (shape.len() as f64 / product(shape, shape)).sqrt();
        shape.iter_mut().for_each(|u| *u *= unit);
        units.push(unit);
    }
    let forces: Vec<Vec<Vector3<f64>>> = shapes
        .iter()
        .map(|shape| {
            let nodal: Vec<[f64; 3]> = shape.iter().map(|u| (*u).into()).collect();
            springs
                .forces(&nodal)
                .into_iter()
                .map(Vector3::from)
                .collect()
        })
        .collect();
    let held = DMatrix::from_fn(n, n, |p, q| product(&forces[p], &shapes[q]));
    let moved = DMatrix::from_fn(n, n, |p, q| {
        product(&shapes[p], &shapes[q]) / mesh.coordinates.len() as f64
    });
    let Some(root) = moved
        .cholesky()
        .and_then(|factor| factor.l().transpose().try_inverse())
    else {
        return Vec::new();
    };
    let energies = (root.transpose() * held * &root).symmetric_eigen();
    let soft = (0..n).filter(|&i| energies.eigenvalues[i] < stiffness);
    soft.map(|i| {
        let weights = &root * energies.eigenvectors.column(i);
        let terms = motions.iter().zip(&units).zip(&weights);
        terms.fold([Vector3::zeros(); 2], |sum, ((motion, unit), weight)| {
            let part = motion.about_middle();
            [0, 1].map(|k| sum[k] + part[k] * (unit * weight))
        })
    })
    .collect()
}

fn product(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

/// c V / r² in N/m.
fn own_stiffness(scene: &Scene, mesh: &Mesh) -> f64 {
    // Mandel's components, in which eigenvalues do not depend on axes.
    let root = std::f64::consts::SQRT_2;
    let units = Vector6::new(1.0, 1.0, 1.0, root, root, root);
    let units = Matrix6::from_diagonal(&units);
    let material = MaterialField::new(scene, mesh);
    let softest = material.tensors().iter().map(|tensor| {
        let eigenvalues = (units * tensor * units).symmetric_eigenvalues();
        eigenvalues.min()
    });
    let volumes = mesh
        .tetrahedra
        .iter()
        .map(|corners| tetrahedron_volume(&mesh.corners(corners)).abs());
    let (_, spread) = middle_and_spread(&mesh.coordinates);
    softest.fold(f64::INFINITY, f64::min) * volumes.sum::<f64>() / spread.trace()
}

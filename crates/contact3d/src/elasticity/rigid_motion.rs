//! Rigid motions that clamps and springs leave free, and the refusal of bodies that nothing else holds.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::springs::{HeldPlace, held_directions};
use crate::{
    mesh::Mesh,
    scene::{Invalid, Scene},
};

/// A rigid motion that the clamps leave free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RigidMotion {
    /// Velocity of the origin.
    pub translation: [f64; 3],
    /// Rotation vector.
    pub rotation: [f64; 3],
    /// The middle of the nodes, and its velocity: with them velocities do not cancel far from the origin.
    centre: [f64; 3],
    at_centre: [f64; 3],
}

/// Share of the largest eigenvalue below which a motion counts as free: rounding of coordinates
/// with the digits of a mesh file, squared.
const FREE: f64 = 1e-12;

/// The rigid motions u = t + ω × x under which all held components stay at zero, and all springs at rest: these hold
/// orthonormal directions at some places, however stiffly.
#[must_use]
fn free_rigid_motions(
    coordinates: &[[f64; 3]],
    held: &[[bool; 3]],
    springs: &[HeldPlace],
) -> Vec<RigidMotion> {
    let n = coordinates.len().max(1) as f64;
    let centre: Vector3<f64> = coordinates
        .iter()
        .map(|x| Vector3::from(*x))
        .sum::<Vector3<f64>>()
        / n;
    let extent = coordinates
        .iter()
        .map(|x| (Vector3::from(*x) - centre).norm())
        .fold(0.0_f64, f64::max);
    let mut gram = Matrix6::zeros();
    let mut hold = |x: &[f64; 3], axis: Vector3<f64>| {
        let arm = (Vector3::from(*x) - centre) / extent;
        let turn = arm.cross(&axis);
        let row = Vector6::new(axis.x, axis.y, axis.z, turn.x, turn.y, turn.z);
        gram += row * row.transpose();
    };
    for (x, held) in coordinates.iter().zip(held) {
        for c in (0..3).filter(|&c| held[c]) {
            hold(x, Vector3::ith_axis(c).into_inner());
        }
    }
    for (x, directions) in springs {
        directions.iter().for_each(|axis| hold(x, *axis));
    }
    telling_basis(&null_space(gram))
        .iter()
        .map(|mode| {
            let rotation = Vector3::new(mode[3], mode[4], mode[5]) / extent;
            let at_centre = Vector3::new(mode[0], mode[1], mode[2]);
            RigidMotion {
                translation: (at_centre - rotation.cross(&centre)).into(),
                rotation: rotation.into(),
                centre: centre.into(),
                at_centre: at_centre.into(),
            }
        })
        .collect()
}

/// Refuses clamps and springs that leave a rigid motion free where no contact could stop it.
///
/// # Errors
/// The free motions in words, a spring's stiffness that no spring can have.
pub fn refuse_rigid_motions(scene: &Scene, mesh: &Mesh) -> Result<(), Invalid> {
    motions_left_to_contact(scene, mesh).map(drop)
}

/// The rigid motions that clamps and springs leave to the contact of the scene.
///
/// # Errors
/// As [`refuse_rigid_motions`].
pub(crate) fn motions_left_to_contact(
    scene: &Scene,
    mesh: &Mesh,
) -> Result<Vec<RigidMotion>, Invalid> {
    let springs = held_directions(scene, mesh)?;
    let free = free_rigid_motions(&mesh.coordinates, &mesh.held_nodes(scene), &springs);
    if free.is_empty() || !scene.contacts.is_empty() {
        return Ok(free);
    }
    let motions: Vec<String> = free.iter().map(|m| m.describe(mesh.extent())).collect();
    Err(Invalid {
        key: "clamp".into(),
        expected: "clamps and springs that leave no rigid motion free".into(),
        found: format!("free: {}", motions.join(", ")),
        help: "hold more components with [[clamp]] or [[spring]], or let the body rest on a foundation with [contact]".into(),
    })
}

/// Orthonormal vectors that a positive semidefinite matrix maps to zero.
fn null_space(gram: Matrix6<f64>) -> Vec<Vector6<f64>> {
    let eigen = gram.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    (0..6)
        .filter(|&i| eigen.eigenvalues[i] <= FREE * largest)
        .map(|i| eigen.eigenvectors.column(i).into_owned())
        .collect()
}

/// A basis of the same space with as many motions along and about the axes as there are.
fn telling_basis(space: &[Vector6<f64>]) -> Vec<Vector6<f64>> {
    const LEAST_LENGTH: f64 = 1e-3;
    let mut basis: Vec<Vector6<f64>> = Vec::new();
    for least in [1.0 - 1e-6, LEAST_LENGTH] {
        for axis in 0..6 {
            let unit = Vector6::ith_axis(axis).into_inner();
            let mut along: Vector6<f64> = space.iter().map(|v| v * v.dot(&unit)).sum();
            for known in &basis {
                along -= known * known.dot(&along);
            }
            if along.norm() >= least && basis.len() < space.len() {
                basis.push(along.normalize());
            }
        }
    }
    basis
}

impl RigidMotion {
    /// The velocity of a point.
    #[must_use]
    pub(crate) fn at(&self, point: &[f64; 3]) -> [f64; 3] {
        let arm = Vector3::from(*point) - Vector3::from(self.centre);
        (Vector3::from(self.at_centre) + Vector3::from(self.rotation).cross(&arm)).into()
    }

    /// What the motion is, in words: a translation or a rotation, and along or about what.
    #[must_use]
    pub(crate) fn describe(&self, extent: f64) -> String {
        let turn = Vector3::from(self.rotation);
        let shift = Vector3::from(self.translation);
        let direction = |v: Vector3<f64>| {
            let v = v.normalize();
            let named = ["x", "y", "z"]
                .into_iter()
                .enumerate()
                .find(|(c, _)| v[*c].abs() > 1.0 - 1e-6);
            named.map_or_else(
                || format!("({:.3}, {:.3}, {:.3})", v.x, v.y, v.z),
                |(_, name)| name.to_owned(),
            )
        };
        if turn.norm() * extent <= 1e-6 * shift.norm() {
            format!("translation along {}", direction(shift))
        } else {
            let point = turn.cross(&shift) / turn.norm_squared();
            let point = point.map(|c| if c.abs() < 1e-9 * extent { 0.0 } else { c });
            format!(
                "rotation about {} through ({:.3e}, {:.3e}, {:.3e})",
                direction(turn),
                point.x,
                point.y,
                point.z
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 3]; 4] = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 3.0],
    ];

    #[test]
    fn a_held_triangle_leaves_nothing_free() {
        let held = [[true; 3], [true; 3], [true; 3], [false; 3]];
        assert!(free_rigid_motions(&CORNERS, &held, &[]).is_empty());
    }

    #[test]
    fn two_held_points_leave_the_rotation_about_their_line() {
        let held = [[true; 3], [true; 3], [false; 3], [false; 3]];
        let free = free_rigid_motions(&CORNERS, &held, &[]);
        assert_eq!(free.len(), 1);
        assert!(
            free[0]
                .describe(1.0)
                .starts_with("rotation about x through")
        );
    }

    #[test]
    fn a_plane_on_rollers_slides_and_turns_in_itself() {
        let held = [[false, false, true]; 4];
        let free = free_rigid_motions(&CORNERS, &held, &[]);
        let words: Vec<String> = free.iter().map(|motion| motion.describe(3.0)).collect();
        assert_eq!(words[..2], ["translation along x", "translation along y"]);
        assert!(words[2].starts_with("rotation about z"), "{}", words[2]);
        assert_eq!(words.len(), 3);
    }

    #[test]
    fn nothing_held_leaves_all_six() {
        assert_eq!(free_rigid_motions(&CORNERS, &[[false; 3]; 4], &[]).len(), 6);
    }
}

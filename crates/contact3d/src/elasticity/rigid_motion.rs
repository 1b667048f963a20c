//! Rigid motions that clamps and springs leave free, and the refusal of bodies that nothing else holds.

use nalgebra::{Matrix3, Vector3, Vector6};

use super::{
    free_motions::{Hold, Motion, free_motions, loose_motions},
    springs::held_directions,
};
use crate::{
    mesh::Mesh,
    scene::{InvalidValue, Scene},
};

/// A rigid motion that the clamps leave free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RigidMotion {
    /// Rotation vector.
    pub(super) rotation: Vector3<f64>,
    /// The middle of the nodes, and its velocity: with them velocities do not cancel far from the origin.
    centre: Vector3<f64>,
    pub(super) at_centre: Vector3<f64>,
}

/// The rigid motions u = t + ω × x under which nothing of a body that is held moves.
pub(super) fn free_rigid_motions(coordinates: &[[f64; 3]], holds: &[Hold]) -> Vec<RigidMotion> {
    let (centre, spread) = middle_and_spread(coordinates);
    let extent = farthest(coordinates, &centre);
    let motions = free_motions(holds, &centre, &spread);
    telling_motions(&motions, &centre, extent)
}

/// A basis of the same motions about a point c, with as many along and about the axes as there are; rotations count by what they
/// do at the distance `extent`.
pub(super) fn telling_motions(
    motions: &[Motion],
    centre: &Vector3<f64>,
    extent: f64,
) -> Vec<RigidMotion> {
    let scaled = motions.iter().map(|[shift, turn]| {
        let turn = turn * extent;
        Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
    });
    let space = match motions.len() {
        // All motions there are.
        6 => (0..6)
            .map(|axis| Vector6::ith_axis(axis).into_inner())
            .collect(),
        _ => orthonormal(scaled),
    };
    let modes = telling_basis(&space);
    let motion = |mode: &Vector6<f64>| RigidMotion {
        rotation: Vector3::new(mode[3], mode[4], mode[5]) / extent,
        centre: *centre,
        at_centre: Vector3::new(mode[0], mode[1], mode[2]),
    };
    modes.iter().map(motion).collect()
}

/// The mean place c in m and the mean of (x − c)(x − c)ᵀ in m².
pub(super) fn middle_and_spread(coordinates: &[[f64; 3]]) -> (Vector3<f64>, Matrix3<f64>) {
    let n = coordinates.len().max(1) as f64;
    let places = || coordinates.iter().map(|x| Vector3::from(*x));
    let centre = places().sum::<Vector3<f64>>() / n;
    let arms = places().map(|x| x - centre);
    let spread = arms.map(|arm| arm * arm.transpose()).sum::<Matrix3<f64>>() / n;
    (centre, spread)
}

/// The largest distance of a place from c.
pub(super) fn farthest(coordinates: &[[f64; 3]], centre: &Vector3<f64>) -> f64 {
    let distances = coordinates
        .iter()
        .map(|x| (Vector3::from(*x) - centre).norm());
    distances.fold(0.0_f64, f64::max)
}

/// The components that clamps hold.
pub(super) fn clamped(coordinates: &[[f64; 3]], held: &[[bool; 3]]) -> Vec<Hold> {
    let nodes = coordinates.iter().zip(held);
    nodes
        .flat_map(|(x, held)| {
            let components = (0..3).filter(|&c| held[c]);
            components.map(|c| (Vector3::from(*x), Vector3::ith_axis(c).into_inner()))
        })
        .collect()
}

/// Refuses clamps and springs that leave a rigid motion free where no contact could stop it, or hold one by next to nothing.
///
/// # Errors
/// The free motions in words, the stiffness of springs that are too soft, a spring's stiffness that no spring can have.
pub fn refuse_rigid_motions(scene: &Scene, mesh: &Mesh) -> Result<(), InvalidValue> {
    loose_motions(scene, mesh).map(drop)
}

/// The rigid motions that clamps and springs leave to the contact of the scene.
///
/// # Errors
/// Free motions where there is no contact, a spring's stiffness that no spring can have.
pub(super) fn motions_left_to_contact(
    scene: &Scene,
    mesh: &Mesh,
) -> Result<Vec<RigidMotion>, InvalidValue> {
    let mut holds = clamped(&mesh.coordinates, &mesh.held_nodes(scene));
    holds.extend(held_directions(scene, mesh)?);
    let free = free_rigid_motions(&mesh.coordinates, &holds);
    if free.is_empty() || !scene.contacts.is_empty() {
        return Ok(free);
    }
    let motions: Vec<String> = free.iter().map(|m| m.describe(mesh.extent())).collect();
    Err(InvalidValue {
        key: "clamp".into(),
        expected: "clamps and springs that leave no rigid motion free".into(),
        found: format!("free: {}", motions.join(", ")),
        help: "hold more components with [[clamp]] or [[spring]], or let the body rest on a foundation with [contact]".into(),
    })
}

/// An orthonormal basis of the span of independent vectors.
fn orthonormal(vectors: impl Iterator<Item = Vector6<f64>>) -> Vec<Vector6<f64>> {
    let mut basis: Vec<Vector6<f64>> = Vec::new();
    for vector in vectors {
        let mut rest = vector.normalize();
        for _ in 0..2 {
            for known in &basis {
                rest -= known * known.dot(&rest);
            }
        }
        basis.push(rest.normalize());
    }
    basis
}

/// A basis of the same space with as many motions along and about the axes as there are.
fn telling_basis(space: &[Vector6<f64>]) -> Vec<Vector6<f64>> {
    let mut basis: Vec<Vector6<f64>> = Vec::new();
    // First the axes themselves, then what of an axis is not rounding.
    for least in [1.0 - 1e-6, 1e-3] {
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

pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

/// The axis that a unit vector lies along.
pub(super) fn axis_along(v: &Vector3<f64>, tolerance: f64) -> Option<usize> {
    (0..3).find(|&c| v[c].abs() > 1.0 - tolerance)
}

impl RigidMotion {
    /// The velocity of a point.
    pub(crate) fn at(&self, point: &[f64; 3]) -> [f64; 3] {
        let arm = Vector3::from(*point) - self.centre;
        (self.at_centre + self.rotation.cross(&arm)).into()
    }

    /// What the motion is, in words: a translation or a rotation, and along or about what.
    pub(crate) fn describe(&self, extent: f64) -> String {
        let (turn, shift) = (
            self.rotation,
            self.at_centre - self.rotation.cross(&self.centre),
        );
        let direction = |v: Vector3<f64>| {
            let v = v.normalize();
            axis_along(&v, 1e-6).map_or_else(
                || format!("({:.3}, {:.3}, {:.3})", v.x, v.y, v.z),
                |c| AXES[c].to_owned(),
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
        assert!(free_rigid_motions(&CORNERS, &clamped(&CORNERS, &held)).is_empty());
    }

    #[test]
    fn two_held_points_leave_the_rotation_about_their_line() {
        let held = [[true; 3], [true; 3], [false; 3], [false; 3]];
        let free = free_rigid_motions(&CORNERS, &clamped(&CORNERS, &held));
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
        let free = free_rigid_motions(&CORNERS, &clamped(&CORNERS, &held));
        let words: Vec<String> = free.iter().map(|motion| motion.describe(3.0)).collect();
        assert_eq!(words[..2], ["translation along x", "translation along y"]);
        assert!(words[2].starts_with("rotation about z"), "{}", words[2]);
        assert_eq!(words.len(), 3);
    }

    #[test]
    fn nothing_held_leaves_all_six() {
        assert_eq!(free_rigid_motions(&CORNERS, &[]).len(), 6);
    }
}

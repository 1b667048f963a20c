//! Rigid motions that clamps and springs leave free, and the refusal of bodies that nothing else holds.

use nalgebra::{DMatrix, Matrix3, RowDVector, Vector3, Vector6};

use super::{
    ToolPlace,
    free_motions::{Hold, Motion, free_motions, loose_motions_of_bodies},
    springs::held_directions,
};
use crate::{
    mesh::{GEOMETRY_TOLERANCE, Mesh},
    scene::{InvalidValue, POSITION, Scene},
};

/// A rigid motion that the clamps leave free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RigidMotion {
    /// The body that moves, with those glued to it; all others rest.
    pub(super) body: usize,
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
        body: 0,
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
    loose_motions_of_bodies(scene, mesh).map(drop)
}

/// The rigid motions that clamps and springs leave to the contact of the scene.
///
/// # Errors
/// Free motions where there is no contact, a spring's stiffness that no spring can have.
pub(super) fn motions_left_to_contact(
    scene: &Scene,
    mesh: &Mesh,
) -> Result<Vec<RigidMotion>, InvalidValue> {
    let mut holds = clamped(&mesh.coordinates, &mesh.held_by(&scene.clamps));
    holds.extend(held_directions(scene, mesh)?);
    let free = left_by_tools(scene, mesh, free_rigid_motions(&mesh.coordinates, &holds));
    if free.is_empty() || scene.has_contact() {
        return Ok(free);
    }
    let motions: Vec<String> = free
        .iter()
        .map(|m| m.describe(mesh.extent(), scene.units.length()))
        .collect();
    Err(InvalidValue {
        key: "clamp".into(),
        expected: "clamps and springs that leave no rigid motion free".into(),
        found: format!("free: {}", motions.join(", ")),
        help: "hold more components with [[clamp]] or [[spring]], or let the body rest on a foundation with [contact]".into(),
    })
}

/// Those of some rigid motions in which no held motion of a tool that is bonded to the body takes part.
pub(super) fn left_by_tools(
    scene: &Scene,
    mesh: &Mesh,
    motions: Vec<RigidMotion>,
) -> Vec<RigidMotion> {
    let (centre, _) = middle_and_spread(&mesh.coordinates);
    let extent = farthest(&mesh.coordinates, &centre);
    let places = ToolPlace::of_scene(scene, mesh);
    let bonded = scene.tools.iter().zip(&places);
    let bonded = bonded.filter(|(tool, _)| tool.face.is_some());
    let mut rows: Vec<RowDVector<f64>> = Vec::new();
    for (tool, place) in bonded {
        for held in (0..6).filter(|motion| !tool.is_free(*motion)) {
            let of = |motion: &RigidMotion| match held {
                0..3 => motion.at(&place.point)[held],
                _ => motion.rotation[held - 3] * extent,
            };
            let row = motions.iter().map(of);
            rows.push(RowDVector::from_iterator(motions.len(), row));
        }
    }
    if rows.is_empty() || motions.is_empty() {
        return motions;
    }
    // As many rows as columns at least, so that no vector is missing.
    rows.resize(
        rows.len().max(motions.len()),
        RowDVector::zeros(motions.len()),
    );
    let svd = DMatrix::from_rows(&rows).svd(false, true);
    let weights = svd.v_t.expect("asked for");
    let free = (0..motions.len()).filter(|p| svd.singular_values[*p] <= GEOMETRY_TOLERANCE);
    let left = free.map(|p| {
        let row = weights.row(p);
        let terms = motions
            .iter()
            .zip(row.iter())
            .map(|(motion, weight)| [motion.at_centre, motion.rotation].map(|part| part * *weight));
        terms.fold([Vector3::zeros(); 2], |sum, part| {
            [0, 1].map(|k| sum[k] + part[k])
        })
    });
    let left: Vec<Motion> = left.collect();
    telling_motions(&left, &centre, extent)
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

/// A rigid motion in space, u(x) = t + ω × (x − c).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyMotion {
    /// Displacement t of the point c, in m: along ω where the body turns, so that c lies on the axis of a screw.
    pub translation: [f64; 3],
    /// Rotation vector ω, in radians.
    pub rotation: [f64; 3],
    /// The point c, in m; the middle of the body where it does not turn.
    pub point: [f64; 3],
}

impl BodyMotion {
    /// The rigid motion nearest to displacements of points in m by the mean square over the points with their weights.
    #[must_use]
    pub fn fitted(points: &[[f64; 3]], weights: &[f64], displacement: &[[f64; 3]]) -> Self {
        Self::fitted_up_to(GEOMETRY_TOLERANCE, (points, weights), displacement)
    }

    /// The same for words: a translation where the body turns by no more than a hundredth of its way.
    #[must_use]
    pub fn told(points: &[[f64; 3]], weights: &[f64], displacement: &[[f64; 3]]) -> Self {
        Self::fitted_up_to(1e-2, (points, weights), displacement)
    }

    /// A basis of the same rigid motions, displacements of points, with as many along and about the axes as there are.
    #[must_use]
    pub fn telling(points: &[[f64; 3]], motions: &[Vec<[f64; 3]>]) -> Vec<Vec<[f64; 3]>> {
        let (centre, _) = middle_and_spread(points);
        let about_centre = |motion: &Vec<[f64; 3]>| {
            let rigid = Self::fitted(points, &vec![1.0; points.len()], motion);
            let turn = Vector3::from(rigid.rotation);
            let shift = Vector3::from(rigid.translation);
            [
                shift + turn.cross(&(centre - Vector3::from(rigid.point))),
                turn,
            ]
        };
        let motions: Vec<_> = motions.iter().map(about_centre).collect();
        let telling = telling_motions(&motions, &centre, farthest(points, &centre));
        let at_points = |motion: &RigidMotion| points.iter().map(|x| motion.at(x)).collect();
        telling.iter().map(at_points).collect()
    }

    fn fitted_up_to(
        negligible: f64,
        (points, weights): (&[[f64; 3]], &[f64]),
        displacement: &[[f64; 3]],
    ) -> Self {
        let whole: f64 = weights.iter().sum();
        let mean = |of: &[[f64; 3]]| {
            let terms = of.iter().zip(weights);
            terms
                .map(|(v, weight)| Vector3::from(*v) * *weight)
                .sum::<Vector3<f64>>()
                / whole
        };
        let (centre, shift) = (mean(points), mean(displacement));
        let mut inertia = nalgebra::Matrix3::zeros();
        let mut moment = Vector3::zeros();
        for ((x, u), weight) in points.iter().zip(displacement).zip(weights) {
            let arm = Vector3::from(*x) - centre;
            let square = nalgebra::Matrix3::identity() * arm.norm_squared() - arm * arm.transpose();
            inertia += square * *weight;
            moment += arm.cross(&(Vector3::from(*u) - shift)) * *weight;
        }
        let rotation = inertia
            .cholesky()
            .map_or_else(Vector3::zeros, |factor| factor.solve(&moment));
        let extent = (inertia.trace() / whole).sqrt();
        Self::screw(negligible, [shift, rotation], &centre, extent)
    }

    /// The motion with a shift of c in m and a rotation; it is a translation where the body, of some extent in m, turns by no more than a
    /// negligible share of its way.
    fn screw(
        negligible: f64,
        [shift, rotation]: Motion,
        centre: &Vector3<f64>,
        extent: f64,
    ) -> Self {
        if rotation.norm() * extent <= negligible * shift.norm() {
            return Self {
                translation: shift.into(),
                rotation: [0.0; 3],
                point: (*centre).into(),
            };
        }
        let square = rotation.norm_squared();
        let along = rotation * (rotation.dot(&shift) / square);
        let point = centre + rotation.cross(&shift) / square;
        let clean = |v: Vector3<f64>, size: f64| -> [f64; 3] {
            let is_rounding = |c: f64| c.abs() <= GEOMETRY_TOLERANCE * size;
            v.map(|c| if is_rounding(c) { 0.0 } else { c }).into()
        };
        Self {
            translation: clean(along, rotation.norm() * extent),
            rotation: clean(rotation, rotation.norm()),
            point: clean(point, extent.max(centre.norm())),
        }
    }

    /// The displacement of a place in m.
    #[must_use]
    pub fn at(&self, place: [f64; 3]) -> [f64; 3] {
        let arm = Vector3::from(place) - Vector3::from(self.point);
        (Vector3::from(self.translation) + Vector3::from(self.rotation).cross(&arm)).into()
    }

    /// The angle in radians by which the body turns, and about which direction, in words; `None` where it does not turn.
    #[must_use]
    pub fn turn(&self) -> Option<(f64, String)> {
        let turn = Vector3::from(self.rotation);
        (turn.norm() > 0.0).then(|| (turn.norm(), direction(turn)))
    }

    /// The motion in words, with lengths in the unit `length`.
    #[must_use]
    pub fn describe(&self, length: &str) -> String {
        let turn = Vector3::from(self.rotation);
        let shift = Vector3::from(self.translation);
        if turn.norm() == 0.0 {
            return format!("translation along {}", direction(shift));
        }
        let [x, y, z] = self.point;
        let mut words = format!(
            "rotation about {} through ({x:.6}, {y:.6}, {z:.6}) {length}",
            direction(turn)
        );
        if shift.norm() > 0.0 {
            words += &format!(", with a translation along {}", direction(shift));
        }
        words
    }
}

/// A direction in words: an axis with its sign, or a unit vector.
fn direction(v: Vector3<f64>) -> String {
    let v = v.normalize().map(|c| if c.abs() < 1e-9 { 0.0 } else { c });
    match (0..3).find(|&c| v[c].abs() > 1.0 - 1e-9) {
        Some(c) => {
            let sign = if v[c] < 0.0 { "-" } else { "" };
            format!("{sign}{}", POSITION[c])
        }
        None => format!("({:.6}, {:.6}, {:.6})", v.x, v.y, v.z),
    }
}

impl RigidMotion {
    /// The same of one of several bodies.
    pub(super) fn of_body(self, body: usize) -> Self {
        Self { body, ..self }
    }

    /// The velocity of a point.
    pub(crate) fn at(&self, point: &[f64; 3]) -> [f64; 3] {
        let arm = Vector3::from(*point) - self.centre;
        (self.at_centre + self.rotation.cross(&arm)).into()
    }

    /// What the motion is, in words: a translation or a rotation, and along or about what; for a body of some extent, with lengths in the
    /// unit `length`.
    pub(crate) fn describe(&self, extent: f64, length: &str) -> String {
        let motion = [self.at_centre, self.rotation];
        let mut found = BodyMotion::screw(GEOMETRY_TOLERANCE, motion, &self.centre, extent);
        // The opposite of a free motion is the same motion.
        let leading = match found.rotation {
            [0.0, 0.0, 0.0] => Vector3::from(found.translation),
            turn => Vector3::from(turn),
        };
        let sign = leading[leading.iamax()].signum();
        found.translation = found.translation.map(|v| sign * v);
        found.rotation = found.rotation.map(|v| sign * v);
        found.describe(length)
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
                .describe(1.0, "m")
                .starts_with("rotation about x through")
        );
    }

    #[test]
    fn a_plane_on_rollers_slides_and_turns_in_itself() {
        let held = [[false, false, true]; 4];
        let free = free_rigid_motions(&CORNERS, &clamped(&CORNERS, &held));
        let words: Vec<String> = free
            .iter()
            .map(|motion| motion.describe(3.0, "m"))
            .collect();
        assert_eq!(words[..2], ["translation along x", "translation along y"]);
        assert!(words[2].starts_with("rotation about z"), "{}", words[2]);
        assert_eq!(words.len(), 3);
    }

    #[test]
    fn nothing_held_leaves_all_six() {
        assert_eq!(free_rigid_motions(&CORNERS, &[]).len(), 6);
    }

    #[test]
    fn motions_are_those_of_the_body_and_not_of_its_nodes() {
        // ∫ x² over [0, 1] by Simpson's rule on [0, 1/4] and [1/4, 1].
        let points = [0.0, 0.125, 0.25, 0.625, 1.0].map(|x| [x, 0.0, 0.0]);
        let weights = [1.0, 4.0, 4.0, 12.0, 3.0].map(|w| w / 24.0);
        let displacement = points.map(|[x, ..]| [0.0, 0.0, x * x]);
        let motion = BodyMotion::fitted(&points, &weights, &displacement);
        // The line has no inertia about itself, so that it is said to be shifted alone.
        assert!(
            (motion.translation[2] - 1.0 / 3.0).abs() < 1e-15,
            "{motion:?}"
        );
        assert_eq!(motion.rotation, [0.0; 3]);
    }
}

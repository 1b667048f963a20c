//! Rigid motions that supports leave free, or hold only weakly.

use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3, Vector6};

use super::{
    MaterialField, SpringMatrix,
    rigid_motion::{
        RigidMotion, clamped, farthest, free_rigid_motions, left_by_tools, middle_and_spread,
        motions_left_to_contact, telling_motions,
    },
};
use crate::{
    linalg::UNIT_ROUNDING,
    mesh::{GEOMETRY_TOLERANCE, Mesh, tetrahedron_volume},
    scene::{InvalidValue, Scene},
};

/// A direction, a unit vector, in which a place in m is held.
pub(super) type Hold = (Vector3<f64>, Vector3<f64>);

/// A motion u(x) = t + ω × (x − c), as t and ω.
pub(super) type Motion = [Vector3<f64>; 2];

/// The motions about c that move no held place along its direction.
///
/// A motion is free where coordinates moved by no more than [`GEOMETRY_TOLERANCE`] of `spread` = ⟨(x − c)(x − c)ᵀ⟩ over the body would make it
/// so. Places that count as different are told apart by the extent across, not along: a cantilever holds its root however long it is.
pub(super) fn free_motions(
    holds: &[Hold],
    centre: &Vector3<f64>,
    spread: &Matrix3<f64>,
) -> Vec<Motion> {
    let n = holds.len().max(1) as f64;
    let middle = holds.iter().map(|(x, _)| x).sum::<Vector3<f64>>() / n;
    let directions: Matrix3<f64> = holds.iter().map(|(_, n)| n * n.transpose()).sum();
    let directions = directions.symmetric_eigen();
    let still =
        |i: &usize| directions.eigenvalues[*i] <= UNIT_ROUNDING * directions.eigenvalues.max();
    let (unheld, held): (Vec<usize>, Vec<usize>) = (0..3).partition(still);
    let along = |i: usize| directions.eigenvectors.column(i).into_owned();
    let inverse: Matrix3<f64> = held
        .iter()
        .map(|&i| along(i) * along(i).transpose() / directions.eigenvalues[i])
        .sum();
    // What a rotation does along the held directions beside the translation that undoes most of it; twice, for rounding.
    let mut arms: Vec<Vector3<f64>> = holds.iter().map(|(x, n)| (x - middle).cross(n)).collect();
    let mut undone = Matrix3::zeros();
    for _ in 0..2 {
        let pairs = holds.iter().zip(&arms);
        let by: Matrix3<f64> = inverse
            * pairs
                .map(|((_, n), arm)| n * arm.transpose())
                .sum::<Matrix3<f64>>();
        for ((_, n), arm) in holds.iter().zip(&mut arms) {
            *arm -= by.transpose() * n;
        }
        undone += by;
    }
    let moved: Matrix3<f64> = arms.iter().map(|arm| arm * arm.transpose()).sum();
    let noises = holds
        .iter()
        .map(|(x, n)| uncertainty(&(x - middle), n, spread));
    let turns = hardly_moved(&moved, &noises.sum(), spread).into_iter();
    let turns = turns.map(|turn| [turn.cross(&(centre - middle)) - undone * turn, turn]);
    let shifts = unheld.into_iter().map(|i| [along(i), Vector3::zeros()]);
    turns.chain(shifts).collect()
}

/// The square of what a rotation ω seems to move a held place by, through coordinates and directions that are not exact, as a
/// quadratic form in ω.
fn uncertainty(arm: &Vector3<f64>, along: &Vector3<f64>, spread: &Matrix3<f64>) -> Matrix3<f64> {
    let across = along.cross_matrix();
    let turned = arm.cross_matrix();
    across.transpose() * spread * across * GEOMETRY_TOLERANCE.powi(2)
        + turned.transpose() * turned * UNIT_ROUNDING.powi(2)
}

/// The rotations ω with ωᵀ moved ω ≤ ωᵀ noise ω: each axis of the body in a unit of its own, so that no rotation is small beside
/// another.
fn hardly_moved(
    moved: &Matrix3<f64>,
    noise: &Matrix3<f64>,
    spread: &Matrix3<f64>,
) -> Vec<Vector3<f64>> {
    let axes = spread.symmetric_eigen().eigenvectors;
    let in_axes = |form: &Matrix3<f64>| axes.transpose() * form * axes;
    let (moved, noise) = (in_axes(moved), in_axes(noise));
    let units = (moved + noise).diagonal().map(|square| match square {
        0.0 => 1.0,
        square => square.sqrt().recip(),
    });
    let scaled = |form: &Matrix3<f64>| form.component_mul(&(units * units.transpose()));
    let all = scaled(&(moved + noise)) + Matrix3::identity() * UNIT_ROUNDING;
    let Some(root) = all
        .cholesky()
        .and_then(|factor| factor.l().transpose().try_inverse())
    else {
        return Vec::new();
    };
    let shares = (root.transpose() * scaled(&moved) * root).symmetric_eigen();
    (0..3)
        .filter(|&i| shares.eigenvalues[i] <= 0.5)
        .map(|i| axes * (root * shares.eigenvectors.column(i)).component_mul(&units))
        .collect()
}

/// Relative stiffness of the springs in a rigid motion below which the motion is an unknown of its own: S would hold it and the
/// compliance of the face in one number, and lose as many digits.
const WEAK_SPRINGS: f64 = 1e-4;

/// Relative stiffness of the springs in a rigid motion below which they are refused: strains are then a billionth of the displacement,
/// which leaves them seven of its sixteen digits.
const SOFTEST_SPRINGS: f64 = 1e-9;

/// As [`loose_motions`] of each body, of glued ones together.
///
/// # Errors
/// As there, with the names of the bodies among several.
pub(crate) fn loose_motions_of_bodies(
    scene: &Scene,
    mesh: &Mesh,
) -> Result<(Vec<RigidMotion>, bool), InvalidValue> {
    if mesh.bodies.is_empty() {
        return loose_motions(scene, mesh);
    }
    let (mut all, mut resisted) = (Vec::new(), false);
    for bodies in mesh.glued_bodies() {
        let own = loose_motions(&scene.of_bodies(&bodies), &mesh.of_bodies(&bodies));
        let (motions, is_resisted) = own.map_err(|invalid| {
            let names: Vec<String> = bodies.iter().map(|body| scene.body_name(*body)).collect();
            InvalidValue {
                found: format!("of the body {}: {}", names.join(" with "), invalid.found),
                ..invalid
            }
        })?;
        all.extend(motions.into_iter().map(|motion| motion.of_body(bodies[0])));
        resisted |= is_resisted;
    }
    Ok((all, resisted))
}

/// The rigid motions that are unknowns beside the multipliers: those that clamps leave and springs hold weakly, by less than
/// [`WEAK_SPRINGS`] of the body's own stiffness, or not at all; and whether springs resist any of them.
///
/// # Errors
/// Free motions where no contact could stop them, springs softer than [`SOFTEST_SPRINGS`], a spring's stiffness that no spring can have.
fn loose_motions(scene: &Scene, mesh: &Mesh) -> Result<(Vec<RigidMotion>, bool), InvalidValue> {
    let free = motions_left_to_contact(scene, mesh)?;
    let mut loose = sprung_motions(scene, mesh)?;
    loose.retain(|(_, stiffness)| *stiffness < WEAK_SPRINGS);
    if loose.len() <= free.len() {
        return Ok((free, false));
    }
    let (centre, _) = middle_and_spread(&mesh.coordinates);
    let extent = farthest(&mesh.coordinates, &centre);
    let basis = |motions: &[Motion]| telling_motions(motions, &centre, extent);
    // Motions without springs come first: their stiffness is rounding.
    loose.sort_by(|(_, a), (_, b)| a.total_cmp(b));
    let (motion, softest) = loose[free.len()];
    if softest < SOFTEST_SPRINGS {
        let motion = basis(&[motion])[0];
        return Err(InvalidValue {
            key: "spring".into(),
            expected: format!(
                "springs with at least {SOFTEST_SPRINGS:e} of the body's own stiffness in every motion that they hold"
            ),
            found: format!(
                "{:.1e} of it in a {}",
                softest,
                motion.describe(mesh.extent(), scene.units.length())
            ),
            help: "make the springs stiffer, or remove them: contact holds a body by itself".into(),
        });
    }
    let motions: Vec<Motion> = loose.into_iter().map(|(motion, _)| motion).collect();
    Ok((basis(&motions), true))
}

/// The motions that clamps leave a body in contact, in which the stiffness of the springs is diagonal, with that stiffness relative to the
/// body's own, without unit; none without springs.
///
/// Their energy ½ ∫ u·K u is set beside c V / r², what uniform strains of the softest kind (least eigenvalue c of C) take for the same
/// mean square displacement, for the volume V and the radius of gyration r: the same number in all units and on every mesh.
fn sprung_motions(scene: &Scene, mesh: &Mesh) -> Result<Vec<(Motion, f64)>, InvalidValue> {
    let springs = if !scene.has_contact() {
        None
    } else {
        SpringMatrix::of(scene, mesh)?
    };
    let Some(springs) = springs else {
        return Ok(Vec::new());
    };
    let coordinates = &mesh.coordinates;
    let clamps = clamped(coordinates, &mesh.held_by(&scene.clamps));
    let motions = left_by_tools(scene, mesh, free_rigid_motions(coordinates, &clamps));
    if motions.is_empty() {
        return Ok(Vec::new());
    }
    let n = motions.len();
    let mut units = Vec::with_capacity(n);
    let mut shapes: Vec<Vec<[f64; 3]>> = Vec::with_capacity(n);
    for motion in &motions {
        let mut shape: Vec<[f64; 3]> = coordinates.iter().map(|x| motion.at(x)).collect();
        let unit = (shape.len() as f64 / product(&shape, &shape)).sqrt();
        shape.as_flattened_mut().iter_mut().for_each(|u| *u *= unit);
        units.push(unit);
        shapes.push(shape);
    }
    let forces: Vec<Vec<[f64; 3]>> = shapes.iter().map(|shape| springs.forces(shape)).collect();
    let held = DMatrix::from_fn(n, n, |p, q| product(&forces[p], &shapes[q]));
    let moved = DMatrix::from_fn(n, n, |p, q| {
        product(&shapes[p], &shapes[q]) / coordinates.len() as f64
    });
    let Some(root) = moved
        .cholesky()
        .and_then(|factor| factor.l().transpose().try_inverse())
    else {
        return Ok(Vec::new());
    };
    let own = own_stiffness(scene, mesh);
    let energies = (root.transpose() * held * &root).symmetric_eigen();
    let sprung = (0..n).map(|i| {
        let weights = &root * energies.eigenvectors.column(i);
        let terms = motions.iter().zip(&units).zip(&weights);
        let motion = terms.fold([Vector3::zeros(); 2], |sum, ((motion, unit), weight)| {
            let part = [motion.at_centre, motion.rotation];
            [0, 1].map(|k| sum[k] + part[k] * (unit * weight))
        });
        (motion, energies.eigenvalues[i] / own)
    });
    Ok(sprung.collect())
}

fn product(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let pairs = a.iter().zip(b);
    let products = pairs.map(|(a, b)| Vector3::from(*a).dot(&Vector3::from(*b)));
    products.sum()
}

/// c V / r² in N/m.
fn own_stiffness(scene: &Scene, mesh: &Mesh) -> f64 {
    // Mandel's components, in which eigenvalues do not depend on axes.
    let root = std::f64::consts::SQRT_2;
    let units = Vector6::new(1.0, 1.0, 1.0, root, root, root);
    let units = Matrix6::from_diagonal(&units);
    let material = MaterialField::new(scene, mesh);
    let tensors = material.tensors.iter();
    let softest = tensors.map(|tensor| (units * tensor * units).symmetric_eigenvalues().min());
    let volume = |corners: &[usize; 4]| tetrahedron_volume(&mesh.corners(corners)).abs();
    let volumes = mesh.tetrahedra.iter().map(volume);
    let (_, spread) = middle_and_spread(&mesh.coordinates);
    softest.fold(f64::INFINITY, f64::min) * volumes.sum::<f64>() / spread.trace()
}

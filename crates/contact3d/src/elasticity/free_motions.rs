//! Which rigid motions some held directions leave free, on a body of any shape.

use nalgebra::{Matrix3, Vector3};

/// A direction, a unit vector, in which a place in m is held.
pub(super) type Hold = (Vector3<f64>, Vector3<f64>);

/// A motion u(x) = t + ω × (x − c), as t and ω.
pub(super) type Motion = [Vector3<f64>; 2];

/// Coordinates may be off by this share of the body's extent in their direction: digits of a mesh file.
const DIGITS: f64 = 1e-6;

/// Rounding of a direction and of sums over places, with room.
const ROUNDING: f64 = 1e-12;

/// The motions about c that move no held place along its direction.
///
/// A motion is free where coordinates moved by no more than [`DIGITS`] of `spread` = ⟨(x − c)(x − c)ᵀ⟩ over the body would make it
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
    let still = |i: &usize| directions.eigenvalues[*i] <= ROUNDING * directions.eigenvalues.max();
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
    let noise: Matrix3<f64> = holds
        .iter()
        .map(|(x, n)| uncertainty(&(x - middle), n, spread))
        .sum();
    let turns = hardly_moved(&moved, &noise, spread)
        .into_iter()
        .map(|turn| {
            let at_centre = -undone * turn + turn.cross(&(centre - middle));
            [at_centre, turn]
        });
    let shifts = unheld.into_iter().map(|i| [along(i), Vector3::zeros()]);
    turns.chain(shifts).collect()
}

/// The square of what a rotation ω seems to move a held place by, through coordinates and directions that are not exact, as a
/// quadratic form in ω.
fn uncertainty(arm: &Vector3<f64>, along: &Vector3<f64>, spread: &Matrix3<f64>) -> Matrix3<f64> {
    let across = along.cross_matrix();
    let turned = arm.cross_matrix();
    across.transpose() * spread * across * DIGITS.powi(2)
        + turned.transpose() * turned * ROUNDING.powi(2)
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
    let all = scaled(&(moved + noise)) + Matrix3::identity() * ROUNDING;
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

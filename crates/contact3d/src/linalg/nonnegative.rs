//! Least squares with weights that are not negative, in a few dimensions.

use nalgebra::{DMatrix, DVector};

/// What no combination V c of columns with weights c ≥ 0 reaches of a target t in ℝⁿ: t − V c at the least ‖t − V c‖, and the columns with
/// c > 0, at most n. It is the projection of t on the polar cone of the columns: V_j·(t − V c) ≤ 0 for all j, and V c·(t − V c) = 0.
///
/// The active set method of C. L. Lawson, R. J. Hanson, *Solving Least Squares Problems*, SIAM 1995, chapter 23, with an orthogonal
/// factorisation of the active columns: by normal equations a remainder a billion times smaller than t would lose its direction.
pub(crate) fn nonnegative_least_squares(
    columns: &[DVector<f64>],
    target: &DVector<f64>,
) -> (DVector<f64>, Vec<usize>) {
    let mut remainder = target.clone();
    let mut active: Vec<(usize, f64)> = Vec::new();
    while active.len() < target.len() {
        let is_active = |j: usize| active.iter().any(|(k, _)| *k == j);
        let slope = |j: usize| columns[j].dot(&remainder) / columns[j].norm();
        let inactive = (0..columns.len()).filter(|j| !is_active(*j));
        let steepest = inactive.max_by(|a, b| slope(*a).total_cmp(&slope(*b)));
        // A column orthogonal to the remainder has a slope of rounding.
        let rounding = 4.0 * f64::EPSILON * remainder.norm();
        let Some(entering) = steepest.filter(|j| slope(*j) > rounding) else {
            break;
        };
        let mut trial = active.clone();
        trial.push((entering, 0.0));
        match fit(columns, &mut trial, target) {
            // Each active set is better than the last, so none returns and the method ends.
            Some(next) if next.norm() < remainder.norm() => (remainder, active) = (next, trial),
            _ => break,
        }
    }
    (remainder, active.into_iter().map(|(j, _)| j).collect())
}

/// Moves the weights of active columns to those of least squares; columns whose weights would turn negative on the way leave. Returns
/// the remainder, or `None` where the columns depend on each other.
fn fit(
    columns: &[DVector<f64>],
    active: &mut Vec<(usize, f64)>,
    target: &DVector<f64>,
) -> Option<DVector<f64>> {
    loop {
        let chosen: Vec<DVector<f64>> = active.iter().map(|(j, _)| columns[*j].clone()).collect();
        let (q, r) = DMatrix::from_columns(&chosen).qr().unpack();
        let wanted = r.solve_upper_triangular(&q.tr_mul(target))?;
        // The part of the way after which a weight is zero.
        let until_zero = |(weight, wanted): (f64, f64)| match wanted {
            ..=0.0 => weight / (weight - wanted),
            _ => f64::INFINITY,
        };
        let ways = || {
            active
                .iter()
                .map(|(_, weight)| *weight)
                .zip(wanted.iter().copied())
        };
        let step = ways().map(until_zero).fold(1.0, f64::min);
        *active = active
            .iter()
            .zip(ways())
            .filter(|(_, way)| until_zero(*way) > step)
            .map(|((j, weight), (_, wanted))| (*j, weight + step * (wanted - weight)))
            .collect();
        if active.is_empty() {
            return None;
        }
        if active.len() == wanted.len() {
            let mut remainder = target - &q * q.tr_mul(target);
            // Once more, for a direction that is orthogonal to the columns to rounding of its own length.
            remainder -= &q * q.tr_mul(&remainder);
            return Some(remainder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_remainder_lies_in_the_polar_cone() {
        // A sequence that fills the cube evenly enough: multiples of irrational numbers.
        let value = |k: usize| (k as f64 * 0.754_877_666_246_693).fract() - 0.5;
        for n in 1..=7 {
            for scene in 0..40 {
                let vector =
                    |j: usize| DVector::from_fn(n, |i, _| value(1 + i + 7 * (j + 31 * scene)));
                let columns: Vec<DVector<f64>> = (1..=12).map(vector).collect();
                let target = vector(0);
                let (remainder, active) = nonnegative_least_squares(&columns, &target);
                // Rounding of scalar products of vectors of length one.
                let worst = columns
                    .iter()
                    .map(|v| v.dot(&remainder))
                    .fold(0.0, f64::max);
                assert!(worst < 1e-14, "{n} {scene}: {worst:e}");
                let along = (&target - &remainder).dot(&remainder).abs();
                assert!(along < 1e-14, "{n} {scene}: {along:e}");
                assert!(active.len() <= n);
            }
        }
    }

    #[test]
    fn a_small_remainder_keeps_its_direction() {
        let small = 1e-9;
        let columns = [[1.0, 0.0, -1e-7], [1.0, 1e-7, 0.0], [0.6, -0.8, 0.0]];
        let columns = columns.map(|v| DVector::from_row_slice(&v));
        let target = DVector::from_row_slice(&[1.0, -0.2, small]);
        let (remainder, _) = nonnegative_least_squares(&columns, &target);
        let direction = &remainder / remainder.norm();
        for column in &columns {
            assert!(column.dot(&direction) < 1e-15, "{direction}");
        }
        assert!((remainder.norm() / small - 1.0).abs() < 1e-6, "{remainder}");
    }
}

//! Interval linear algebra of one box: elimination and contraction.

use nalgebra::DMatrix;

use super::interval::{Interval, product};

/// The solutions of a symmetric system for several right-hand sides, `[n_rhs][n]`, by elimination without exchange of rows; `None`
/// where some matrix in the intervals may not be positive definite.
pub(super) fn solve(
    mut matrix: Vec<Vec<Interval>>,
    mut rhs: Vec<Vec<Interval>>,
) -> Option<Vec<Vec<Interval>>> {
    let n = matrix.len();
    for k in 0..n {
        let pivot = matrix[k][k];
        if pivot.low.is_nan() || pivot.low <= 0.0 {
            return None;
        }
        let row = matrix[k].clone();
        for i in k + 1..n {
            let share = matrix[i][k] * pivot.recip();
            for j in k + 1..n {
                matrix[i][j] = matrix[i][j] - share * row[j];
            }
            rhs.iter_mut().for_each(|b| b[i] = b[i] - share * b[k]);
        }
    }
    for b in &mut rhs {
        for k in (0..n).rev() {
            let known = product(&matrix[k][k + 1..], &b[k + 1..]);
            b[k] = (b[k] - known) * matrix[k][k].recip();
        }
    }
    Some(rhs)
}

/// What a box has in common with the solutions of F = 0 in it, by a step of the method of Gauss and Seidel on F(m) + F'(box)(x − m),
/// multiplied by the inverse of the middle of F'.
pub(super) enum Narrowed {
    /// There is none.
    Empty,
    /// Exactly one, and it lies here.
    Proven(Vec<Interval>),
    /// All lie here.
    Rest(Vec<Interval>),
}

/// One such step, from F at the middle of a box and F' over it. If every component of the result lies inside of the box, then every F' in
/// the intervals is regular and there is exactly one solution (A. Neumaier, *Interval Methods for Systems of PieceEquations*, 1990, §5.1).
pub(super) fn narrow(
    region: &[Interval],
    at_middle: &[Interval],
    derivative: &[Vec<Interval>],
) -> Narrowed {
    let n = region.len();
    let middle = DMatrix::from_fn(n, n, |i, j| derivative[i][j].middle());
    let mut now = region.to_vec();
    let Some(inverse) = middle.try_inverse() else {
        return Narrowed::Rest(now);
    };
    let mut is_proven = true;
    for i in 0..n {
        let row: Vec<Interval> = (0..n).map(|k| Interval::point(inverse[(i, k)])).collect();
        let entry = |j: usize| -> Interval { (0..n).map(|k| row[k] * derivative[k][j]).sum() };
        let mut known = product(&row, at_middle);
        for j in (0..n).filter(|j| *j != i) {
            known = known + entry(j) * (now[j] - Interval::point(region[j].middle()));
        }
        let Some(quotient) = known.over(entry(i)) else {
            is_proven = false;
            continue;
        };
        let found = Interval::point(region[i].middle()) - quotient;
        is_proven &= found.is_strictly_inside(region[i]);
        match now[i].meet(found) {
            Some(both) => now[i] = both,
            None => return Narrowed::Empty,
        }
    }
    if is_proven {
        Narrowed::Proven(now)
    } else {
        Narrowed::Rest(now)
    }
}

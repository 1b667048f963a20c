//! Sticking and open panes, eliminated.

use super::{
    interval::{Interval, product},
    linear::solve,
    small_problem::{Affine, SmallProblem},
};

/// λ of sticking panes as it follows from r = 0 there and from λ of slipping panes; zero on open ones.
pub(super) struct Eliminated<'a> {
    stuck: &'a [usize],
    sliding: &'a [usize],
    /// S_TT⁻¹ h_T, then the columns of S_TT⁻¹ S_TL.
    solved: Vec<Vec<Interval>>,
}

impl<'a> Eliminated<'a> {
    /// From the components that stick and those that slide; `None` where S_TT cannot be told to be positive definite.
    pub(super) fn new(
        problem: &SmallProblem,
        stuck: &'a [usize],
        sliding: &'a [usize],
    ) -> Option<Self> {
        let block = |j: usize| stuck.iter().map(|i| problem.operator[*i][j]).collect();
        let rhs = stuck.iter().map(|i| problem.rhs[*i]).collect();
        let columns = std::iter::once(rhs).chain(sliding.iter().map(|j| block(*j)));
        let solved = solve(square(problem, stuck), columns.collect())?;
        Some(Self {
            stuck,
            sliding,
            solved,
        })
    }

    /// λ_j.
    pub(super) fn multiplier(&self, j: usize) -> Affine {
        self.applied(|i| {
            if i == j {
                Interval::ONE
            } else {
                Interval::ZERO
            }
        })
    }

    /// Σ a_j λ_j.
    pub(super) fn applied(&self, row: impl Fn(usize) -> Interval) -> Affine {
        let on_stuck: Vec<Interval> = self.stuck.iter().map(|j| row(*j)).collect();
        let slope = self.sliding.iter().zip(&self.solved[1..]);
        Affine {
            constant: product(&on_stuck, &self.solved[0]),
            slope: slope
                .map(|(j, column)| row(*j) - product(&on_stuck, column))
                .collect(),
        }
    }
}

/// Bounds of |λ_j| in all solutions in which only given components carry anything, `[3m]`: λᵀr ≤ 0, so λᵀSλ ≤ λᵀh and
/// λ_j² ≤ (S⁻¹)_jj hᵀS⁻¹h.
pub(super) fn largest_multipliers(problem: &SmallProblem, closed: &[usize]) -> Option<Vec<f64>> {
    let n = closed.len();
    let rhs: Vec<Interval> = closed.iter().map(|i| problem.rhs[*i]).collect();
    let unit = |k: usize| -> Vec<Interval> {
        let entries = (0..n).map(|i| {
            if i == k {
                Interval::ONE
            } else {
                Interval::ZERO
            }
        });
        entries.collect()
    };
    let columns = (0..n).map(unit).chain([rhs.clone()]).collect();
    let solved = solve(square(problem, closed), columns)?;
    let energy = product(&rhs, &solved[n]);
    let mut largest = vec![0.0; problem.rhs.len()];
    for (k, j) in closed.iter().enumerate() {
        largest[*j] = (energy * solved[k][k]).sqrt().high;
    }
    Some(largest)
}

fn square(problem: &SmallProblem, rows: &[usize]) -> Vec<Vec<Interval>> {
    let row = |i: &usize| rows.iter().map(|j| problem.operator[*i][*j]).collect();
    rows.iter().map(row).collect()
}

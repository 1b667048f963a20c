//! What closed panes carry, given the slips.

use super::{
    interval::{Interval, product},
    linear::solve,
    small_problem::{Affine, SmallProblem},
};

/// λ = S⁻¹(h − v) on the components that close, with v = −r the slips of some of them; zero on others.
pub(super) struct Closed<'a> {
    components: &'a [usize],
    sliding: usize,
    /// S⁻¹ h, then the columns of S⁻¹ of the components that slide.
    solved: Vec<Vec<Interval>>,
    /// hᵀ S⁻¹ h.
    energy: Interval,
}

impl<'a> Closed<'a> {
    /// From the components that close and those that slide; `None` where S cannot be told to be positive definite.
    pub(super) fn new(
        problem: &SmallProblem,
        components: &'a [usize],
        sliding: &[usize],
    ) -> Option<Self> {
        let row = |i: &usize| {
            components
                .iter()
                .map(|j| problem.operator[*i][*j])
                .collect()
        };
        let rhs: Vec<Interval> = components.iter().map(|i| problem.rhs[*i]).collect();
        let unit = |j: &usize| {
            let entries = components.iter().map(|i| match i == j {
                true => Interval::ONE,
                false => Interval::ZERO,
            });
            entries.collect()
        };
        let columns = std::iter::once(rhs.clone()).chain(sliding.iter().map(unit));
        let solved = solve(components.iter().map(row).collect(), columns.collect())?;
        Some(Self {
            components,
            sliding: sliding.len(),
            energy: product(&rhs, &solved[0]),
            solved,
        })
    }

    /// Σ a_j λ_j by the slips.
    pub(super) fn applied(&self, row: impl Fn(usize) -> Interval) -> Affine {
        let row: Vec<Interval> = self.components.iter().map(|j| row(*j)).collect();
        let columns = self.solved[1..=self.sliding].iter();
        Affine {
            constant: product(&row, &self.solved[0]),
            slope: columns.map(|column| -product(&row, column)).collect(),
        }
    }

    /// The most that a component of a solution slips: λᵀr ≤ 0, so rᵀS⁻¹r ≤ hᵀS⁻¹h and r_i² ≤ S_ii hᵀS⁻¹h.
    pub(super) fn most(&self, diagonal: Interval) -> f64 {
        (diagonal * self.energy).sqrt().high
    }
}

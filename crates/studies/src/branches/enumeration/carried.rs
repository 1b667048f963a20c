//! What closed panes carry, given slips or stresses of those that slip.

use super::{
    interval::{Interval, product},
    linear::solve,
    small_problem::{Affine, SmallProblem},
};

/// λ of some components from r there and sources: r of slipping panes, or their λ.
pub(super) struct Carried<'a> {
    components: &'a [usize],
    /// The components whose λ are the sources, if they are.
    given: &'a [usize],
    /// S⁻¹h on the components, then S⁻¹ times the column of each source.
    solved: Vec<Vec<Interval>>,
}

impl<'a> Carried<'a> {
    /// λ = S⁻¹(h − v) on all closed components, by the slips v of some; `None` where S cannot be told to be positive definite.
    pub(super) fn by_slips(
        problem: &SmallProblem,
        closed: &'a [usize],
        sliding: &[usize],
    ) -> Option<Self> {
        Self::new(problem, closed, sliding, &[], |i, j| unit(i)(j))
    }

    /// λ = S⁻¹(h − S λ) on sticking components, by λ of sliding ones.
    pub(super) fn by_stresses(
        problem: &SmallProblem,
        stuck: &'a [usize],
        sliding: &'a [usize],
    ) -> Option<Self> {
        Self::new(problem, stuck, sliding, sliding, |i, j| {
            problem.operator[i][j]
        })
    }

    fn new(
        problem: &SmallProblem,
        components: &'a [usize],
        sources: &[usize],
        given: &'a [usize],
        entry: impl Fn(usize, usize) -> Interval,
    ) -> Option<Self> {
        let of = |entry: &dyn Fn(usize) -> Interval| components.iter().map(|i| entry(*i)).collect();
        let matrix = components.iter().map(|i| of(&|j| problem.operator[*i][j]));
        let columns = sources.iter().map(|j| of(&|i| entry(i, *j)));
        let columns = std::iter::once(of(&|i| problem.rhs[i])).chain(columns);
        Some(Self {
            components,
            given,
            solved: solve(matrix.collect(), columns.collect())?,
        })
    }

    /// Σ a_j λ_j by the sources.
    pub(super) fn applied(&self, row: impl Fn(usize) -> Interval) -> Affine {
        let here: Vec<Interval> = self.components.iter().map(|j| row(*j)).collect();
        let columns = self.solved[1..].iter().enumerate();
        let slope = columns.map(|(k, column)| {
            let own = self.given.get(k).map_or(Interval::ZERO, |j| row(*j));
            own - product(&here, column)
        });
        Affine {
            constant: product(&here, &self.solved[0]),
            slope: slope.collect(),
        }
    }
}

/// The row that takes component i.
pub(super) fn unit(i: usize) -> impl Fn(usize) -> Interval {
    move |j| {
        if i == j {
            Interval::ONE
        } else {
            Interval::ZERO
        }
    }
}

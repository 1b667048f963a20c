//! Forward and backward substitution along the elimination tree, for one right-hand side or a block of them.

use std::{ops::Range, sync::Mutex};

use super::{
    cholesky::CholeskyFactor,
    panel_solve::{backward, forward},
    precision::Scalar,
    structure::{FactorStructure, Front},
    tasks::{SubtreeTask, ascend, descend, locked, split},
    vector::{power_of_two_near_largest, vectorised},
};

/// Right-hand sides solved together: in single precision one vector register holds a row of them.
const SHARED_SOLVES: usize = 8;

impl FactorStructure {
    /// The elimination tree in tasks of a solve; below 1e5 coefficients one thread is faster than several.
    fn solve_tasks(&self) -> Vec<SubtreeTask> {
        let few = 1e5 / self.value_count().max(1) as f64;
        let coefficients = |front: Front<'_>| (front.width * front.rows.len()) as f64;
        self.tasks(coefficients, few.max(1.0 / 16.0))
    }
}

impl<T: Scalar> CholeskyFactor<T> {
    /// Solves A x = b in place, in the precision of the factor: x = Pᵀ L⁻ᵀ L⁻¹ P b.
    ///
    /// Subtrees of the elimination tree are solved side by side, their sums in one order: the solution has the same bits at
    /// any number of threads.
    ///
    /// # Panics
    /// When `rhs` does not have one entry per unknown.
    pub fn solve_in_place(&self, rhs: &mut [f64]) {
        self.solve_block::<1>(&mut [rhs], None, &Mutex::default());
    }

    /// Solves A x = b in place on the unknowns of the reached supernodes only.
    ///
    /// b must be zero outside the rows that `reach` was made from ([`FactorStructure::reach`]). On return all unknowns of the reached
    /// supernodes hold the solution; other entries of `rhs` are zero.
    ///
    /// # Panics
    /// When `rhs` does not have one entry per unknown or `reach` is from a larger factor.
    pub(crate) fn solve_reached(&self, reach: &[usize], rhs: &mut [f64]) {
        self.solve_block::<1>(&mut [rhs], Some(reach), &Mutex::default());
    }

    /// Solves for several right-hand sides, eight at a time: reading the factor takes most of the time of a solve.
    ///
    /// # Panics
    /// As [`Self::solve_in_place`].
    pub(super) fn solve_several(&self, rhs: &mut [&mut [f64]]) {
        if let [one] = rhs {
            return self.solve_in_place(one);
        }
        let memory = Mutex::default();
        for block in rhs.chunks_mut(SHARED_SOLVES) {
            self.solve_block::<SHARED_SOLVES>(block, None, &memory);
        }
    }

    /// Solves for at most N right-hand sides, each in a power of two near its largest entry.
    fn solve_block<const N: usize>(
        &self,
        block: &mut [&mut [f64]],
        reach: Option<&[usize]>,
        memory: &Mutex<Vec<Vec<[T; N]>>>,
    ) {
        let unit = |rhs: &&mut [f64]| {
            assert_eq!(rhs.len(), self.size(), "length of a right-hand side");
            power_of_two_near_largest(rhs)
        };
        let units: Vec<Option<f64>> = block.iter().map(unit).collect();
        if units.iter().all(Option::is_none) {
            return;
        }
        let units: Vec<f64> = units.iter().map(|unit| unit.unwrap_or(1.0)).collect();
        let permutation = &self.structure.permutation;
        let mut permuted = vec![[T::default(); N]; self.size()];
        for (row, &old) in permuted.iter_mut().zip(permutation) {
            for ((unknown, rhs), unit) in row.iter_mut().zip(&*block).zip(&units) {
                *unknown = T::rounded(rhs[old] / unit);
            }
        }
        let solve = TreeSolve {
            factor: self,
            tasks: &self.structure.solve_tasks(),
            reach,
            memory,
        };
        solve.forward(&mut permuted);
        solve.backward(&mut permuted);
        for (&old, row) in permutation.iter().zip(&permuted) {
            for ((unknown, rhs), unit) in row.iter().zip(&mut *block).zip(&units) {
                rhs[old] = unknown.to_double() * unit;
            }
        }
    }

    /// L⁻¹ on the unknowns over the given ascending supernodes.
    fn forward<const N: usize>(
        &self,
        supernodes: impl Iterator<Item = usize>,
        unknowns: &mut [[T; N]],
    ) {
        let mut sums = Vec::new();
        vectorised(
            #[inline(always)]
            || {
                for s in supernodes {
                    let (front, values) = self.panel(s);
                    let columns = self.structure.columns(s);
                    sums.clear();
                    sums.extend_from_slice(&unknowns[columns.clone()]);
                    sums.resize(front.rows.len(), [T::default(); N]);
                    forward(values, front.width, &mut sums);
                    unknowns[columns].copy_from_slice(&sums[..front.width]);
                    for (&row, sum) in front.below().iter().zip(&sums[front.width..]) {
                        add(&mut unknowns[row], sum);
                    }
                }
            },
        );
    }

    /// L⁻ᵀ on the unknowns over the given descending supernodes.
    fn backward<const N: usize>(
        &self,
        supernodes: impl Iterator<Item = usize>,
        unknowns: &mut [[T; N]],
    ) {
        let mut known = Vec::new();
        vectorised(
            #[inline(always)]
            || {
                for s in supernodes {
                    let (front, values) = self.panel(s);
                    known.clear();
                    known.extend(front.rows.iter().map(|&row| unknowns[row]));
                    backward(values, front.width, &mut known);
                    unknowns[self.structure.columns(s)].copy_from_slice(&known[..front.width]);
                }
            },
        );
    }
}

#[inline(always)]
fn add<T: Scalar, const N: usize>(row: &mut [T; N], other: &[T; N]) {
    for i in 0..N {
        row[i] += other[i];
    }
}

/// Substitution along the elimination tree, subtrees side by side.
struct TreeSolve<'a, T, const N: usize> {
    factor: &'a CholeskyFactor<T>,
    tasks: &'a [SubtreeTask],
    /// The supernodes to visit, ascending, with each all above it; `None` for all.
    reach: Option<&'a [usize]>,
    /// Vectors of all unknowns that no thread uses now; only entries that a task has written mean something.
    memory: &'a Mutex<Vec<Vec<[T; N]>>>,
}

impl<T: Scalar, const N: usize> TreeSolve<'_, T, N> {
    /// L⁻¹ in place: every task passes what it subtracts from the rows below it to its parent.
    fn forward(&self, unknowns: &mut [[T; N]]) {
        let own = split(
            self.tasks,
            &self.factor.structure.supernode_columns,
            unknowns,
        );
        let updates: Vec<Mutex<Vec<[T; N]>>> =
            self.tasks.iter().map(|_| Mutex::default()).collect();
        ascend(self.tasks, |k| {
            let mut own = locked(&own[k]);
            self.with_unknowns(|unknowns| {
                let columns = self.columns(k);
                unknowns[columns.clone()].copy_from_slice(&own);
                for &row in self.below(k) {
                    unknowns[row] = [T::default(); N];
                }
                for &child in &self.tasks[k].children {
                    let update = std::mem::take(&mut *locked(&updates[child]));
                    for (&row, value) in self.below(child).iter().zip(update) {
                        add(&mut unknowns[row], &value);
                    }
                }
                self.factor.forward(self.supernodes(k), unknowns);
                own.copy_from_slice(&unknowns[columns]);
                *locked(&updates[k]) = self.values_below(k, unknowns);
            });
            true
        });
    }

    /// L⁻ᵀ in place: every task passes the unknowns that its children need to them.
    fn backward(&self, unknowns: &mut [[T; N]]) {
        let own = split(
            self.tasks,
            &self.factor.structure.supernode_columns,
            unknowns,
        );
        let known: Vec<Mutex<Vec<[T; N]>>> = self.tasks.iter().map(|_| Mutex::default()).collect();
        descend(self.tasks, |k| {
            let mut own = locked(&own[k]);
            self.with_unknowns(|unknowns| {
                let columns = self.columns(k);
                unknowns[columns.clone()].copy_from_slice(&own);
                let known_here = std::mem::take(&mut *locked(&known[k]));
                for (&row, value) in self.below(k).iter().zip(known_here) {
                    unknowns[row] = value;
                }
                self.factor.backward(self.supernodes(k).rev(), unknowns);
                own.copy_from_slice(&unknowns[columns]);
                for &child in &self.tasks[k].children {
                    *locked(&known[child]) = self.values_below(child, unknowns);
                }
            });
        });
    }

    /// The supernodes of a task that the solve visits, ascending.
    fn supernodes(&self, k: usize) -> impl DoubleEndedIterator<Item = usize> {
        let range = self.tasks[k].supernodes.clone();
        let (all, reached) = match self.reach {
            None => (range, &[][..]),
            Some(reach) => {
                let [first, end] =
                    [range.start, range.end].map(|s| reach.partition_point(|r| *r < s));
                (0..0, &reach[first..end])
            }
        };
        all.chain(reached.iter().copied())
    }

    fn columns(&self, k: usize) -> Range<usize> {
        let columns = &self.factor.structure.supernode_columns;
        let supernodes = &self.tasks[k].supernodes;
        columns[supernodes.start]..columns[supernodes.end]
    }

    /// The rows that a task shares with its ancestors.
    fn below(&self, k: usize) -> &[usize] {
        let last = self.tasks[k].supernodes.end - 1;
        self.factor.structure.front(last).below()
    }

    fn values_below(&self, k: usize, unknowns: &[[T; N]]) -> Vec<[T; N]> {
        self.below(k).iter().map(|&row| unknowns[row]).collect()
    }

    fn with_unknowns(&self, run: impl FnOnce(&mut [[T; N]])) {
        let mut unknowns = locked(self.memory).pop().unwrap_or_default();
        unknowns.resize(self.factor.size(), [T::default(); N]);
        run(&mut unknowns);
        locked(self.memory).push(unknowns);
    }
}

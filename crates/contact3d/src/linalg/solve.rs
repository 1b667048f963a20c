//! Forward and backward substitution along the elimination tree, for one right-hand side or a block of them.

use std::{ops::Range, sync::Mutex};

use super::{
    analysis::FactorStructure,
    factor::CholeskyFactor,
    fronts::{SubtreeTask, ascend, descend, locked, split},
    panel_solve::{backward, forward},
    precision::Scalar,
    vector::{power_of_two_near_largest, vectorised},
};

/// Right-hand sides solved together: in single precision one vector register holds a row of them.
const SEVERAL: usize = 8;

/// Memory of solves, kept between calls.
#[derive(Debug, Default)]
pub struct Workspace {
    pub(super) single: ScratchPool<f32, 1>,
    pub(super) double: ScratchPool<f64, 1>,
}

/// One scratch memory for each thread at work.
#[derive(Debug, Default)]
pub struct ScratchPool<T, const N: usize>(Mutex<Vec<Scratch<T, N>>>);

/// Memory of a solve of N right-hand sides on some supernodes.
#[derive(Debug, Default)]
pub(super) struct Scratch<T, const N: usize> {
    /// The unknowns, in the new numbering; only those that the supernodes touch mean something.
    pub(super) unknowns: Vec<[T; N]>,
    /// The part of them that one supernode touches.
    panel: Vec<[T; N]>,
}

impl<T: Copy + Default, const N: usize> ScratchPool<T, N> {
    pub(super) fn take(&self, unknowns: usize) -> Scratch<T, N> {
        let mut scratch = locked(&self.0).pop().unwrap_or_default();
        scratch.unknowns.resize(unknowns, [T::default(); N]);
        scratch
    }

    pub(super) fn put(&self, scratch: Scratch<T, N>) {
        locked(&self.0).push(scratch);
    }
}

/// A subtree of less than this share of the coefficients is one task.
const SMALLEST_SHARE: f64 = 1.0 / 16.0;

/// Below this many coefficients one thread is faster than several.
const FEW: f64 = 1e5;

impl FactorStructure {
    /// The elimination tree in tasks of a solve.
    fn solve_tasks(&self) -> Vec<SubtreeTask> {
        let few = FEW / self.value_count().max(1) as f64;
        self.tasks(
            |front| (front.width * front.rows.len()) as f64,
            SMALLEST_SHARE.max(few),
        )
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
    pub fn solve_in_place(&self, rhs: &mut [f64], work: &mut Workspace) {
        self.solve_block(&mut [rhs], Supernodes::All, T::scratch(work));
    }

    /// Solves A x = b in place on the unknowns of the reached supernodes only.
    ///
    /// b must be zero outside the rows that `reach` was made from ([`FactorStructure::reach`]). On return all unknowns of the reached
    /// supernodes hold the solution; other entries of `rhs` are zero.
    ///
    /// # Panics
    /// When `rhs` does not have one entry per unknown or `reach` is from a larger factor.
    pub(crate) fn solve_reached(&self, reach: &[usize], rhs: &mut [f64], work: &mut Workspace) {
        self.solve_block(&mut [rhs], Supernodes::Reached(reach), T::scratch(work));
    }

    /// Solves for several right-hand sides, eight at a time: reading the factor takes most of the time of a solve.
    ///
    /// # Panics
    /// As [`Self::solve_in_place`].
    pub(super) fn solve_several(&self, rhs: &mut [&mut [f64]], work: &mut Workspace) {
        if let [one] = rhs {
            return self.solve_in_place(one, work);
        }
        let pool = ScratchPool::<T, SEVERAL>::default();
        for block in rhs.chunks_mut(SEVERAL) {
            self.solve_block(block, Supernodes::All, &pool);
        }
    }

    /// Solves for at most N right-hand sides, each in a power of two near its largest entry.
    fn solve_block<const N: usize>(
        &self,
        block: &mut [&mut [f64]],
        supernodes: Supernodes<'_>,
        pool: &ScratchPool<T, N>,
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
        let mut permuted = pool.take(self.size());
        for (row, &old) in permuted.unknowns.iter_mut().zip(permutation) {
            for ((unknown, rhs), unit) in row.iter_mut().zip(&*block).zip(&units) {
                *unknown = T::rounded(rhs[old] / unit);
            }
        }
        let solve = TreeSolve {
            factor: self,
            tasks: &self.structure.solve_tasks(),
            supernodes,
            pool,
        };
        solve.forward(&mut permuted.unknowns);
        solve.backward(&mut permuted.unknowns);
        for (&old, row) in permutation.iter().zip(&permuted.unknowns) {
            for ((unknown, rhs), unit) in row.iter().zip(&mut *block).zip(&units) {
                rhs[old] = unknown.to_double() * unit;
            }
        }
        pool.put(permuted);
    }

    /// L⁻¹ on the unknowns over the given ascending supernodes.
    pub(super) fn forward<const N: usize>(
        &self,
        supernodes: impl Iterator<Item = usize>,
        scratch: &mut Scratch<T, N>,
    ) {
        let Scratch {
            unknowns,
            panel: sums,
        } = scratch;
        vectorised(
            #[inline(always)]
            || {
                for s in supernodes {
                    let (front, values) = self.panel(s);
                    let columns = self.structure.columns(s);
                    sums.clear();
                    sums.extend_from_slice(&unknowns[columns.clone()]);
                    sums.resize(front.rows.len(), [T::default(); N]);
                    forward(values, front.width, sums);
                    unknowns[columns].copy_from_slice(&sums[..front.width]);
                    for (&row, sum) in front.below().iter().zip(&sums[front.width..]) {
                        add(&mut unknowns[row], sum);
                    }
                }
            },
        );
    }

    /// L⁻ᵀ on the unknowns over the given descending supernodes.
    pub(super) fn backward<const N: usize>(
        &self,
        supernodes: impl Iterator<Item = usize>,
        scratch: &mut Scratch<T, N>,
    ) {
        let Scratch {
            unknowns,
            panel: known,
        } = scratch;
        vectorised(
            #[inline(always)]
            || {
                for s in supernodes {
                    let (front, values) = self.panel(s);
                    known.clear();
                    known.extend(front.rows.iter().map(|&row| unknowns[row]));
                    backward(values, front.width, known);
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

/// What a solve visits.
#[derive(Clone, Copy)]
enum Supernodes<'a> {
    All,
    /// Ascending, and with each all above it.
    Reached(&'a [usize]),
}

impl Supernodes<'_> {
    /// Those of a range, ascending.
    fn within(self, range: Range<usize>) -> impl DoubleEndedIterator<Item = usize> {
        let (all, reached) = match self {
            Self::All => (range, &[][..]),
            Self::Reached(reach) => {
                let [first, end] =
                    [range.start, range.end].map(|s| reach.partition_point(|r| *r < s));
                (0..0, &reach[first..end])
            }
        };
        all.chain(reached.iter().copied())
    }
}

/// Substitution along the elimination tree, subtrees side by side.
struct TreeSolve<'a, T, const N: usize> {
    factor: &'a CholeskyFactor<T>,
    tasks: &'a [SubtreeTask],
    supernodes: Supernodes<'a>,
    pool: &'a ScratchPool<T, N>,
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
            self.with_scratch(|scratch| {
                let columns = self.columns(k);
                scratch.unknowns[columns.clone()].copy_from_slice(&own);
                self.below(k)
                    .iter()
                    .for_each(|&row| scratch.unknowns[row] = [T::default(); N]);
                for &child in &self.tasks[k].children {
                    let update = std::mem::take(&mut *locked(&updates[child]));
                    for (&row, value) in self.below(child).iter().zip(update) {
                        add(&mut scratch.unknowns[row], &value);
                    }
                }
                self.factor.forward(self.supernodes(k), scratch);
                own.copy_from_slice(&scratch.unknowns[columns]);
                *locked(&updates[k]) = self.values_below(k, scratch);
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
            self.with_scratch(|scratch| {
                let columns = self.columns(k);
                scratch.unknowns[columns.clone()].copy_from_slice(&own);
                let known_here = std::mem::take(&mut *locked(&known[k]));
                for (&row, value) in self.below(k).iter().zip(known_here) {
                    scratch.unknowns[row] = value;
                }
                self.factor.backward(self.supernodes(k).rev(), scratch);
                own.copy_from_slice(&scratch.unknowns[columns]);
                for &child in &self.tasks[k].children {
                    *locked(&known[child]) = self.values_below(child, scratch);
                }
            });
        });
    }

    /// The supernodes of a task that the solve visits.
    fn supernodes(&self, k: usize) -> impl DoubleEndedIterator<Item = usize> {
        self.supernodes.within(self.tasks[k].supernodes.clone())
    }

    fn columns(&self, k: usize) -> Range<usize> {
        let columns = &self.factor.structure.supernode_columns;
        let supernodes = &self.tasks[k].supernodes;
        columns[supernodes.start]..columns[supernodes.end]
    }

    /// The rows that a task shares with its ancestors.
    fn below(&self, k: usize) -> &[usize] {
        self.factor
            .structure
            .front(self.tasks[k].supernodes.end - 1)
            .below()
    }

    fn values_below(&self, k: usize, scratch: &Scratch<T, N>) -> Vec<[T; N]> {
        self.below(k)
            .iter()
            .map(|&row| scratch.unknowns[row])
            .collect()
    }

    fn with_scratch(&self, run: impl FnOnce(&mut Scratch<T, N>)) {
        let mut scratch = self.pool.take(self.factor.size());
        run(&mut scratch);
        self.pool.put(scratch);
    }
}

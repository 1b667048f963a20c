//! Forward and backward substitution with one right-hand side, along the elimination tree.

use std::ops::Range;
use std::sync::Mutex;

use super::factor::CholeskyFactor;
use super::fronts::{Task, climb, descend, locked};
use super::scalar::Scalar;
use super::structure::FactorStructure;
use super::unknown::{SEVERAL, Several, Unknown};
use super::vector::{power_of_two_near_largest, vectorised};

/// Memory of solves, kept between calls.
#[derive(Debug, Default)]
pub struct Workspace {
    pub(super) single: ScratchPool<f32>,
    pub(super) double: ScratchPool<f64>,
}

/// One scratch memory for each thread at work.
#[derive(Debug, Default)]
pub struct ScratchPool<V>(Mutex<Vec<Scratch<V>>>);

/// Memory of a solve on some supernodes.
#[derive(Debug, Default)]
pub(super) struct Scratch<V> {
    /// The unknowns, in the new numbering; only those that the supernodes touch mean something.
    pub(super) unknowns: Vec<V>,
    /// The part of them that one supernode touches.
    panel: Vec<V>,
}

impl<V: Copy + Default> ScratchPool<V> {
    pub(super) fn take(&self, unknowns: usize) -> Scratch<V> {
        let mut scratch = locked(&self.0).pop().unwrap_or_default();
        scratch.unknowns.resize(unknowns, V::default());
        scratch
    }

    pub(super) fn put(&self, scratch: Scratch<V>) {
        locked(&self.0).push(scratch);
    }
}

/// A subtree of less than this share of the coefficients is one task.
const SMALLEST_SHARE: f64 = 1.0 / 16.0;

/// Below this many coefficients one thread is faster than several.
const FEW: f64 = 1e5;

impl FactorStructure {
    /// The elimination tree in tasks of a solve.
    fn solve_tasks(&self) -> Vec<Task> {
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
        assert_eq!(rhs.len(), self.size(), "length of the right-hand side");
        let Some(scale) = power_of_two_near_largest(rhs) else {
            return;
        };
        let permutation = &self.structure.permutation;
        let pool = T::scratch(work);
        let mut permuted = pool.take(self.size());
        for (unknown, &old) in permuted.unknowns.iter_mut().zip(permutation) {
            *unknown = T::rounded(rhs[old] / scale);
        }
        self.substitute(&mut permuted.unknowns, pool);
        for (&old, value) in permutation.iter().zip(&permuted.unknowns) {
            rhs[old] = value.to_double() * scale;
        }
        pool.put(permuted);
    }

    /// Solves for several right-hand sides, eight at a time: reading the factor takes most of the time of a solve.
    ///
    /// # Panics
    /// As [`Self::solve_in_place`].
    pub(crate) fn solve_several(&self, rhs: &mut [&mut [f64]]) {
        let permutation = &self.structure.permutation;
        let pool = ScratchPool::<Several<T>>::default();
        for block in rhs.chunks_mut(SEVERAL) {
            let scales: Vec<f64> = block
                .iter()
                .map(|rhs| {
                    assert_eq!(rhs.len(), self.size(), "length of a right-hand side");
                    power_of_two_near_largest(rhs).unwrap_or(1.0)
                })
                .collect();
            let mut permuted = pool.take(self.size());
            for (unknown, &old) in permuted.unknowns.iter_mut().zip(permutation) {
                let values = block.iter().zip(&scales);
                for (unknown, (rhs, scale)) in unknown.0.iter_mut().zip(values) {
                    *unknown = T::rounded(rhs[old] / scale);
                }
            }
            self.substitute(&mut permuted.unknowns, &pool);
            for (&old, values) in permutation.iter().zip(&permuted.unknowns) {
                for ((rhs, scale), value) in block.iter_mut().zip(&scales).zip(values.0) {
                    rhs[old] = value.to_double() * scale;
                }
            }
            pool.put(permuted);
        }
    }

    /// L⁻ᵀ L⁻¹ in place, in the new numbering.
    fn substitute<V: Unknown<T>>(&self, unknowns: &mut [V], pool: &ScratchPool<V>) {
        let solve = TreeSolve {
            factor: self,
            tasks: &self.structure.solve_tasks(),
            pool,
        };
        solve.forward(unknowns);
        solve.backward(unknowns);
    }

    /// L⁻¹ on the unknowns over the given ascending supernodes.
    pub(super) fn forward<V: Unknown<T>>(
        &self,
        supernodes: impl Iterator<Item = usize>,
        scratch: &mut Scratch<V>,
    ) {
        let Scratch {
            unknowns,
            panel: sums,
        } = scratch;
        vectorised(
            #[inline(always)]
            || {
                for s in supernodes {
                    let panel = self.panel(s);
                    let (own, below) = panel.rows.split_at(panel.width);
                    let columns = panel.first..panel.first + own.len();
                    sums.clear();
                    sums.extend_from_slice(&unknowns[columns.clone()]);
                    sums.resize(panel.rows.len(), V::default());
                    panel.forward(sums);
                    unknowns[columns].copy_from_slice(&sums[..own.len()]);
                    for (&row, &sum) in below.iter().zip(&sums[own.len()..]) {
                        unknowns[row] += sum;
                    }
                }
            },
        );
    }

    /// L⁻ᵀ on the unknowns over the given descending supernodes.
    pub(super) fn backward<V: Unknown<T>>(
        &self,
        supernodes: impl Iterator<Item = usize>,
        scratch: &mut Scratch<V>,
    ) {
        let Scratch {
            unknowns,
            panel: known,
        } = scratch;
        vectorised(
            #[inline(always)]
            || {
                for s in supernodes {
                    let panel = self.panel(s);
                    let columns = panel.first..panel.first + panel.width;
                    known.clear();
                    known.extend(panel.rows.iter().map(|&row| unknowns[row]));
                    panel.backward(known);
                    unknowns[columns].copy_from_slice(&known[..panel.width]);
                }
            },
        );
    }
}

/// Substitution along the elimination tree, subtrees side by side.
struct TreeSolve<'a, T, V> {
    factor: &'a CholeskyFactor<T>,
    tasks: &'a [Task],
    pool: &'a ScratchPool<V>,
}

impl<T: Scalar, V: Unknown<T>> TreeSolve<'_, T, V> {
    /// L⁻¹ in place: every task passes what it subtracts from the rows below it to its parent.
    fn forward(&self, unknowns: &mut [V]) {
        let own = self.split(unknowns);
        let updates: Vec<Mutex<Vec<V>>> = self.tasks.iter().map(|_| Mutex::default()).collect();
        climb(self.tasks, |k| {
            let mut own = locked(&own[k]);
            self.with_scratch(|scratch| {
                let columns = self.columns(k);
                scratch.unknowns[columns.clone()].copy_from_slice(&own);
                self.below(k)
                    .iter()
                    .for_each(|&row| scratch.unknowns[row] = V::default());
                for &child in &self.tasks[k].children {
                    let update = std::mem::take(&mut *locked(&updates[child]));
                    for (&row, value) in self.below(child).iter().zip(update) {
                        scratch.unknowns[row] += value;
                    }
                }
                self.factor
                    .forward(self.tasks[k].supernodes.clone(), scratch);
                own.copy_from_slice(&scratch.unknowns[columns]);
                *locked(&updates[k]) = self.values_below(k, scratch);
            });
            true
        });
    }

    /// L⁻ᵀ in place: every task passes the unknowns that its children need to them.
    fn backward(&self, unknowns: &mut [V]) {
        let own = self.split(unknowns);
        let known: Vec<Mutex<Vec<V>>> = self.tasks.iter().map(|_| Mutex::default()).collect();
        descend(self.tasks, |k| {
            let mut own = locked(&own[k]);
            self.with_scratch(|scratch| {
                let columns = self.columns(k);
                scratch.unknowns[columns.clone()].copy_from_slice(&own);
                let known_here = std::mem::take(&mut *locked(&known[k]));
                for (&row, value) in self.below(k).iter().zip(known_here) {
                    scratch.unknowns[row] = value;
                }
                self.factor
                    .backward(self.tasks[k].supernodes.clone().rev(), scratch);
                own.copy_from_slice(&scratch.unknowns[columns]);
                for &child in &self.tasks[k].children {
                    *locked(&known[child]) = self.values_below(child, scratch);
                }
            });
        });
    }

    /// The unknowns of each task.
    fn split<'x>(&self, unknowns: &'x mut [V]) -> Vec<Mutex<&'x mut [V]>> {
        let mut rest = unknowns;
        (0..self.tasks.len())
            .map(|k| {
                let (own, next) = std::mem::take(&mut rest).split_at_mut(self.columns(k).len());
                rest = next;
                Mutex::new(own)
            })
            .collect()
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

    fn values_below(&self, k: usize, scratch: &Scratch<V>) -> Vec<V> {
        self.below(k)
            .iter()
            .map(|&row| scratch.unknowns[row])
            .collect()
    }

    fn with_scratch(&self, run: impl FnOnce(&mut Scratch<V>)) {
        let mut scratch = self.pool.take(self.factor.size());
        run(&mut scratch);
        self.pool.put(scratch);
    }
}

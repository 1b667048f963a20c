//! Forward and backward substitution along the elimination tree, for one right-hand side or a block of them.

use std::{ops::Range, sync::Mutex};

use faer::{
    Accum, MatMut, MatRef, Par,
    linalg::{matmul::matmul, triangular_solve::solve_upper_triangular_in_place},
    reborrow::ReborrowMut,
};

use super::{
    analysis::FactorStructure,
    factor::{CholeskyFactor, FactorPanel},
    fronts::{SubtreeTask, ascend, descend, locked},
    precision::Scalar,
    unknown::{COLUMNS, SEVERAL, Several, Unknown},
    vector::{power_of_two_near_largest, vectorised},
};

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
    tasks: &'a [SubtreeTask],
    pool: &'a ScratchPool<V>,
}

impl<T: Scalar, V: Unknown<T>> TreeSolve<'_, T, V> {
    /// L⁻¹ in place: every task passes what it subtracts from the rows below it to its parent.
    fn forward(&self, unknowns: &mut [V]) {
        let own = self.split(unknowns);
        let updates: Vec<Mutex<Vec<V>>> = self.tasks.iter().map(|_| Mutex::default()).collect();
        ascend(self.tasks, |k| {
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

impl<T: Scalar> FactorPanel<'_, T> {
    /// Replaces the leading part by its solution with the diagonal block and adds −L_below times it
    /// to the rest.
    #[inline(always)]
    pub(super) fn forward<V: Unknown<T>>(&self, x: &mut [V]) {
        let height = self.rows.len();
        let mut k = 0;
        while k < self.width {
            let block = COLUMNS.min(self.width - k);
            for c in k..k + block {
                let column = &self.values[c * height..(c + 1) * height];
                x[c] = x[c] / column[c];
                let factor = x[c];
                for i in c + 1..k + block {
                    x[i] -= factor * column[i];
                }
            }
            let (solved, rest) = x.split_at_mut(k + block);
            let tail = |c: usize| &self.values[c * height + k + block..(c + 1) * height];
            if block == COLUMNS {
                subtract_four(
                    [tail(k), tail(k + 1), tail(k + 2), tail(k + 3)],
                    &solved[k..],
                    rest,
                );
            } else {
                for c in k..k + block {
                    let factor = solved[c];
                    rest.iter_mut()
                        .zip(tail(c))
                        .for_each(|(x, l)| *x -= factor * *l);
                }
            }
            k += block;
        }
    }

    /// Replaces the leading part by L_diagonal⁻ᵀ (x_leading − L_belowᵀ x_below).
    #[inline(always)]
    pub(super) fn backward<V: Unknown<T>>(&self, x: &mut [V]) {
        let height = self.rows.len();
        let mut end = self.width;
        while end > 0 {
            // the incomplete block comes last in the forward pass, so first here
            let block = if end.is_multiple_of(COLUMNS) {
                COLUMNS
            } else {
                end % COLUMNS
            };
            let k = end - block;
            let (unknown, known) = x.split_at_mut(end);
            let tail = |c: usize| &self.values[c * height + end..(c + 1) * height];
            if block == COLUMNS {
                let dots = V::four_dots([tail(k), tail(k + 1), tail(k + 2), tail(k + 3)], known);
                unknown[k..]
                    .iter_mut()
                    .zip(dots)
                    .for_each(|(x, dot)| *x -= dot);
            } else {
                for c in k..end {
                    unknown[c] -= V::dot(tail(c), known);
                }
            }
            for c in (k..end).rev() {
                let column = &self.values[c * height..(c + 1) * height];
                let known = V::dot(&column[c + 1..end], &x[c + 1..end]);
                x[c] -= known;
                x[c] = x[c] / column[c];
            }
            end = k;
        }
    }
}

/// y −= Σ columns[k] · factors[k].
#[inline(always)]
fn subtract_four<T: Scalar, V: Unknown<T>>(columns: [&[T]; COLUMNS], factors: &[V], y: &mut [V]) {
    let n = y.len();
    let [a, b, c, d] = columns.map(|column| &column[..n]);
    let [fa, fb, fc, fd] = [factors[0], factors[1], factors[2], factors[3]];
    for i in 0..n {
        y[i] -= (fa * a[i] + fb * b[i]) + (fc * c[i] + fd * d[i]);
    }
}

impl<T: Scalar> CholeskyFactor<T> {
    /// One supernode of L⁻ᵀX for a row-major X of `columns` columns whose row r is kept at place
    /// `place(r)`; the supernode's own columns must be kept consecutively.
    pub(super) fn backward_block(
        &self,
        s: usize,
        place: impl Fn(usize) -> usize,
        x: &mut [T],
        columns: usize,
        known: &mut Vec<T>,
    ) {
        let panel = self.panel(s);
        let (diagonal, below) = split_panel(panel.values, panel.rows.len(), panel.width);
        let rows = &panel.rows[panel.width..];
        known.clear();
        for &row in rows {
            let start = place(row) * columns;
            known.extend_from_slice(&x[start..start + columns]);
        }
        let start = place(panel.first) * columns;
        let own = &mut x[start..start + panel.width * columns];
        let mut own = MatMut::from_row_major_slice_mut(own, panel.width, columns);
        let known = MatRef::from_row_major_slice(known, rows.len(), columns);
        matmul(
            own.rb_mut(),
            Accum::Add,
            below.transpose(),
            known,
            -T::rounded(1.0),
            Par::Seq,
        );
        solve_upper_triangular_in_place(diagonal.transpose(), own, Par::Seq);
    }
}

/// The diagonal block of a panel and the rows below it.
fn split_panel<T: Scalar>(
    values: &[T],
    height: usize,
    width: usize,
) -> (MatRef<'_, T>, MatRef<'_, T>) {
    MatRef::from_column_major_slice(values, height, width).split_at_row(width)
}

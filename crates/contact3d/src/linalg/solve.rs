//! Forward and backward substitution along the elimination tree, for one right-hand side or several that share the reading of the factor.

use std::{array::from_fn, ops::Range, sync::Mutex};

use super::{
    cholesky::CholeskyFactor,
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

    /// Solves for several right-hand sides, up to eight at a time: reading the factor takes most of the time of a solve.
    ///
    /// # Panics
    /// As [`Self::solve_in_place`].
    pub(super) fn solve_several(&self, rhs: &mut [&mut [f64]]) {
        let memory = Mutex::default();
        for block in rhs.chunks_mut(SHARED_SOLVES) {
            match block.len() {
                1 => self.solve_block::<1>(block, None, &Mutex::default()),
                2 => self.solve_block::<2>(block, None, &Mutex::default()),
                3..=4 => self.solve_block::<4>(block, None, &Mutex::default()),
                _ => self.solve_block::<SHARED_SOLVES>(block, None, &memory),
            }
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

/// Columns treated together: each entry of the running sums is then loaded once for four
/// coefficients.
const UNROLLED: usize = 4;

/// Rows treated together in the dot products of one right-hand side.
const DOT_LANES: usize = 8;

/// Replaces the leading `width` rows of N right-hand sides by their solution with the diagonal block of a column-major panel
/// and adds −L_below times it to the rest.
#[inline(always)]
pub(super) fn forward<T: Scalar, const N: usize>(values: &[T], width: usize, x: &mut [[T; N]]) {
    let height = x.len();
    let mut k = 0;
    while k < width {
        let block = UNROLLED.min(width - k);
        for c in k..k + block {
            let column = &values[c * height..(c + 1) * height];
            x[c] = x[c].map(|x| x / column[c]);
            let factor = x[c];
            for i in c + 1..k + block {
                subtract(&mut x[i], factor, column[i]);
            }
        }
        let (solved, rest) = x.split_at_mut(k + block);
        let tail = |c: usize| &values[c * height + k + block..(c + 1) * height];
        if block == UNROLLED {
            subtract_four(from_fn(|c| tail(k + c)), from_fn(|c| solved[k + c]), rest);
        } else {
            for c in k..k + block {
                for (x, l) in rest.iter_mut().zip(tail(c)) {
                    subtract(x, solved[c], *l);
                }
            }
        }
        k += block;
    }
}

/// Replaces the leading part by L_diagonal⁻ᵀ (x_leading − L_belowᵀ x_below).
#[inline(always)]
pub(super) fn backward<T: Scalar, const N: usize>(values: &[T], width: usize, x: &mut [[T; N]]) {
    let one = T::rounded(1.0);
    let height = x.len();
    let mut end = width;
    while end > 0 {
        // the incomplete block comes last in the forward pass, so first here
        let block = if end.is_multiple_of(UNROLLED) {
            UNROLLED
        } else {
            end % UNROLLED
        };
        let k = end - block;
        let (unknown, known) = x.split_at_mut(end);
        let tail = |c: usize| &values[c * height + end..(c + 1) * height];
        if block == UNROLLED {
            let dots = four_dots(from_fn(|c| tail(k + c)), known);
            for (x, dot) in unknown[k..].iter_mut().zip(dots) {
                subtract(x, dot, one);
            }
        } else {
            for c in k..end {
                subtract(&mut unknown[c], dot(tail(c), known), one);
            }
        }
        for c in (k..end).rev() {
            let column = &values[c * height..(c + 1) * height];
            let known = dot(&column[c + 1..end], &x[c + 1..end]);
            subtract(&mut x[c], known, one);
            x[c] = x[c].map(|x| x / column[c]);
        }
        end = k;
    }
}

/// x −= factor · coefficient.
#[inline(always)]
fn subtract<T: Scalar, const N: usize>(x: &mut [T; N], factor: [T; N], coefficient: T) {
    for i in 0..N {
        x[i] -= factor[i] * coefficient;
    }
}

/// y −= Σ columns[k] · factors[k].
#[inline(always)]
fn subtract_four<T: Scalar, const N: usize>(
    columns: [&[T]; UNROLLED],
    factors: [[T; N]; UNROLLED],
    y: &mut [[T; N]],
) {
    let n = y.len();
    let [a, b, c, d] = columns.map(|column| &column[..n]);
    let [fa, fb, fc, fd] = factors;
    for i in 0..n {
        for j in 0..N {
            y[i][j] -= (fa[j] * a[i] + fb[j] * b[i]) + (fc[j] * c[i] + fd[j] * d[i]);
        }
    }
}

/// columnᵀ y, summed in order.
#[inline(always)]
fn dot<T: Scalar, const N: usize>(column: &[T], y: &[[T; N]]) -> [T; N] {
    let mut sum = [T::default(); N];
    for (l, y) in column.iter().zip(y) {
        add_products(&mut sum, &[*l; N], y);
    }
    sum
}

/// The products columns[k]ᵀ y; those of one right-hand side are summed in interleaved parts.
#[inline(always)]
fn four_dots<T: Scalar, const N: usize>(
    columns: [&[T]; UNROLLED],
    y: &[[T; N]],
) -> [[T; N]; UNROLLED] {
    let columns = columns.map(|column| &column[..y.len()]);
    if N == 1 {
        return interleaved_dots(columns, y.as_flattened()).map(|dot| [dot; N]);
    }
    let [a, b, c, d] = columns;
    let mut sums = [[T::default(); N]; UNROLLED];
    for (i, y) in y.iter().enumerate() {
        add_products(&mut sums[0], &[a[i]; N], y);
        add_products(&mut sums[1], &[b[i]; N], y);
        add_products(&mut sums[2], &[c[i]; N], y);
        add_products(&mut sums[3], &[d[i]; N], y);
    }
    sums
}

#[inline(always)]
fn interleaved_dots<T: Scalar>(columns: [&[T]; UNROLLED], y: &[T]) -> [T; UNROLLED] {
    let [a, b, c, d] = columns.map(|column| column.as_chunks::<DOT_LANES>());
    let (whole, rest) = y.as_chunks::<DOT_LANES>();
    let mut sums = [[T::default(); DOT_LANES]; UNROLLED];
    for ((((y, a), b), c), d) in whole.iter().zip(a.0).zip(b.0).zip(c.0).zip(d.0) {
        add_products(&mut sums[0], a, y);
        add_products(&mut sums[1], b, y);
        add_products(&mut sums[2], c, y);
        add_products(&mut sums[3], d, y);
    }
    let tails = [a.1, b.1, c.1, d.1].map(|tail| dot(tail, rest.as_chunks().0));
    from_fn(|k| {
        let [tail] = tails[k];
        total(&sums[k]) + tail
    })
}

/// The sum of interleaved parts. In line, it would have the compiler mix the parts of the loop before it.
#[inline(never)]
fn total<T: Scalar>(parts: &[T; DOT_LANES]) -> T {
    let [a, b, c, d, e, f, g, h] = *parts;
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

#[inline(always)]
fn add_products<T: Scalar, const N: usize>(sums: &mut [T; N], x: &[T; N], y: &[T; N]) {
    for i in 0..N {
        sums[i] += x[i] * y[i];
    }
}

//! Numeric factorisation by the multifrontal method (I. Duff, J. Reid, *ACM Trans. Math. Softw.* 9 (1983) 302; J. W. H. Liu,
//! *SIAM Review* 34 (1992) 82).
//!
//! Every supernode has a dense front: the coefficients of its columns, plus what its children in the elimination tree leave.
//! Eliminating its columns gives its panel of L and an update for its parent. Small subtrees are tasks for one thread; the
//! supernodes above them are tasks of their own, cut into tiles inside. Children are added in ascending order and tiles have
//! one size, so the factor has the same bits at any number of threads.

use std::sync::Mutex;

use faer::{
    Accum, MatMut, MatRef, Par,
    linalg::{
        matmul::triangular::{self, BlockStructure},
        triangular_solve::solve_lower_triangular_in_place,
    },
    reborrow::{Reborrow, ReborrowMut},
};
use rayon::prelude::*;

use super::{
    dense::{cholesky, multiply},
    precision::Scalar,
    sparse::CscMatrix,
    structure::{FactorStructure, Front, positions},
    tasks::{SubtreeTask, Work, ascend, locked, split},
};

/// Why there is no factor.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Failure {
    /// There is no memory for an update.
    OutOfMemory,
    /// A column, in the new numbering, whose pivot is not positive.
    Pivot(usize),
}

impl FactorStructure {
    /// Numbers in the lower triangles of the updates that are held at once while `threads` threads factorise: those of children not yet used when
    /// supernodes come one after another, and for each further thread the most that one of its fronts takes.
    pub(crate) fn update_count(&self, threads: usize) -> usize {
        let tree = self.supernode_tree();
        let (mut waiting, mut most, mut largest) = (0, 0, 0);
        let mut of_children = vec![0; self.supernodes()];
        for s in 0..self.supernodes() {
            let order = self.front(s).below().len();
            let numbers = order * (order + 1) / 2;
            waiting += numbers;
            most = most.max(waiting);
            largest = largest.max(numbers);
            waiting -= of_children[s];
            if let Some(parent) = tree.parent[s] {
                of_children[parent] += numbers;
            }
        }
        most + threads.saturating_sub(1) * largest
    }
}

/// Computes the panels of L, which are zero, for PAPᵀ = LLᵀ, and notes each front that is done.
///
/// # Errors
/// [`Failure`]; of several pivots the first, and the columns before it in its subtree are complete.
pub(super) fn factorise<T: Scalar>(
    structure: &FactorStructure,
    a: &CscMatrix,
    values: &mut [T],
    work: &Work,
) -> Result<(), Failure> {
    let tasks = structure.tasks(|front| front.operations(), 1.0 / 64.0);
    let run = Run {
        structure,
        a,
        new_of_old: structure.new_of_old(),
        panels: split(&tasks, &structure.value_offsets, values),
        updates: tasks.iter().map(|_| Mutex::new(None)).collect(),
        failure: Mutex::new(None),
        buffers: Buffers::default(),
        tasks: &tasks,
        work,
    };
    ascend(&tasks, |task| run.finish(task));
    locked(&run.failure).map_or(Ok(()), Err)
}

/// A factorisation under way.
struct Run<'a, T> {
    structure: &'a FactorStructure,
    a: &'a CscMatrix,
    new_of_old: Vec<usize>,
    tasks: &'a [SubtreeTask],
    panels: Vec<Mutex<&'a mut [T]>>,
    /// What each finished task leaves to its parent.
    updates: Vec<Mutex<Option<UpdateMatrix<T>>>>,
    /// The first failure so far.
    failure: Mutex<Option<Failure>>,
    buffers: Buffers<T>,
    work: &'a Work,
}

impl<T: Scalar> Run<'_, T> {
    /// Runs a task and keeps what it leaves to its parent; false where a pivot failed.
    fn finish(&self, k: usize) -> bool {
        let children = self.tasks[k].children.iter();
        let updates = children
            .filter_map(|&child| locked(&self.updates[child]).take())
            .collect();
        match self.subtree(k, updates) {
            Ok(update) => *locked(&self.updates[k]) = update,
            Err(failure) => {
                let mut first = locked(&self.failure);
                *first = Some(first.map_or(failure, |first| first.min(failure)));
                return false;
            }
        }
        true
    }

    /// Eliminates the supernodes of a task in postorder; the updates on the stack are those of children not yet used.
    fn subtree(
        &self,
        task: usize,
        mut stack: Vec<UpdateMatrix<T>>,
    ) -> Result<Option<UpdateMatrix<T>>, Failure> {
        let mut rest: &mut [T] = &mut locked(&self.panels[task]);
        for s in self.tasks[task].supernodes.clone() {
            let offsets = &self.structure.value_offsets;
            let (panel, next) = rest.split_at_mut(offsets[s + 1] - offsets[s]);
            rest = next;
            let update = self.front(s, panel, &mut stack)?;
            stack.extend(update);
        }
        Ok(stack.pop())
    }

    fn front(
        &self,
        s: usize,
        panel: &mut [T],
        stack: &mut Vec<UpdateMatrix<T>>,
    ) -> Result<Option<UpdateMatrix<T>>, Failure> {
        let front = self.structure.front(s);
        let (height, width) = (front.rows.len(), front.width);
        let order = height - width;
        let own = front.first..front.first + width;
        let is_child = |update: &UpdateMatrix<T>| {
            let child = self.structure.front(update.supernode);
            child.below().first().is_some_and(|row| own.contains(row))
        };
        let last_other = stack.iter().rposition(|update| !is_child(update));
        let finished = stack.split_off(last_other.map_or(0, |i| i + 1));
        let children = finished.iter().map(|update| {
            let child = self.structure.front(update.supernode);
            Child::new(&update.values, child.below(), front.rows)
        });
        let children: Vec<Child<'_, T>> = children.collect();
        let permutation = &self.structure.permutation;
        scatter(self.a, permutation, &self.new_of_old, front, panel);
        add_children(&children, panel, 0, 0, height);
        let values = self.buffers.take(order * order);
        let mut values = values.ok_or(Failure::OutOfMemory)?;
        let below = &mut values[..order * order];
        eliminate(panel, height, width, below)
            .map_err(|column| Failure::Pivot(front.first + column))?;
        add_children(&children, below, width, width, order);
        drop(children);
        self.work.add(front.operations());
        finished
            .into_iter()
            .for_each(|update| self.buffers.put(update.values));
        Ok((order > 0).then_some(UpdateMatrix {
            supernode: s,
            values,
        }))
    }
}

/// Columns of a front that are assembled together.
const ASSEMBLED_COLUMNS: usize = 64;

/// What the subtree of a supernode subtracts from the rows below it: the lower triangle of a square matrix, column-major.
#[derive(Debug)]
struct UpdateMatrix<T> {
    /// The supernode at the root of the subtree.
    supernode: usize,
    values: Vec<T>,
}

/// Writes the lower triangle of the columns of a supernode of PAPᵀ into its panel, given the new number of each unknown.
///
/// Zeros are written first: a fresh page that is read before it is written costs two faults.
fn scatter<T: Scalar>(
    a: &CscMatrix,
    permutation: &[usize],
    new_of_old: &[usize],
    front: Front<'_>,
    panel: &mut [T],
) {
    panel.fill(T::default());
    let end = front.first + front.width;
    let columns = panel.chunks_exact_mut(front.rows.len());
    for (new, column) in (front.first..).zip(columns) {
        for (old_row, coefficient) in a.entries(permutation[new]) {
            let row = new_of_old[old_row];
            if row < new {
                continue;
            }
            let place = if row < end {
                row - front.first
            } else {
                front.width + front.below().partition_point(|&other| other < row)
            };
            column[place] = T::rounded(coefficient);
        }
    }
}

/// An update with the places of its rows in the front of the parent.
struct Child<'a, T> {
    values: &'a [T],
    /// Place of each row.
    places: Vec<usize>,
    /// Rows that stay neighbours: first row and the row after the last.
    runs: Vec<(usize, usize)>,
}

impl<'a, T: Scalar> Child<'a, T> {
    /// Finds the places of the rows (ascending) in the rows of the parent, which contain them.
    fn new(values: &'a [T], rows: &[usize], parent_rows: &[usize]) -> Self {
        let places = positions(rows, parent_rows);
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for i in 0..places.len() {
            match runs.last_mut() {
                Some(run) if places[i] == places[i - 1] + 1 => run.1 = i + 1,
                _ => runs.push((i, i + 1)),
            }
        }
        Self {
            values,
            places,
            runs,
        }
    }

    /// Adds it to some columns of the parent's front, of which the rows from `first_row` on are kept, `height` of them.
    fn add_to(&self, columns: &mut [T], first_column: usize, first_row: usize, height: usize) {
        let order = self.places.len();
        let end = first_column + columns.len() / height;
        let start = self.places.partition_point(|&place| place < first_column);
        let mut run = self.runs.partition_point(|run| run.1 <= start);
        for column in start..order {
            let place = self.places[column];
            if place >= end {
                break;
            }
            if self.runs[run].1 <= column {
                run += 1;
            }
            let source = &self.values[column * order..(column + 1) * order];
            let target = &mut columns[(place - first_column) * height..][..height];
            for &(first, last) in &self.runs[run..] {
                let first = first.max(column);
                let at = self.places[first] - first_row;
                let target = &mut target[at..at + last - first];
                for (t, s) in target.iter_mut().zip(&source[first..last]) {
                    *t += *s;
                }
            }
        }
    }
}

/// Adds the children's updates, one after another, to some columns of a front: its panel, or the update below it, of which
/// the rows from `first_row` on are kept, `height` of them.
fn add_children<T: Scalar>(
    children: &[Child<'_, T>],
    columns: &mut [T],
    first_column: usize,
    first_row: usize,
    height: usize,
) {
    let chunks = columns
        .par_chunks_mut((height * ASSEMBLED_COLUMNS).max(1))
        .enumerate();
    chunks.for_each(|(i, columns)| {
        for child in children {
            child.add_to(
                columns,
                first_column + i * ASSEMBLED_COLUMNS,
                first_row,
                height,
            );
        }
    });
}

/// Bytes above which a buffer is given back to the system instead: only the lower triangle of an update is ever touched, and a
/// buffer that serves another update is touched elsewhere.
const POOLED_BYTES: usize = 32 << 20;

/// Buffers that no update uses now.
#[derive(Default)]
struct Buffers<T>(Mutex<Vec<Vec<T>>>);

impl<T: Scalar> Buffers<T> {
    /// At least `length` numbers of any value; `None` where there is no memory for them.
    ///
    /// Lengths are powers of two, so that a buffer fits again soon; a page that is never touched takes no memory.
    fn take(&self, length: usize) -> Option<Vec<T>> {
        if length == 0 {
            return Some(Vec::new());
        }
        if length * size_of::<T>() > POOLED_BYTES {
            return zeros(length);
        }
        let length = length.next_power_of_two();
        let mut free = locked(&self.0);
        if let Some(place) = free.iter().rposition(|buffer| buffer.len() == length) {
            return Some(free.swap_remove(place));
        }
        drop(free);
        zeros(length)
    }

    /// Gives a buffer back. At most twice the size of the largest is kept: without a limit, a quarter of the factor lies idle at
    /// n_div = 32, and nothing is faster.
    fn put(&self, buffer: Vec<T>) {
        let bytes = |buffer: &Vec<T>| size_of_val(&buffer[..]);
        let mut free = locked(&self.0);
        let kept: usize = free.iter().map(bytes).sum();
        if bytes(&buffer) <= POOLED_BYTES && kept + bytes(&buffer) <= 2 * POOLED_BYTES {
            free.push(buffer);
        }
    }
}

/// Zeros in pages that take memory when they are touched first; `None` where there is none.
pub(super) fn zeros<T: Scalar>(length: usize) -> Option<Vec<T>> {
    let bytes = length.checked_mul(size_of::<T>())?;
    let mut probe: Vec<u8> = Vec::new();
    probe.try_reserve_exact(bytes).ok()?;
    drop(probe);
    Some(vec![T::default(); length])
}

/// Columns eliminated together, and the inner length of every product: what faer's kernels are fastest at, since two operands
/// of 256 × 256 stay in a core's second cache.
const ELIMINATED_COLUMNS: usize = 256;

/// Rows and columns of a tile.
const TILE_ROWS: usize = 384;

/// Eliminates the columns of a panel (height × width, column-major) and writes −L₂₁L₂₁ᵀ to the lower triangle of the update,
/// (height − width)², column-major.
///
/// # Errors
/// The column of the panel whose pivot is not positive.
pub(super) fn eliminate<T: Scalar>(
    panel: &mut [T],
    height: usize,
    width: usize,
    update: &mut [T],
) -> Result<(), usize> {
    let mut panel = MatMut::from_column_major_slice_mut(panel, height, width);
    for first in (0..width).step_by(ELIMINATED_COLUMNS) {
        let count = ELIMINATED_COLUMNS.min(width - first);
        let trailing = panel
            .rb_mut()
            .submatrix_mut(first, first, height - first, width - first);
        let (block, rest) = trailing.split_at_col_mut(count);
        let (mut diagonal, mut below) = block.split_at_row_mut(count);
        cholesky(diagonal.rb_mut()).map_err(|column| first + column)?;
        solve_rows(diagonal.rb(), below.rb_mut());
        let (_, rest) = rest.split_at_row_mut(count);
        subtract_gram(below.rb(), rest, Accum::Add);
    }
    let below = panel.rb().split_at_row(width).1;
    let order = height - width;
    let update = MatMut::from_column_major_slice_mut(update, order, order);
    subtract_gram(below, update, Accum::Replace);
    // What the kernels left above the diagonal.
    for k in 1..width {
        panel
            .rb_mut()
            .col_mut(k)
            .subrows_mut(0, k)
            .fill(T::default());
    }
    Ok(())
}

/// X L⁻ᵀ in place, rows in chunks.
fn solve_rows<T: Scalar>(lower: MatRef<'_, T>, rows: MatMut<'_, T>) {
    let mut chunks = Vec::new();
    let mut rest = rows;
    while rest.nrows() > 0 {
        let (chunk, next) = split_rows(rest);
        chunks.push(chunk);
        rest = next;
    }
    chunks.into_par_iter().for_each(|chunk| {
        solve_lower_triangular_in_place(lower, chunk.transpose_mut(), Par::Seq);
    });
}

/// Subtracts the lower trapezoid of F Fᵀ from a target that has as many rows as F and at most as many columns, or from zero.
fn subtract_gram<T: Scalar>(factor: MatRef<'_, T>, target: MatMut<'_, T>, start: Accum) {
    let mut tiles = Vec::new();
    let mut rest = target;
    let mut column = 0;
    while rest.ncols() > 0 {
        let count = TILE_ROWS.min(rest.ncols());
        let (columns, next) = rest.split_at_col_mut(count);
        let mut below = columns.split_at_row_mut(column).1;
        let mut row = column;
        while below.nrows() > 0 {
            let (tile, next) = split_rows(below);
            let rows = tile.nrows();
            tiles.push((row, column, tile));
            row += rows;
            below = next;
        }
        column += count;
        rest = next;
    }
    tiles.into_par_iter().for_each(|(row, column, mut tile)| {
        for first in (0..factor.ncols()).step_by(ELIMINATED_COLUMNS) {
            let count = ELIMINATED_COLUMNS.min(factor.ncols() - first);
            let accum = if first == 0 { start } else { Accum::Add };
            let left = factor.submatrix(row, first, tile.nrows(), count);
            let right = factor
                .submatrix(column, first, tile.ncols(), count)
                .transpose();
            if row > column {
                multiply(tile.rb_mut(), accum, -1.0, left, right);
                continue;
            }
            // A tile on the diagonal: the square at its top is symmetric.
            let order = tile.ncols();
            let (square, rest) = tile.rb_mut().split_at_row_mut(order);
            let (top, bottom) = left.split_at_row(order);
            let full = BlockStructure::Rectangular;
            let lower = BlockStructure::TriangularLower;
            triangular::matmul(
                square,
                lower,
                accum,
                top,
                full,
                right,
                full,
                -T::rounded(1.0),
                Par::Seq,
            );
            multiply(rest, accum, -1.0, bottom, right);
        }
    });
}

/// The first rows, as many as a tile has, and the others.
fn split_rows<T>(rows: MatMut<'_, T>) -> (MatMut<'_, T>, MatMut<'_, T>) {
    let count = TILE_ROWS.min(rows.nrows());
    rows.split_at_row_mut(count)
}

//! Fills a front, in memory used again: the matrix's own coefficients, and what its children leave.

use std::sync::Mutex;

use rayon::prelude::*;

use super::super::{analysis::Front, front_plan::positions, precision::Scalar, sparse::CscMatrix};
use super::locked;

/// Columns of a front that are assembled together.
const CHUNK_COLUMNS: usize = 64;

/// What the subtree of a supernode subtracts from the rows below it: the lower triangle of a square matrix, column-major.
#[derive(Debug)]
pub(super) struct UpdateMatrix<T> {
    /// The supernode at the root of the subtree.
    pub(super) supernode: usize,
    pub(super) values: Vec<T>,
}

/// Writes the lower triangle of the columns of a supernode of PAPᵀ into its panel, given the new number of each unknown.
///
/// Zeros are written first: a fresh page that is read before it is written costs two faults.
pub(super) fn scatter<T: Scalar>(
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
pub(super) struct Child<'a, T> {
    values: &'a [T],
    /// Place of each row.
    places: Vec<usize>,
    /// Rows that stay neighbours: first row and the row after the last.
    runs: Vec<(usize, usize)>,
}

impl<'a, T: Scalar> Child<'a, T> {
    /// Finds the places of the rows (ascending) in the rows of the parent, which contain them.
    pub(super) fn new(values: &'a [T], rows: &[usize], parent_rows: &[usize]) -> Self {
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
pub(super) fn add_children<T: Scalar>(
    children: &[Child<'_, T>],
    columns: &mut [T],
    first_column: usize,
    first_row: usize,
    height: usize,
) {
    let chunks = columns
        .par_chunks_mut((height * CHUNK_COLUMNS).max(1))
        .enumerate();
    chunks.for_each(|(i, columns)| {
        for child in children {
            child.add_to(columns, first_column + i * CHUNK_COLUMNS, first_row, height);
        }
    });
}

/// Bytes above which a buffer is given back to the system instead: only the lower triangle of an update is ever touched, and a
/// buffer that serves another update is touched elsewhere.
const LARGEST_KEPT: usize = 32 << 20;

/// Bytes kept in all: without a limit, a quarter of the factor lies idle at n_div = 32, and nothing is faster.
const MOST_KEPT: usize = 64 << 20;

/// Buffers that no update uses now.
#[derive(Default)]
struct Free<T> {
    buffers: Vec<Vec<T>>,
    bytes: usize,
}

/// Where updates take their memory from.
#[derive(Default)]
pub(super) struct Buffers<T>(Mutex<Free<T>>);

impl<T: Scalar> Buffers<T> {
    /// At least `length` numbers of any value; `None` where there is no memory for them.
    ///
    /// Lengths are powers of two, so that a buffer fits again soon; a page that is never touched takes no memory.
    pub(super) fn take(&self, length: usize) -> Option<Vec<T>> {
        if length == 0 {
            return Some(Vec::new());
        }
        if length * size_of::<T>() > LARGEST_KEPT {
            return zeros(length);
        }
        let length = length.next_power_of_two();
        let mut free = locked(&self.0);
        let fits = |buffer: &Vec<T>| buffer.len() == length;
        if let Some(place) = free.buffers.iter().rposition(fits) {
            free.bytes -= length * size_of::<T>();
            return Some(free.buffers.swap_remove(place));
        }
        drop(free);
        zeros(length)
    }

    /// Gives a buffer back.
    pub(super) fn put(&self, buffer: Vec<T>) {
        let bytes = size_of_val(&buffer[..]);
        let mut free = locked(&self.0);
        if bytes <= LARGEST_KEPT && free.bytes + bytes <= MOST_KEPT {
            free.bytes += bytes;
            free.buffers.push(buffer);
        }
    }
}

/// Zeros in pages that take memory when they are touched first; `None` where there is none.
pub(in super::super) fn zeros<T: Scalar>(length: usize) -> Option<Vec<T>> {
    let bytes = length.checked_mul(size_of::<T>())?;
    let mut probe: Vec<u8> = Vec::new();
    probe.try_reserve_exact(bytes).ok()?;
    drop(probe);
    Some(vec![T::default(); length])
}

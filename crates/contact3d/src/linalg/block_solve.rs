//! Backward substitution with blocks of right-hand sides.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::reborrow::ReborrowMut;
use faer::{Accum, MatMut, MatRef, Par};

use super::factor::CholeskyFactor;
use super::scalar::Scalar;

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

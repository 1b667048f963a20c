//! Forward and backward substitution with blocks of right-hand sides.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

use super::factor::CholeskyFactor;

/// Right-hand sides solved together by [`CholeskyFactor::solve_many`].
const BLOCK_COLUMNS: usize = 32;

impl CholeskyFactor {
    /// Solves A X = B in place; `rhs` holds the columns of B one after another, shape (unknowns, columns) column-major.
    ///
    /// Blocks of a fixed number of columns run in parallel, so the bits do not depend on the thread count.
    ///
    /// # Panics
    /// When the length of `rhs` is not a multiple of the number of unknowns.
    pub fn solve_many(&self, rhs: &mut [f64]) {
        let size = self.size();
        if size == 0 {
            assert!(rhs.is_empty(), "right-hand sides of an empty system");
            return;
        }
        assert_eq!(rhs.len() % size, 0, "length of the right-hand sides");
        rhs.par_chunks_mut(size * BLOCK_COLUMNS)
            .for_each(|block| self.solve_block(block));
    }

    fn solve_block(&self, block: &mut [f64]) {
        let size = self.size();
        let columns = block.len() / size;
        let mut x = vec![0.0; block.len()];
        for (new, row) in x.chunks_exact_mut(columns).enumerate() {
            let old = self.permutation[new];
            row.iter_mut()
                .enumerate()
                .for_each(|(c, value)| *value = block[c * size + old]);
        }
        let mut update = Vec::new();
        for s in 0..self.supernodes() {
            self.forward_block(s, |row| row, &mut x, columns, &mut update);
        }
        for s in (0..self.supernodes()).rev() {
            self.backward_block(s, |row| row, &mut x, columns, &mut update);
        }
        for (new, row) in x.chunks_exact(columns).enumerate() {
            let old = self.permutation[new];
            row.iter()
                .enumerate()
                .for_each(|(c, &value)| block[c * size + old] = value);
        }
    }

    /// One supernode of L⁻¹X for a row-major X of `columns` columns whose row r is kept at place `place(r)`.
    ///
    /// The supernode's own columns must be kept consecutively.
    pub(super) fn forward_block(
        &self,
        s: usize,
        place: impl Fn(usize) -> usize,
        x: &mut [f64],
        columns: usize,
        update: &mut Vec<f64>,
    ) {
        let panel = self.panel(s);
        let (diagonal, below) = split_panel(panel.values, panel.rows.len(), panel.width);
        let start = place(panel.first) * columns;
        let own = &mut x[start..start + panel.width * columns];
        let mut own = MatMut::from_row_major_slice_mut(own, panel.width, columns);
        solve_lower_triangular_in_place(diagonal, own.rb_mut(), Par::Seq);
        let rows = &panel.rows[panel.width..];
        update.resize(rows.len() * columns, 0.0);
        let product = MatMut::from_row_major_slice_mut(update, rows.len(), columns);
        matmul(product, Accum::Replace, below, own.rb(), -1.0, Par::Seq);
        for (&row, sums) in rows.iter().zip(update.chunks_exact(columns)) {
            let start = place(row) * columns;
            x[start..start + columns]
                .iter_mut()
                .zip(sums)
                .for_each(|(x, sum)| *x += sum);
        }
    }

    /// One supernode of L⁻ᵀX, with the layout of [`Self::forward_block`].
    pub(super) fn backward_block(
        &self,
        s: usize,
        place: impl Fn(usize) -> usize,
        x: &mut [f64],
        columns: usize,
        known: &mut Vec<f64>,
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
            -1.0,
            Par::Seq,
        );
        solve_upper_triangular_in_place(diagonal.transpose(), own, Par::Seq);
    }
}

/// The diagonal block of a panel and the rows below it.
fn split_panel(values: &[f64], height: usize, width: usize) -> (MatRef<'_, f64>, MatRef<'_, f64>) {
    MatRef::from_column_major_slice(values, height, width).split_at_row(width)
}

//! Partial Cholesky factorisation of one dense front.
//!
//! A front of h rows holds w columns to eliminate, its panel, and the update of the other rows:
//!
//! L₁₁L₁₁ᵀ = F₁₁, L₂₁ = F₂₁L₁₁⁻ᵀ, U = F₂₂ − L₂₁L₂₁ᵀ.
//!
//! Work is cut into tiles of one fixed size; each is computed by one thread in one order, so the bits do not depend on how
//! many threads there are.

use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

use super::dense::{cholesky, multiply};
use super::precision::Scalar;

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

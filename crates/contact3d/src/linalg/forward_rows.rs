//! Half-solved rows of a coupling matrix, W = L⁻¹PBᵀ, and the dual operator S = BA⁻¹Bᵀ = WᵀW made
//! from them.

use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, Par};
use rayon::prelude::*;

use super::factor::CholeskyFactor;
use super::front_plan::{SparseColumn, SupernodeTree};
use super::half_solve::HalfSolved;
use super::sparse::CscMatrix;

/// Rows and columns of a tile of the dual operator.
const TILE: usize = 144;

/// W = L⁻¹PBᵀ for a sparse B, each column kept on the supernodes its row of B reaches only.
///
/// Every sum has a fixed order, so all products have the same bits at any thread count.
#[derive(Clone, Debug)]
pub(crate) struct ForwardRows<'a> {
    pub(super) factor: &'a CholeskyFactor,
    pub(super) tree: SupernodeTree,
    /// The row of B of each column of W: rows that lie close in the elimination tree are
    /// neighbours.
    pub(super) order: Vec<usize>,
    pub(super) half_solved: HalfSolved,
}

impl CholeskyFactor {
    /// Solves W = L⁻¹PBᵀ for all rows of B (shape: rows, unknowns).
    ///
    /// # Panics
    /// When B does not have one column per unknown.
    #[must_use]
    pub(crate) fn forward_rows(&self, b: &CscMatrix) -> ForwardRows<'_> {
        assert_eq!(b.cols, self.size(), "columns of the coupling");
        let by_rows = b.transpose();
        let new_of_old = self.new_of_old();
        let mut rows: Vec<(usize, SparseColumn)> = (0..b.rows)
            .map(|row| {
                let (unknowns, coefficients) = by_rows.column(row);
                let new = unknowns.iter().map(|&old| new_of_old[old]);
                let mut entries: SparseColumn = new.zip(coefficients.iter().copied()).collect();
                entries.sort_unstable_by_key(|entry| entry.0);
                (row, entries)
            })
            .collect();
        rows.sort_by_key(|(row, entries)| {
            (entries.first().map_or(usize::MAX, |entry| entry.0), *row)
        });
        let (order, right_hand_sides): (Vec<usize>, Vec<SparseColumn>) = rows.into_iter().unzip();
        let tree = self.supernode_tree();
        let half_solved = self.half_solve(&tree, &right_hand_sides, |_| true);
        ForwardRows {
            factor: self,
            tree,
            order,
            half_solved,
        }
    }
}

impl ForwardRows<'_> {
    /// The dual operator S = BA⁻¹Bᵀ = WᵀW, column-major, shape (rows of B, rows of B), exactly
    /// symmetric.
    #[must_use]
    pub(crate) fn gram(&self) -> Vec<f64> {
        let rows = self.order.len();
        let count = rows.div_ceil(TILE);
        let range = |i: usize| i * TILE..((i + 1) * TILE).min(rows);
        let pairs: Vec<(Range<usize>, Range<usize>)> = (0..count)
            .flat_map(|j| (j..count).map(move |i| (range(i), range(j))))
            .collect();
        let tiles: Vec<Vec<f64>> = pairs
            .par_iter()
            .map(|(left, right)| self.tile(left, right))
            .collect();
        let mut gram = vec![0.0; rows * rows];
        for ((left, right), tile) in pairs.into_iter().zip(&tiles) {
            for (b, line) in right.zip(tile.chunks_exact(left.len())) {
                let column = self.order[b];
                for (a, &value) in left.clone().zip(line).filter(|pair| pair.0 >= b) {
                    let row = self.order[a];
                    gram[column * rows + row] = value;
                    gram[row * rows + column] = value;
                }
            }
        }
        gram
    }

    /// The products of two ranges of columns of W, column-major, supernode by supernode.
    fn tile(&self, left: &Range<usize>, right: &Range<usize>) -> Vec<f64> {
        let mut tile = vec![0.0; left.len() * right.len()];
        let mut product = Vec::new();
        for part in &self.half_solved.parts {
            let (rows, w_left) = part.columns_in(left);
            let (columns, w_right) = part.columns_in(right);
            if rows.is_empty() || columns.is_empty() {
                continue;
            }
            product.resize(rows.len() * columns.len(), 0.0);
            let target =
                MatMut::from_column_major_slice_mut(&mut product, rows.len(), columns.len());
            matmul(
                target,
                Accum::Replace,
                w_left.transpose(),
                w_right,
                1.0,
                Par::Seq,
            );
            for (column, line) in columns.iter().zip(product.chunks_exact(rows.len())) {
                let target = &mut tile[(column - right.start) * left.len()..][..left.len()];
                for (row, value) in rows.iter().zip(line) {
                    target[row - left.start] += value;
                }
            }
        }
        tile
    }
}

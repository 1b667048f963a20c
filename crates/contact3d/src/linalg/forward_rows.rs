//! Half-solved rows of a coupling matrix, W = L⁻¹PBᵀ, and the dual operator S = BA⁻¹Bᵀ = WᵀW made
//! from them.

use std::ops::Range;

use faer::{Accum, MatMut};
use rayon::prelude::*;

use super::{
    cholesky::CholeskyFactor,
    dense::multiply,
    half_solve::{BLOCK_COLUMNS, FrontPlan, SupernodeColumns},
    precision::Scalar,
    sparse::CscMatrix,
    structure::{FactorStructure, SupernodeTree},
    tasks::Work,
};

/// W = L⁻¹PBᵀ for a sparse B, each column kept on the supernodes its row of B reaches only.
///
/// Every sum has a fixed order, so all products have the same bits at any thread count.
#[derive(Clone, Debug)]
pub(crate) struct ForwardRows<'a, T> {
    pub(super) factor: &'a CholeskyFactor<T>,
    pub(super) tree: SupernodeTree,
    /// The row of B of each column of W: rows that lie close in the elimination tree are
    /// neighbours.
    pub(super) order: Vec<usize>,
    pub(super) half_solved: Vec<SupernodeColumns<T>>,
    pub(super) work: &'a Work,
}

impl FactorStructure {
    /// Of W = L⁻¹PBᵀ for a B of shape (rows, unknowns): entries on the supernodes that its columns reach, multiplications and additions of
    /// the solves, and those of one triangle of WᵀW.
    ///
    /// # Panics
    /// When B does not have one column per unknown.
    pub(crate) fn count_forward_rows(&self, b: &CscMatrix) -> [f64; 3] {
        let (_, right_hand_sides) = self.sorted_rows(b);
        let tree = self.supernode_tree();
        let plan = FrontPlan::new(self.supernodes(), &tree, &right_hand_sides, |_| true);
        let [mut entries, mut of_solves, mut of_products] = [0.0; 3];
        for (s, columns) in &plan.reached {
            let front = self.front(*s);
            of_solves += front.solve_operations(columns.len());
            let (width, columns) = (front.width as f64, columns.len() as f64);
            entries += width * columns;
            of_products += width * columns * columns;
        }
        [entries, of_solves, of_products]
    }

    /// The rows of B in the new numbering, those that lie close in the elimination tree neighbours, and which each one is.
    fn sorted_rows(&self, b: &CscMatrix) -> (Vec<usize>, Vec<Vec<(usize, f64)>>) {
        assert_eq!(b.cols, self.size(), "columns of the coupling");
        let by_rows = b.transpose();
        let new_of_old = self.new_of_old();
        let mut rows: Vec<(usize, Vec<(usize, f64)>)> = (0..b.rows)
            .map(|row| {
                let entries = by_rows.entries(row);
                let new = entries.map(|(old, coefficient)| (new_of_old[old], coefficient));
                let mut entries: Vec<(usize, f64)> = new.collect();
                entries.sort_unstable_by_key(|entry| entry.0);
                (row, entries)
            })
            .collect();
        rows.sort_by_key(|(row, entries)| {
            (entries.first().map_or(usize::MAX, |entry| entry.0), *row)
        });
        rows.into_iter().unzip()
    }
}

impl<T: Scalar> CholeskyFactor<T> {
    /// Solves W = L⁻¹PBᵀ for all rows of B (shape: rows, unknowns); `work` is told of what [`FactorStructure::count_forward_rows`]
    /// counts, of the solves now and of the products in [`ForwardRows::gram`].
    ///
    /// # Panics
    /// When B does not have one column per unknown.
    pub(crate) fn forward_rows<'a>(&'a self, b: &CscMatrix, work: &'a Work) -> ForwardRows<'a, T> {
        let (order, right_hand_sides) = self.structure.sorted_rows(b);
        let tree = self.structure.supernode_tree();
        let half_solved = self.half_solve(&tree, &right_hand_sides, |_| true, work);
        ForwardRows {
            factor: self,
            tree,
            order,
            half_solved,
            work,
        }
    }
}

impl<T: Scalar> ForwardRows<'_, T> {
    /// The dual operator S = BA⁻¹Bᵀ = WᵀW, column-major, shape (rows of B, rows of B), exactly
    /// symmetric.
    pub(crate) fn gram(&self) -> Vec<f64> {
        let rows = self.order.len();
        let count = rows.div_ceil(BLOCK_COLUMNS);
        let range = |i: usize| i * BLOCK_COLUMNS..((i + 1) * BLOCK_COLUMNS).min(rows);
        let pairs: Vec<(Range<usize>, Range<usize>)> = (0..count)
            .flat_map(|j| (j..count).map(move |i| (range(i), range(j))))
            .collect();
        let tiles: Vec<Vec<T>> = pairs
            .par_iter()
            .map(|(left, right)| self.tile(left, right))
            .collect();
        let mut gram = vec![0.0; rows * rows];
        for ((left, right), tile) in pairs.into_iter().zip(&tiles) {
            for (b, line) in right.zip(tile.chunks_exact(left.len())) {
                let column = self.order[b];
                for (a, &value) in left.clone().zip(line).filter(|pair| pair.0 >= b) {
                    let row = self.order[a];
                    let value = value.to_double();
                    gram[column * rows + row] = value;
                    gram[row * rows + column] = value;
                }
            }
        }
        gram
    }

    /// Multiplications and additions of the solves.
    pub(super) fn solve_operations(&self) -> f64 {
        let structure = &self.factor.structure;
        let operations = |part: &SupernodeColumns<T>| {
            let front = structure.front(part.supernode);
            front.solve_operations(part.columns.len())
        };
        self.half_solved.iter().map(operations).sum()
    }

    /// The products of two ranges of columns of W, column-major, supernode by supernode.
    fn tile(&self, left: &Range<usize>, right: &Range<usize>) -> Vec<T> {
        let mut tile = vec![T::default(); left.len() * right.len()];
        let mut product = Vec::new();
        for part in &self.half_solved {
            let (rows, w_left) = part.columns_in(left);
            let (columns, w_right) = part.columns_in(right);
            if rows.is_empty() || columns.is_empty() {
                continue;
            }
            product.resize(rows.len() * columns.len(), T::default());
            let target =
                MatMut::from_column_major_slice_mut(&mut product, rows.len(), columns.len());
            multiply(target, Accum::Replace, 1.0, w_left.transpose(), w_right);
            let sides = if left == right { 1.0 } else { 2.0 };
            self.work
                .add(sides * (rows.len() * columns.len() * w_left.nrows()) as f64);
            for (column, line) in columns.iter().zip(product.chunks_exact(rows.len())) {
                let target = &mut tile[(column - right.start) * left.len()..][..left.len()];
                for (row, value) in rows.iter().zip(line) {
                    target[row - left.start] += *value;
                }
            }
        }
        tile
    }
}

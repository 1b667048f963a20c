//! The compliance H = CA⁻¹Bᵀ from half-solved rows of B, and diagonals of the inverse.

use std::ops::Range;

use faer::{
    Accum, MatMut, MatRef, Par, linalg::triangular_solve::solve_upper_triangular_in_place,
    reborrow::ReborrowMut,
};
use rayon::prelude::*;

use super::{
    cholesky::CholeskyFactor,
    dense::multiply,
    half_solve::{BLOCK_COLUMNS, ForwardRows, SupernodeColumns},
    precision::Scalar,
    sparse::CscMatrix,
    structure::SupernodeTree,
    tasks::Work,
};

/// How L⁻ᵀW is computed on the selected unknowns: a backward pass on the top of the elimination
/// tree, and for the selected unknowns of the subtrees T below it
///
/// x = YᵀW_T − (L_below Y)ᵀ X_below with Y = L_TT⁻¹E,
///
/// where E are their unit vectors and X_below the result on the rows below the subtree's root. A
/// forward pass over the few selected unknowns of a small subtree costs less than a backward pass
/// over all rows of B.
struct BackwardPlan<T> {
    /// The supernodes of the top, ascending.
    top: Vec<usize>,
    /// Unknowns of the top and selected unknowns below it: the rows of X.
    rows: usize,
    /// Row of X of each of these unknowns.
    place: Vec<usize>,
    /// Number of unknowns of the top, the row of X of the first column of `subtrees`.
    top_rows: usize,
    /// Y and −L_below Y.
    subtrees: Vec<SupernodeColumns<T>>,
}

impl<T: Scalar> ForwardRows<'_, T> {
    /// The compliance H = CA⁻¹Bᵀ, column-major, shape (rows of C, rows of B), from L⁻ᵀW on the
    /// unknowns that C selects.
    ///
    /// With B = MC this costs at most one backward pass over the rows of B. Half-solving C and
    /// forming CA⁻¹Cᵀ first would cost a forward pass over its rows, four times as many on panes of
    /// 2 × 2 faces.
    ///
    /// # Panics
    /// When C does not have one column per unknown.
    pub(crate) fn compliance(&self, c: &CscMatrix) -> Vec<f64> {
        assert_eq!(c.cols, self.factor.size(), "columns of the selection");
        let by_rows = c.transpose();
        let new_of_old = self.factor.structure.new_of_old();
        let mut selected: Vec<usize> = by_rows.indices.iter().map(|&old| new_of_old[old]).collect();
        selected.sort_unstable();
        selected.dedup();
        let plan = self.backward_plan(&selected);
        let columns = self.order.len();
        let mut compliance = vec![0.0; c.rows * columns];
        let mut by_row: Vec<Option<&mut [f64]>> = compliance
            .chunks_exact_mut(c.rows.max(1))
            .map(Some)
            .collect();
        let mut in_order: Vec<&mut [f64]> = self
            .order
            .iter()
            .filter_map(|&row| by_row.get_mut(row)?.take())
            .collect();
        let blocks = in_order.par_chunks_mut(BLOCK_COLUMNS).enumerate();
        let of_a_column = self.solve_operations() / columns.max(1) as f64;
        blocks.for_each(|(k, targets)| {
            let start = k * BLOCK_COLUMNS;
            let x = self.backward(&plan, &(start..start + targets.len()));
            add_selected_rows(&by_rows, &x, targets, |old| plan.place[new_of_old[old]]);
            // The way back takes about as much as the way there.
            self.work.add(of_a_column * targets.len() as f64);
        });
        compliance
    }

    fn backward_plan(&self, selected: &[usize]) -> BackwardPlan<T> {
        let factor = self.factor;
        let is_top = self.top_supernodes(selected);
        let top: Vec<usize> = (0..factor.structure.supernodes())
            .filter(|&s| is_top[s])
            .collect();
        let mut place = vec![usize::MAX; factor.size()];
        let unknowns = top.iter().flat_map(|&s| factor.structure.columns(s));
        let mut rows = 0;
        for unknown in unknowns {
            place[unknown] = rows;
            rows += 1;
        }
        let top_rows = rows;
        let below = selected
            .iter()
            .filter(|&&unknown| !is_top[self.tree.owner[unknown]]);
        let unit_vectors: Vec<Vec<(usize, f64)>> = below
            .map(|&unknown| {
                place[unknown] = rows;
                rows += 1;
                vec![(unknown, 1.0)]
            })
            .collect();
        BackwardPlan {
            top,
            rows,
            place,
            top_rows,
            subtrees: factor.half_solve(
                &self.tree,
                &unit_vectors,
                |s| !is_top[s],
                &Work::default(),
            ),
        }
    }

    /// Which supernodes the backward pass visits: the choice of the fewest operations, counted up
    /// the tree.
    fn top_supernodes(&self, selected: &[usize]) -> Vec<bool> {
        let (factor, all) = (self.factor, self.order.len() as f64);
        let SupernodeTree { owner, parent } = &self.tree;
        let supernodes = factor.structure.supernodes();
        let mut loads = vec![0.0; supernodes];
        for part in &self.half_solved {
            loads[part.supernode] = part.columns.len() as f64;
        }
        // Of each subtree: selected unknowns, multiplications that half-solve their unit vectors and multiply by W, and the
        // fewest of all.
        let mut costs = vec![[0.0; 3]; supernodes];
        for &unknown in selected {
            costs[owner[unknown]][0] += 1.0;
        }
        let mut by_backward = vec![false; supernodes];
        for s in 0..supernodes {
            let [selected, forward, best] = costs[s];
            if selected == 0.0 {
                continue;
            }
            let panel = factor.structure.front(s);
            let (width, height) = (panel.width as f64, panel.rows.len() as f64);
            let entries = width * (height - 0.5 * (width - 1.0));
            let solved = forward + selected * (entries + width * loads[s]);
            let forward = solved + selected * (height - width) * all;
            let backward = best + entries * all;
            by_backward[s] = backward <= forward;
            if let Some(parent) = parent[s] {
                let own = [selected, solved, forward.min(backward)];
                (0..3).for_each(|k| costs[parent][k] += own[k]);
            }
        }
        for s in (0..supernodes).rev() {
            by_backward[s] &= parent[s].is_none_or(|parent| by_backward[parent]);
        }
        by_backward
    }

    /// L⁻ᵀ of some columns of W on the rows of the plan, row-major.
    fn backward(&self, plan: &BackwardPlan<T>, block: &Range<usize>) -> Vec<T> {
        let count = block.len();
        let mut x = vec![T::default(); plan.rows * count];
        let mut known = Vec::new();
        let mut parts = self.half_solved.iter().rev().peekable();
        for &s in plan.top.iter().rev() {
            while parts.next_if(|part| part.supernode > s).is_some() {}
            if let Some(part) = parts.next_if(|part| part.supernode == s) {
                let first = plan.place[self.factor.structure.supernode_columns[s]];
                let (columns, values) = part.columns_in(block);
                for (j, column) in columns.iter().enumerate() {
                    for i in 0..values.nrows() {
                        x[(first + i) * count + column - block.start] = values[(i, j)];
                    }
                }
            }
            self.factor
                .backward_block(s, |row| plan.place[row], &mut x, count, &mut known);
        }
        let (top, rest) = x.split_at_mut(plan.top_rows * count);
        self.add_boundaries(plan, top, rest, count);
        self.add_loads(plan, block, rest);
        x
    }

    /// Adds −(L_below Y)ᵀ X_below.
    fn add_boundaries(&self, plan: &BackwardPlan<T>, top: &[T], rest: &mut [T], count: usize) {
        let (mut known, mut product) = (Vec::new(), Vec::new());
        for part in plan.subtrees.iter().filter(|part| !part.update.is_empty()) {
            let rows = self.factor.structure.front(part.supernode).below();
            known.clear();
            for &row in rows {
                known.extend_from_slice(&top[plan.place[row] * count..][..count]);
            }
            let columns = part.columns.len();
            let update = MatRef::from_column_major_slice(&part.update, rows.len(), columns);
            let known = MatRef::from_row_major_slice(&known, rows.len(), count);
            product.resize(columns * count, T::default());
            let target = MatMut::from_row_major_slice_mut(&mut product, columns, count);
            multiply(target, Accum::Replace, 1.0, update.transpose(), known);
            for (column, line) in part.columns.iter().zip(product.chunks_exact(count)) {
                let target = &mut rest[column * count..][..count];
                target.iter_mut().zip(line).for_each(|(x, p)| *x += *p);
            }
        }
    }

    /// Adds YᵀW_T.
    fn add_loads(&self, plan: &BackwardPlan<T>, block: &Range<usize>, rest: &mut [T]) {
        let mut product = Vec::new();
        let mut parts = self.half_solved.iter().peekable();
        for unit in &plan.subtrees {
            while parts
                .next_if(|part| part.supernode < unit.supernode)
                .is_some()
            {}
            let Some(part) = parts.next_if(|part| part.supernode == unit.supernode) else {
                continue;
            };
            let (columns, w) = part.columns_in(block);
            if columns.is_empty() {
                continue;
            }
            let rows = &unit.columns;
            let y = MatRef::from_column_major_slice(&unit.values, unit.width(), rows.len());
            product.resize(rows.len() * columns.len(), T::default());
            let target = MatMut::from_row_major_slice_mut(&mut product, rows.len(), columns.len());
            multiply(target, Accum::Replace, 1.0, y.transpose(), w);
            for (row, line) in rows.iter().zip(product.chunks_exact(columns.len())) {
                let target = &mut rest[row * block.len()..][..block.len()];
                for (column, value) in columns.iter().zip(line) {
                    target[column - block.start] += *value;
                }
            }
        }
    }
}

impl<T: Scalar> CholeskyFactor<T> {
    /// One supernode of L⁻ᵀX for a row-major X of `columns` columns whose row r is kept at place
    /// `place(r)`; the supernode's own columns must be kept consecutively.
    fn backward_block(
        &self,
        s: usize,
        place: impl Fn(usize) -> usize,
        x: &mut [T],
        columns: usize,
        known: &mut Vec<T>,
    ) {
        let (front, values) = self.panel(s);
        let panel = MatRef::from_column_major_slice(values, front.rows.len(), front.width);
        let (diagonal, below) = panel.split_at_row(front.width);
        let at = |row: usize| place(row) * columns;
        known.clear();
        for &row in front.below() {
            known.extend_from_slice(&x[at(row)..][..columns]);
        }
        let own = &mut x[at(front.first)..][..front.width * columns];
        let mut own = MatMut::from_row_major_slice_mut(own, front.width, columns);
        let known = MatRef::from_row_major_slice(known, front.below().len(), columns);
        multiply(own.rb_mut(), Accum::Add, -1.0, below.transpose(), known);
        solve_upper_triangular_in_place(diagonal.transpose(), own, Par::Seq);
    }
}

/// Adds C X for a row-major X, one slice a column, and the columns of Cᵀ.
fn add_selected_rows<T: Scalar>(
    by_rows: &CscMatrix,
    x: &[T],
    columns: &mut [&mut [f64]],
    place: impl Fn(usize) -> usize,
) {
    let count = columns.len();
    for row in 0..by_rows.cols {
        for (old, coefficient) in by_rows.entries(row) {
            let line = &x[place(old) * count..][..count];
            for (column, value) in columns.iter_mut().zip(line) {
                column[row] += coefficient * value.to_double();
            }
        }
    }
}

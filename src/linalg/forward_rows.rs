//! Half-solved rows of a coupling matrix, W = L⁻¹PBᵀ, and the dual operator S = BA⁻¹Bᵀ = WᵀW made from them.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

use super::factor::CholeskyFactor;
use super::sparse::CscMatrix;

/// Rows of B that are solved together.
const BLOCK_COLUMNS: usize = 128;

/// W = L⁻¹PBᵀ for a sparse B, kept in blocks of columns, each on the supernodes its rows of B reach only.
///
/// Blocks have a fixed size and every sum a fixed order, so all products have the same bits at any thread count.
#[derive(Clone, Debug)]
pub struct ForwardRows<'a> {
    factor: &'a CholeskyFactor,
    /// Number of rows of B.
    rows: usize,
    blocks: Vec<Block>,
}

/// Some columns of W on the supernodes they reach.
#[derive(Clone, Debug)]
struct Block {
    /// The rows of B.
    rows: Vec<usize>,
    /// The reached supernodes, ascending.
    supernodes: Vec<usize>,
    /// First row of each of them in `values`, and the total.
    offsets: Vec<usize>,
    /// The columns of W, row-major, shape (reached unknowns, rows of B).
    values: Vec<f64>,
}

impl CholeskyFactor {
    /// Solves W = L⁻¹PBᵀ for all rows of B (shape: rows, unknowns), in blocks of rows that lie close in the elimination tree.
    ///
    /// # Panics
    /// When B does not have one column per unknown.
    pub fn forward_rows(&self, b: &CscMatrix) -> ForwardRows<'_> {
        assert_eq!(b.cols, self.size(), "columns of the coupling");
        let by_rows = b.transpose();
        let new_of_old = self.new_of_old();
        let owner = self.supernode_of_column();
        let first = |row: usize| {
            by_rows
                .column(row)
                .0
                .iter()
                .map(|&old| new_of_old[old])
                .min()
        };
        let mut order: Vec<usize> = (0..b.rows).collect();
        order.sort_by_cached_key(|&row| (first(row).unwrap_or(usize::MAX), row));
        let blocks = order
            .par_chunks(BLOCK_COLUMNS)
            .map(|rows| self.forward_block_of_rows(&by_rows, rows, &new_of_old, &owner))
            .collect();
        ForwardRows {
            factor: self,
            rows: b.rows,
            blocks,
        }
    }

    fn forward_block_of_rows(
        &self,
        by_rows: &CscMatrix,
        rows: &[usize],
        new_of_old: &[usize],
        owner: &[usize],
    ) -> Block {
        let unknowns = rows
            .iter()
            .flat_map(|&row| by_rows.column(row).0)
            .map(|&old| new_of_old[old]);
        let supernodes = self.reach_of_columns(owner, unknowns).supernodes;
        let (offsets, place) = self.places(&supernodes);
        let columns = rows.len();
        let mut values = vec![0.0; offsets[supernodes.len()] * columns];
        for (column, &row) in rows.iter().enumerate() {
            let (unknowns, coefficients) = by_rows.column(row);
            for (&old, &coefficient) in unknowns.iter().zip(coefficients) {
                values[place[new_of_old[old]] * columns + column] = coefficient;
            }
        }
        let mut update = Vec::new();
        for &s in &supernodes {
            self.forward_block(s, |row| place[row], &mut values, columns, &mut update);
        }
        Block {
            rows: rows.to_vec(),
            supernodes,
            offsets,
            values,
        }
    }

    /// Where the columns of some supernodes go when they are kept one after another: offsets of the supernodes, places of
    /// all columns of the factor (meaningless for those of other supernodes).
    fn places(&self, supernodes: &[usize]) -> (Vec<usize>, Vec<usize>) {
        let mut offsets = vec![0];
        let mut place = vec![usize::MAX; self.size()];
        let mut next = 0;
        for &s in supernodes {
            for column in self.supernode_columns[s]..self.supernode_columns[s + 1] {
                place[column] = next;
                next += 1;
            }
            offsets.push(next);
        }
        (offsets, place)
    }
}

impl ForwardRows<'_> {
    /// The dual operator S = BA⁻¹Bᵀ = WᵀW, column-major, shape (rows of B, rows of B), exactly symmetric.
    pub fn gram(&self) -> Vec<f64> {
        let count = self.blocks.len();
        let pairs: Vec<(usize, usize)> = (0..count)
            .flat_map(|j| (j..count).map(move |i| (i, j)))
            .collect();
        let tiles: Vec<Vec<f64>> = pairs
            .par_iter()
            .map(|&(i, j)| self.blocks[i].product(&self.blocks[j]))
            .collect();
        let mut gram = vec![0.0; self.rows * self.rows];
        for (&(i, j), tile) in pairs.iter().zip(&tiles) {
            let (left, right) = (&self.blocks[i].rows, &self.blocks[j].rows);
            for (b, &column) in right.iter().enumerate() {
                let first = if i == j { b } else { 0 };
                for (a, &row) in left.iter().enumerate().skip(first) {
                    let value = tile[b * left.len() + a];
                    gram[column * self.rows + row] = value;
                    gram[row * self.rows + column] = value;
                }
            }
        }
        gram
    }

    /// The products Wᵀw with a forward solution w = L⁻¹Pl in the new numbering ([`CholeskyFactor::forward_solve`]): h = BA⁻¹l.
    ///
    /// # Panics
    /// When w does not have one entry per unknown.
    pub fn products_with(&self, w: &[f64]) -> Vec<f64> {
        assert_eq!(
            w.len(),
            self.factor.size(),
            "length of the forward solution"
        );
        let mut result = vec![0.0; self.rows];
        for block in &self.blocks {
            let mut sums = vec![0.0; block.rows.len()];
            let unknowns = block
                .supernodes
                .iter()
                .flat_map(|&s| self.factor.columns_of_supernode(s));
            for (unknown, line) in unknowns.zip(block.values.chunks_exact(block.rows.len())) {
                sums.iter_mut()
                    .zip(line)
                    .for_each(|(sum, value)| *sum += value * w[unknown]);
            }
            block
                .rows
                .iter()
                .zip(sums)
                .for_each(|(&row, sum)| result[row] = sum);
        }
        result
    }

    /// The compliance G = CA⁻¹Bᵀ, column-major, shape (rows of C, rows of B), by L⁻ᵀW on the unknowns that B and C reach.
    ///
    /// With B = MC this costs one backward pass over the rows of B. Half-solving C and forming CA⁻¹Cᵀ first would cost a
    /// forward pass over its rows, four times as many on panes of 2 × 2 faces.
    ///
    /// # Panics
    /// When C does not have one column per unknown.
    pub fn compliance(&self, c: &CscMatrix) -> Vec<f64> {
        let factor = self.factor;
        assert_eq!(c.cols, factor.size(), "columns of the selection");
        let by_rows = c.transpose();
        let new_of_old = factor.new_of_old();
        let selected = by_rows.indices.iter().map(|&old| new_of_old[old]);
        let loaded = self
            .blocks
            .iter()
            .flat_map(|block| &block.supernodes)
            .map(|&s| factor.supernode_columns[s]);
        let reach = factor.reach_of_columns(&factor.supernode_of_column(), selected.chain(loaded));
        let (offsets, place) = factor.places(&reach.supernodes);
        let mut compliance = vec![0.0; c.rows * self.rows];
        let columns: Vec<Vec<f64>> = self
            .blocks
            .par_iter()
            .map(|block| {
                let x = self.backward(
                    block,
                    &reach.supernodes,
                    offsets[reach.supernodes.len()],
                    &place,
                );
                selected_rows(&by_rows, &x, block.rows.len(), |old| place[new_of_old[old]])
            })
            .collect();
        for (block, columns) in self.blocks.iter().zip(&columns) {
            for (&row, column) in block.rows.iter().zip(columns.chunks_exact(c.rows.max(1))) {
                compliance[row * c.rows..(row + 1) * c.rows].copy_from_slice(column);
            }
        }
        compliance
    }

    /// L⁻ᵀ of one block of W on the given supernodes, row-major.
    fn backward(
        &self,
        block: &Block,
        supernodes: &[usize],
        unknowns: usize,
        place: &[usize],
    ) -> Vec<f64> {
        let columns = block.rows.len();
        let mut x = vec![0.0; unknowns * columns];
        for (k, &s) in block.supernodes.iter().enumerate() {
            let source = &block.values[block.offsets[k] * columns..block.offsets[k + 1] * columns];
            let start = place[self.factor.supernode_columns[s]] * columns;
            x[start..start + source.len()].copy_from_slice(source);
        }
        let mut known = Vec::new();
        for &s in supernodes.iter().rev() {
            self.factor
                .backward_block(s, |row| place[row], &mut x, columns, &mut known);
        }
        x
    }
}

impl Block {
    /// The tile WᵢᵀWⱼ of two blocks, column-major, summed over runs of supernodes that are neighbours in both.
    fn product(&self, other: &Block) -> Vec<f64> {
        let (m, n) = (self.rows.len(), other.rows.len());
        let mut tile = vec![0.0; m * n];
        let (mut i, mut j) = (0, 0);
        while i < self.supernodes.len() && j < other.supernodes.len() {
            match self.supernodes[i].cmp(&other.supernodes[j]) {
                std::cmp::Ordering::Less => i += 1,
                std::cmp::Ordering::Greater => j += 1,
                std::cmp::Ordering::Equal => {
                    let equal = |(a, b): &(&usize, &usize)| a == b;
                    let run = self.supernodes[i..]
                        .iter()
                        .zip(&other.supernodes[j..])
                        .take_while(equal)
                        .count();
                    let (left, right) = (self.lines(i, i + run), other.lines(j, j + run));
                    let target = MatMut::from_column_major_slice_mut(&mut tile, m, n);
                    matmul(target, Accum::Add, left.transpose(), right, 1.0, Par::Seq);
                    (i, j) = (i + run, j + run);
                }
            }
        }
        tile
    }

    /// The rows of W on the reached supernodes `from..to`.
    fn lines(&self, from: usize, to: usize) -> MatRef<'_, f64> {
        let columns = self.rows.len();
        let (start, end) = (self.offsets[from], self.offsets[to]);
        MatRef::from_row_major_slice(
            &self.values[start * columns..end * columns],
            end - start,
            columns,
        )
    }
}

/// C X, column-major, for a row-major X of `columns` columns and the columns of Cᵀ.
fn selected_rows(
    by_rows: &CscMatrix,
    x: &[f64],
    columns: usize,
    place: impl Fn(usize) -> usize,
) -> Vec<f64> {
    let mut result = vec![0.0; by_rows.cols * columns];
    for row in 0..by_rows.cols {
        let (unknowns, coefficients) = by_rows.column(row);
        for (&old, &coefficient) in unknowns.iter().zip(coefficients) {
            let line = &x[place(old) * columns..][..columns];
            for (column, value) in line.iter().enumerate() {
                result[column * by_rows.cols + row] += coefficient * value;
            }
        }
    }
    result
}

//! Supernodal Cholesky factorisation LLᵀ = PAPᵀ, kept as plain arrays.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::sparse::linalg::cholesky::SymbolicCholesky;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Par, Side};
use thiserror::Error;

use super::sparse::CscMatrix;

/// A pivot below this share of the diagonal entry it came from is rounding error, so the matrix counts as singular.
const SINGULAR_PIVOT: f64 = 64.0 * f64::EPSILON;

/// The supernodal Cholesky factor L of PAPᵀ = LLᵀ as plain arrays, to be stored and read again by another process.
///
/// Row i of PAPᵀ is row `permutation[i]` of A (new → old), that is (Px)ᵢ = x\[permutation\[i\]\].
/// Supernode s owns the consecutive columns `supernode_columns[s]..supernode_columns[s + 1]` of L. They share the rows
/// `row_indices[row_offsets[s]..row_offsets[s + 1]]`, strictly increasing, the first of which are the columns
/// themselves. Their coefficients are the dense column-major panel `values[value_offsets[s]..value_offsets[s + 1]]`
/// of shape (rows, columns); the strict upper triangle of its leading square is zero.
#[derive(Clone, Debug, PartialEq)]
pub struct CholeskyFactor {
    pub(super) permutation: Vec<usize>,
    pub(super) supernode_columns: Vec<usize>,
    pub(super) row_offsets: Vec<usize>,
    pub(super) row_indices: Vec<usize>,
    pub(super) value_offsets: Vec<usize>,
    pub(super) values: Vec<f64>,
}

/// Why a matrix was not factorised.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FactorError {
    /// The matrix is not square.
    #[error("a Cholesky factor needs a square matrix, got {rows} × {cols}")]
    NotSquare {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        cols: usize,
    },
    /// The ordering is not a permutation of the unknowns.
    #[error("the ordering of {length} entries is not a permutation of 0..{size}")]
    NotAPermutation {
        /// Length of the given ordering.
        length: usize,
        /// Number of unknowns.
        size: usize,
    },
    /// A pivot was negative, zero, not a number, or positive by rounding only.
    #[error("the matrix is not positive definite (pivot {pivot:e} at unknown {column})")]
    NotPositiveDefinite {
        /// The unknown, in the numbering of A, whose pivot failed.
        column: usize,
        /// The failed pivot, the square of the diagonal coefficient it would have given.
        pivot: f64,
    },
    /// Work space could not be allocated, or an index overflowed.
    #[error("not enough memory to factorise {size} unknowns")]
    OutOfMemory {
        /// Number of unknowns.
        size: usize,
    },
}

impl CholeskyFactor {
    /// Fills `values` by the numeric factorisation and refuses a singular matrix.
    pub(super) fn compute_values(
        &mut self,
        a: &CscMatrix,
        symbolic: &SymbolicCholesky<usize>,
        threads: usize,
    ) -> Result<(), FactorError> {
        let out_of_memory = FactorError::OutOfMemory { size: a.cols };
        let par = parallelism(threads);
        let mut values = Vec::new();
        values
            .try_reserve_exact(symbolic.len_val())
            .map_err(|_| out_of_memory.clone())?;
        values.resize(symbolic.len_val(), 0.0);
        let scratch = symbolic.factorize_numeric_llt_scratch::<f64>(par, Default::default());
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| out_of_memory)?;
        let matrix = SparseColMatRef::new(pattern(a), &a.data);
        let stack = MemStack::new(&mut memory);
        let outcome = symbolic
            .factorize_numeric_llt(
                &mut values,
                matrix,
                Side::Upper,
                Default::default(),
                par,
                stack,
                Default::default(),
            )
            .map(|_| ());
        self.values = values;
        outcome.map_err(|LltError::NonPositivePivot { index }| {
            FactorError::NotPositiveDefinite {
                column: self.permutation[index],
                pivot: self.failed_pivot(a, index),
            }
        })?;
        self.clear_upper_triangles();
        self.refuse_singular(a)
    }

    /// The pivot a_jj − Σₖ Lⱼₖ² of column j (new numbering) from the finished columns of the row.
    fn failed_pivot(&self, a: &CscMatrix, j: usize) -> f64 {
        let mut pivot = diagonal(a, self.permutation[j]);
        for s in 0..self.supernodes() {
            let panel = self.panel(s);
            if panel.first > j {
                break;
            }
            let Ok(row) = panel.rows.binary_search(&j) else {
                continue;
            };
            let height = panel.rows.len();
            let finished = panel.width.min(j - panel.first);
            pivot -= (0..finished)
                .map(|k| panel.values[k * height + row].powi(2))
                .sum::<f64>();
        }
        pivot
    }

    /// Zeroes what the dense kernels left above the diagonals, so that equal factors have equal bits.
    fn clear_upper_triangles(&mut self) {
        for s in 0..self.supernodes() {
            let height = self.row_offsets[s + 1] - self.row_offsets[s];
            let panel = &mut self.values[self.value_offsets[s]..self.value_offsets[s + 1]];
            for (k, column) in panel.chunks_exact_mut(height).enumerate() {
                column[..k].fill(0.0);
            }
        }
    }

    /// Refuses pivots that are positive by rounding only, or not numbers.
    fn refuse_singular(&self, a: &CscMatrix) -> Result<(), FactorError> {
        for s in 0..self.supernodes() {
            let panel = self.panel(s);
            for k in 0..panel.width {
                let pivot = panel.values[k * (panel.rows.len() + 1)].powi(2);
                let column = self.permutation[panel.first + k];
                if !(pivot > SINGULAR_PIVOT * diagonal(a, column) && pivot.is_finite()) {
                    return Err(FactorError::NotPositiveDefinite { column, pivot });
                }
            }
        }
        Ok(())
    }

    /// The permutation, new → old: row i of PAPᵀ is row `permutation()[i]` of A.
    #[must_use]
    pub fn permutation(&self) -> &[usize] {
        &self.permutation
    }

    /// First column of each supernode and, last, the number of unknowns.
    #[must_use]
    pub fn supernode_columns(&self) -> &[usize] {
        &self.supernode_columns
    }

    /// Start of each supernode's rows in [`Self::row_indices`], one more than there are supernodes.
    #[must_use]
    pub fn row_offsets(&self) -> &[usize] {
        &self.row_offsets
    }

    /// Rows of each supernode, its own columns first, strictly increasing inside a supernode.
    #[must_use]
    pub fn row_indices(&self) -> &[usize] {
        &self.row_indices
    }

    /// Start of each supernode's panel in [`Self::values`], one more than there are supernodes.
    #[must_use]
    pub fn value_offsets(&self) -> &[usize] {
        &self.value_offsets
    }

    /// The dense column-major panels, one after another.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Number of coefficients, known before they are computed.
    #[must_use]
    pub(crate) fn value_count(&self) -> usize {
        self.value_offsets.last().copied().unwrap_or(0)
    }

    /// Number of unknowns.
    #[must_use]
    pub fn size(&self) -> usize {
        self.permutation.len()
    }

    /// Number of supernodes.
    #[must_use]
    pub fn supernodes(&self) -> usize {
        self.supernode_columns.len() - 1
    }

    /// The supernode s as a dense panel, without coefficients before the numeric factorisation.
    pub(super) fn panel(&self, s: usize) -> Panel<'_> {
        let first = self.supernode_columns[s];
        Panel {
            first,
            width: self.supernode_columns[s + 1] - first,
            rows: &self.row_indices[self.row_offsets[s]..self.row_offsets[s + 1]],
            values: (self.values)
                .get(self.value_offsets[s]..self.value_offsets[s + 1])
                .unwrap_or_default(),
        }
    }
}

/// One supernode of a factor: `width` columns from `first` over `rows`, coefficients column-major.
#[derive(Clone, Copy)]
pub(super) struct Panel<'a> {
    pub(super) first: usize,
    pub(super) width: usize,
    pub(super) rows: &'a [usize],
    pub(super) values: &'a [f64],
}

pub(super) fn pattern(a: &CscMatrix) -> SymbolicSparseColMatRef<'_, usize> {
    SymbolicSparseColMatRef::new_checked(a.rows, a.cols, &a.indptr, None, &a.indices)
}

fn diagonal(a: &CscMatrix, column: usize) -> f64 {
    let (rows, coefficients) = a.column(column);
    rows.binary_search(&column)
        .map_or(0.0, |place| coefficients[place])
}

/// How many threads faer may use.
pub(super) fn parallelism(threads: usize) -> Par {
    if threads > 1 {
        Par::rayon(threads)
    } else {
        Par::Seq
    }
}

//! Supernodal Cholesky factorisation LLᵀ = PAPᵀ, kept as plain arrays.

use faer::sparse::SymbolicSparseColMatRef;
use thiserror::Error;

use super::fronts::{self, Failure};
use super::scalar::Scalar;
use super::sparse::CscMatrix;
use super::structure::{FactorStructure, Front};
use super::work::Work;

/// A pivot below this many units of rounding of the diagonal entry it came from is rounding error, so the matrix counts as
/// singular.
const SINGULAR_PIVOT: f64 = 64.0;

/// The supernodal Cholesky factor L of PAPᵀ = LLᵀ in single or double precision, as plain arrays that a file can hold: the dense
/// column-major panels of [`FactorStructure`], one after another.
#[derive(Clone, Debug, PartialEq)]
pub struct CholeskyFactor<T = f64> {
    pub(super) structure: FactorStructure,
    pub(super) values: Vec<T>,
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

impl<T: Scalar> CholeskyFactor<T> {
    /// Factorises the symmetric positive definite A as LLᵀ = PAPᵀ by the multifrontal method, structure first.
    ///
    /// The factor has the same bits at any number of threads.
    ///
    /// # Errors
    /// [`FactorError`] when A is not square, the ordering is no permutation, a pivot is not safely positive, or memory runs out.
    pub fn factorise(a: &CscMatrix, permutation: Vec<usize>) -> Result<Self, FactorError> {
        let structure = FactorStructure::analyse(a, permutation)?;
        Self::of_structure(structure, a, &Work::default())
    }

    /// Computes the coefficients of L for the matrix that was analysed, or another with its structure.
    ///
    /// The values of the matrix's lower triangle are not read. `work` is told of all [`FactorStructure::operations`].
    ///
    /// # Errors
    /// [`FactorError`] when a pivot is not safely positive, or memory runs out.
    pub fn of_structure(
        structure: FactorStructure,
        a: &CscMatrix,
        work: &Work,
    ) -> Result<Self, FactorError> {
        let out_of_memory = FactorError::OutOfMemory { size: a.cols };
        let values = fronts::zeros(structure.value_count()).ok_or(out_of_memory.clone())?;
        let mut factor = Self { structure, values };
        let outcome = fronts::factorise(&factor.structure, a, &mut factor.values, work);
        outcome.map_err(|failure| match failure {
            Failure::OutOfMemory => out_of_memory,
            Failure::Pivot(column) => FactorError::NotPositiveDefinite {
                column: factor.structure.permutation[column],
                pivot: factor.failed_pivot(a, column),
            },
        })?;
        factor.refuse_singular(a)?;
        Ok(factor)
    }

    /// The pivot a_jj − Σₖ Lⱼₖ² of column j (new numbering) from the finished columns of the row.
    fn failed_pivot(&self, a: &CscMatrix, j: usize) -> f64 {
        let mut pivot = a.diagonal(self.structure.permutation[j]);
        for s in 0..self.structure.supernodes() {
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
                .map(|k| panel.values[k * height + row].to_double().powi(2))
                .sum::<f64>();
        }
        pivot
    }

    /// Refuses pivots that are positive by rounding only, or not numbers.
    fn refuse_singular(&self, a: &CscMatrix) -> Result<(), FactorError> {
        for s in 0..self.structure.supernodes() {
            let panel = self.panel(s);
            for k in 0..panel.width {
                let pivot = panel.values[k * (panel.rows.len() + 1)].to_double().powi(2);
                let column = self.structure.permutation[panel.first + k];
                let rounding = SINGULAR_PIVOT * T::EPSILON * a.diagonal(column);
                if !(pivot > rounding && pivot.is_finite()) {
                    return Err(FactorError::NotPositiveDefinite { column, pivot });
                }
            }
        }
        Ok(())
    }

    /// Where the coefficients stand.
    #[must_use]
    pub fn structure(&self) -> &FactorStructure {
        &self.structure
    }

    /// The dense column-major panels, one after another.
    #[must_use]
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// Number of unknowns.
    #[must_use]
    pub fn size(&self) -> usize {
        self.structure.size()
    }

    /// The supernode s as a dense panel.
    pub(super) fn panel(&self, s: usize) -> Panel<'_, T> {
        let Front { first, width, rows } = self.structure.front(s);
        let offsets = &self.structure.value_offsets;
        let values = &self.values[offsets[s]..offsets[s + 1]];
        Panel {
            first,
            width,
            rows,
            values,
        }
    }
}

/// One supernode of a factor: `width` columns from `first` over `rows`, coefficients column-major.
#[derive(Clone, Copy)]
pub(super) struct Panel<'a, T> {
    pub(super) first: usize,
    pub(super) width: usize,
    pub(super) rows: &'a [usize],
    pub(super) values: &'a [T],
}

pub(super) fn pattern(a: &CscMatrix) -> SymbolicSparseColMatRef<'_, usize> {
    SymbolicSparseColMatRef::new_checked(a.rows, a.cols, &a.indptr, None, &a.indices)
}

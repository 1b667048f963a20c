//! Supernodal Cholesky factorisation LLᵀ = PAPᵀ, kept as plain arrays that a file can hold.

use faer::sparse::SymbolicSparseColMatRef;
use thiserror::Error;

use super::{
    analysis::{FactorStructure, Front, inverse},
    fronts::{self, Failure},
    precision::Scalar,
    sparse::CscMatrix,
    work::Work,
};

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
            let (front, values) = self.panel(s);
            if front.first > j {
                break;
            }
            let Ok(row) = front.rows.binary_search(&j) else {
                continue;
            };
            let columns = values.chunks_exact(front.rows.len());
            let finished = columns.take(front.width.min(j - front.first));
            let squares = finished.map(|column| column[row].to_double().powi(2));
            pivot -= squares.sum::<f64>();
        }
        pivot
    }

    /// Refuses pivots that are positive by rounding only, or not numbers.
    fn refuse_singular(&self, a: &CscMatrix) -> Result<(), FactorError> {
        for s in 0..self.structure.supernodes() {
            let (front, values) = self.panel(s);
            for k in 0..front.width {
                let pivot = values[k * (front.rows.len() + 1)].to_double().powi(2);
                let column = self.structure.permutation[front.first + k];
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

    /// The supernode s and its dense column-major panel.
    pub(super) fn panel(&self, s: usize) -> (Front<'_>, &[T]) {
        let offsets = &self.structure.value_offsets;
        let values = &self.values[offsets[s]..offsets[s + 1]];
        (self.structure.front(s), values)
    }
}

pub(super) fn pattern(a: &CscMatrix) -> SymbolicSparseColMatRef<'_, usize> {
    SymbolicSparseColMatRef::new_checked(a.rows, a.cols, &a.indptr, None, &a.indices)
}

/// Which rule of [`CholeskyFactor`]'s layout stored arrays break.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PartsError {
    /// `permutation` is not a permutation.
    #[error("the stored ordering is not a permutation")]
    Permutation,
    /// `supernode_columns` does not rise strictly from 0 to the number of unknowns.
    #[error("supernode columns do not rise from 0 to the {size} unknowns")]
    SupernodeColumns {
        /// Number of unknowns.
        size: usize,
    },
    /// `row_offsets` or `value_offsets` does not fit its array.
    #[error("offsets of supernode {supernode} do not fit its rows and columns")]
    Offsets {
        /// The first offending supernode.
        supernode: usize,
    },
    /// Rows do not start with the supernode's columns, do not increase, or are not rows of its
    /// parent.
    #[error("rows of supernode {supernode} contradict the elimination tree")]
    Rows {
        /// The first offending supernode.
        supernode: usize,
    },
    /// A coefficient is not finite, or a diagonal one not positive, or one above the diagonal not
    /// zero.
    #[error("coefficients of supernode {supernode} are not those of a Cholesky factor")]
    Values {
        /// The first offending supernode.
        supernode: usize,
    },
}

impl<T: Scalar> CholeskyFactor<T> {
    /// Rebuilds a factor from its arrays, checking every rule stated at [`FactorStructure`].
    ///
    /// # Errors
    /// [`PartsError`] names the first rule broken; a factor that was accepted cannot cause a panic
    /// in a solve.
    pub fn from_parts(structure: FactorStructure, values: Vec<T>) -> Result<Self, PartsError> {
        inverse(&structure.permutation).ok_or(PartsError::Permutation)?;
        structure.check_supernode_columns()?;
        structure.check_offsets(values.len())?;
        let factor = Self { structure, values };
        let owner = factor.structure.supernode_of_column();
        for supernode in 0..factor.structure.supernodes() {
            if !factor.structure.rows_are_sound(supernode, &owner) {
                return Err(PartsError::Rows { supernode });
            }
            if !factor.values_are_sound(supernode) {
                return Err(PartsError::Values { supernode });
            }
        }
        Ok(factor)
    }

    fn values_are_sound(&self, s: usize) -> bool {
        let (front, values) = self.panel(s);
        let mut columns = values.chunks_exact(front.rows.len()).enumerate();
        columns.all(|(k, column)| {
            let (above, rest) = column.split_at(k);
            above.iter().all(|&value| value == T::default())
                && rest[0] > T::default()
                && rest.iter().all(|value| value.to_double().is_finite())
        })
    }
}

impl FactorStructure {
    fn check_supernode_columns(&self) -> Result<(), PartsError> {
        let size = self.size();
        let columns = &self.supernode_columns;
        let ends = columns.first() == Some(&0) && columns.last() == Some(&size);
        if ends && columns.windows(2).all(|pair| pair[0] < pair[1]) {
            Ok(())
        } else {
            Err(PartsError::SupernodeColumns { size })
        }
    }

    /// Row and value offsets start at 0, end with their arrays, and leave (rows × columns) values
    /// to each supernode.
    fn check_offsets(&self, n_values: usize) -> Result<(), PartsError> {
        let supernodes = self.supernodes();
        let (rows, values) = (&self.row_offsets, &self.value_offsets);
        let ends = |offsets: &[usize], length| {
            offsets.len() == supernodes + 1 && offsets[0] == 0 && offsets[supernodes] == length
        };
        if !ends(rows, self.row_indices.len()) || !ends(values, n_values) {
            return Err(PartsError::Offsets { supernode: 0 });
        }
        for s in 0..supernodes {
            let width = self.supernode_columns[s + 1] - self.supernode_columns[s];
            let height = rows[s + 1]
                .checked_sub(rows[s])
                .filter(|&height| height >= width);
            let entries = values[s + 1].checked_sub(values[s]);
            let expected = height.and_then(|height| height.checked_mul(width));
            let inside = rows[s + 1] <= self.row_indices.len() && values[s + 1] <= n_values;
            if expected.is_none() || entries != expected || !inside {
                return Err(PartsError::Offsets { supernode: s });
            }
        }
        Ok(())
    }

    /// Own columns first, strictly increasing, below the size, and every row past the parent's
    /// first column a row of the parent.
    fn rows_are_sound(&self, s: usize, owner: &[usize]) -> bool {
        let panel = self.front(s);
        let (own, below) = panel.rows.split_at(panel.width);
        let increasing = panel.rows.windows(2).all(|pair| pair[0] < pair[1]);
        let inside = panel.rows.last().is_some_and(|&row| row < self.size());
        if !increasing
            || !inside
            || !own
                .iter()
                .copied()
                .eq(panel.first..panel.first + panel.width)
        {
            return false;
        }
        let Some(&next) = below.first() else {
            return true;
        };
        let mut parent_rows = self.front(owner[next]).rows.iter();
        below
            .iter()
            .all(|row| parent_rows.any(|candidate| candidate == row))
    }
}

//! Supernodal Cholesky factorisation LLᵀ = PAPᵀ, kept as plain arrays that a file can hold, in either precision, here or in an engine.

use super::{
    engine::{EngineError, RemoteFactor},
    fronts::{self, Failure},
    precision::{Precision, Scalar},
    sparse::CscMatrix,
    structure::{FactorError, FactorStructure, Front, PartsError},
    tasks::Work,
};

/// The supernodal Cholesky factor L of PAPᵀ = LLᵀ in single or double precision, as plain arrays that a file can hold: the dense
/// column-major panels of [`FactorStructure`], one after another.
#[derive(Clone, Debug, PartialEq)]
pub struct CholeskyFactor<T = f64> {
    pub(super) structure: FactorStructure,
    pub(super) values: Vec<T>,
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

    /// Refuses pivots that are positive by rounding only, below 64 units of it in the diagonal entry that they came from, or not
    /// numbers.
    fn refuse_singular(&self, a: &CscMatrix) -> Result<(), FactorError> {
        for s in 0..self.structure.supernodes() {
            let (front, values) = self.panel(s);
            for k in 0..front.width {
                let pivot = values[k * (front.rows.len() + 1)].to_double().powi(2);
                let column = self.structure.permutation[front.first + k];
                let rounding = 64.0 * T::epsilon() * a.diagonal(column);
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

impl<T: Scalar> CholeskyFactor<T> {
    /// Rebuilds a factor from its arrays, checking every rule stated at [`FactorStructure`].
    ///
    /// # Errors
    /// [`PartsError`] names the first rule broken; a factor that was accepted cannot cause a panic
    /// in a solve.
    pub fn from_parts(structure: FactorStructure, values: Vec<T>) -> Result<Self, PartsError> {
        structure.check(values.len())?;
        let factor = Self { structure, values };
        match (0..factor.structure.supernodes()).find(|&s| !factor.values_are_sound(s)) {
            Some(supernode) => Err(PartsError {
                rule: "finite coefficients, positive on the diagonal and zero above it",
                supernode,
            }),
            None => Ok(factor),
        }
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

/// A Cholesky factor in double precision, or one in single precision: half the memory, about half the time, and a
/// preconditioner that conjugate gradients reach double precision with in a few steps.
#[derive(Clone, Debug, PartialEq)]
pub enum Factor {
    /// Solves to rounding.
    Double(CholeskyFactor<f64>),
    /// Solves to about four digits, or as many as seven less the logarithm of the condition number leave.
    Single(CholeskyFactor<f32>),
    /// In single precision, in the processes of another program.
    Remote(RemoteFactor),
}

impl Factor {
    /// Computes the coefficients for a matrix that was analysed, and tells `work` how far it is.
    ///
    /// # Errors
    /// [`FactorError`] when a pivot is not safely positive in this precision, or memory runs out.
    pub fn of_structure(
        structure: FactorStructure,
        a: &CscMatrix,
        precision: Precision,
        work: &Work,
    ) -> Result<Self, FactorError> {
        Ok(match precision {
            Precision::Double => Self::Double(CholeskyFactor::of_structure(structure, a, work)?),
            Precision::Single => Self::Single(CholeskyFactor::of_structure(structure, a, work)?),
        })
    }

    /// The precision of the coefficients.
    #[must_use]
    pub fn precision(&self) -> Precision {
        match self {
            Self::Double(_) => Precision::Double,
            Self::Single(_) | Self::Remote(_) => Precision::Single,
        }
    }

    /// What ended the program that holds the factor, after which its answers are no numbers.
    #[must_use]
    pub fn failure(&self) -> Option<EngineError> {
        match self {
            Self::Double(_) | Self::Single(_) => None,
            Self::Remote(factor) => factor.failure(),
        }
    }

    /// Where the coefficients stand.
    #[must_use]
    pub fn structure(&self) -> &FactorStructure {
        match self {
            Self::Double(factor) => factor.structure(),
            Self::Single(factor) => factor.structure(),
            Self::Remote(factor) => factor.structure(),
        }
    }

    /// Solves LLᵀ x = b in place, to the precision of the factor.
    ///
    /// # Panics
    /// When `rhs` does not have one entry per unknown.
    pub fn solve_in_place(&self, rhs: &mut [f64]) {
        match self {
            Self::Double(factor) => factor.solve_in_place(rhs),
            Self::Single(factor) => factor.solve_in_place(rhs),
            Self::Remote(factor) => factor.solve_several(&mut [rhs]),
        }
    }

    /// The same on the supernodes that a right-hand side reaches, for forces and displacements there.
    pub(crate) fn solve_reached(&self, reach: &[usize], rhs: &mut [f64]) {
        match self {
            Self::Double(factor) => factor.solve_reached(reach, rhs),
            Self::Single(factor) => factor.solve_reached(reach, rhs),
            Self::Remote(factor) => factor.solve_several(&mut [rhs]),
        }
    }

    /// The same for several right-hand sides, which share the reading of the factor.
    pub(crate) fn solve_several(&self, rhs: &mut [&mut [f64]]) {
        match self {
            Self::Double(factor) => factor.solve_several(rhs),
            Self::Single(factor) => factor.solve_several(rhs),
            Self::Remote(factor) => factor.solve_several(rhs),
        }
    }
}

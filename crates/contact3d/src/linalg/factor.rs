//! A Cholesky factor in either precision, here or in an engine, and its solves.

use super::{
    cholesky::CholeskyFactor,
    engine::{EngineError, RemoteFactor},
    precision::Precision,
    sparse::CscMatrix,
    structure::{FactorError, FactorStructure},
    tasks::Work,
};

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

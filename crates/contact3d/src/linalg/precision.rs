//! A factor in either precision.

use super::factor::{CholeskyFactor, FactorError};
use super::solve::Workspace;
use super::sparse::CscMatrix;
use super::structure::FactorStructure;
use super::work::Work;

/// A Cholesky factor in double precision, or one in single precision: half the memory, about half the time, and a
/// preconditioner that conjugate gradients reach double precision with in a few steps.
#[derive(Clone, Debug, PartialEq)]
pub enum Factor {
    /// Solves to rounding.
    Double(CholeskyFactor<f64>),
    /// Solves to about four digits, or as many as seven less the logarithm of the condition number leave.
    Single(CholeskyFactor<f32>),
}

/// The precision that coefficients are stored in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 24 bits.
    Single,
    /// 53 bits.
    Double,
}

impl Precision {
    /// Bytes of a number.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Self::Single => size_of::<f32>(),
            Self::Double => size_of::<f64>(),
        }
    }

    /// In words: "single" or "double".
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Double => "double",
        }
    }
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
            Self::Single(_) => Precision::Single,
        }
    }

    /// Where the coefficients stand.
    #[must_use]
    pub fn structure(&self) -> &FactorStructure {
        match self {
            Self::Double(factor) => factor.structure(),
            Self::Single(factor) => factor.structure(),
        }
    }

    /// Solves LLᵀ x = b in place, to the precision of the factor.
    ///
    /// # Panics
    /// When `rhs` does not have one entry per unknown.
    pub fn solve_in_place(&self, rhs: &mut [f64], work: &mut Workspace) {
        match self {
            Self::Double(factor) => factor.solve_in_place(rhs, work),
            Self::Single(factor) => factor.solve_in_place(rhs, work),
        }
    }

    /// The same for several right-hand sides, which share the reading of the factor.
    pub(crate) fn solve_several(&self, rhs: &mut [&mut [f64]]) {
        match self {
            Self::Double(factor) => factor.solve_several(rhs),
            Self::Single(factor) => factor.solve_several(rhs),
        }
    }
}

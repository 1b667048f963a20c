//! The two precisions of a factor.

use std::ops::{AddAssign, Div, DivAssign, SubAssign};

use faer::traits::RealField;

use super::{
    analysis::FactorStructure,
    engine::{EngineError, RemoteFactor},
    factor::{CholeskyFactor, FactorError},
    solve::{ScratchPool, Workspace},
    sparse::CscMatrix,
    work::Work,
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
    pub fn solve_in_place(&self, rhs: &mut [f64], work: &mut Workspace) {
        match self {
            Self::Double(factor) => factor.solve_in_place(rhs, work),
            Self::Single(factor) => factor.solve_in_place(rhs, work),
            Self::Remote(factor) => factor.solve_several(&mut [rhs]),
        }
    }

    /// The same on the supernodes that a right-hand side reaches, for forces and displacements there.
    pub(crate) fn solve_reached(&self, reach: &[usize], rhs: &mut [f64], work: &mut Workspace) {
        match self {
            Self::Double(factor) => factor.solve_reached(reach, rhs, work),
            Self::Single(factor) => factor.solve_reached(reach, rhs, work),
            Self::Remote(factor) => factor.solve_several(&mut [rhs]),
        }
    }

    /// The same for several right-hand sides, which share the reading of the factor.
    pub(crate) fn solve_several(&self, rhs: &mut [&mut [f64]], work: &mut Workspace) {
        match self {
            Self::Double(factor) => factor.solve_several(rhs, work),
            Self::Single(factor) => factor.solve_several(rhs, work),
            Self::Remote(factor) => factor.solve_several(rhs),
        }
    }
}

/// A floating-point number that coefficients of a factor are stored in.
pub trait Scalar:
    RealField
    + Copy
    + Default
    + PartialOrd
    + Send
    + Sync
    + AddAssign
    + SubAssign
    + DivAssign
    + Div<Output = Self>
    + 'static
{
    /// The distance from 1 to the next larger number.
    const EPSILON: f64;

    /// The nearest number.
    fn rounded(value: f64) -> Self;

    /// The same number in double precision.
    fn to_double(self) -> f64;

    /// The memory of solves in this precision.
    #[doc(hidden)]
    fn scratch(work: &Workspace) -> &ScratchPool<Self, 1>;
}

impl Scalar for f64 {
    const EPSILON: f64 = f64::EPSILON;

    #[inline(always)]
    fn rounded(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn to_double(self) -> f64 {
        self
    }

    fn scratch(work: &Workspace) -> &ScratchPool<Self, 1> {
        &work.double
    }
}

impl Scalar for f32 {
    const EPSILON: f64 = f32::EPSILON as f64;

    #[inline(always)]
    fn rounded(value: f64) -> Self {
        value as f32
    }

    #[inline(always)]
    fn to_double(self) -> f64 {
        f64::from(self)
    }

    fn scratch(work: &Workspace) -> &ScratchPool<Self, 1> {
        &work.single
    }
}

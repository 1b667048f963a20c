//! The two precisions of a factor.

use std::ops::{AddAssign, Div, DivAssign, SubAssign};

use faer::traits::RealField;

/// What some thousand roundings leave of numbers of size one: of zero in a unit vector, as in the cosine of 90° or a normal on a plane
/// of symmetry, of formulas and of sums over places that agree.
pub(crate) const UNIT_ROUNDING: f64 = 1e-12;

/// Roundings that a few terms, or the root of some hundred, may add up to, in units of ε_M.
pub(crate) const FEW_ROUNDINGS: f64 = 16.0;

units::worded! {
    /// The precision that coefficients are stored in.
    pub enum Precision {
        /// 24 bits.
        Single = "single",
        /// 53 bits.
        Double = "double",
    }
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
    fn epsilon() -> f64;

    /// The nearest number.
    fn rounded(value: f64) -> Self;

    /// The same number in double precision.
    fn to_double(self) -> f64;
}

impl Scalar for f64 {
    fn epsilon() -> f64 {
        f64::EPSILON
    }

    #[inline(always)]
    fn rounded(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn to_double(self) -> f64 {
        self
    }
}

impl Scalar for f32 {
    fn epsilon() -> f64 {
        f64::from(f32::EPSILON)
    }

    #[inline(always)]
    fn rounded(value: f64) -> Self {
        value as f32
    }

    #[inline(always)]
    fn to_double(self) -> f64 {
        f64::from(self)
    }
}

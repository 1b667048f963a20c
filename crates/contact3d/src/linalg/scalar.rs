//! The two precisions of a factor.

use std::ops::{AddAssign, Div, DivAssign, SubAssign};

use faer::traits::RealField;

use super::solve::{ScratchPool, Workspace};

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
    fn scratch(work: &Workspace) -> &ScratchPool<Self>;
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

    fn scratch(work: &Workspace) -> &ScratchPool<Self> {
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

    fn scratch(work: &Workspace) -> &ScratchPool<Self> {
        &work.single
    }
}

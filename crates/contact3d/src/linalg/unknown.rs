//! What substitution computes with: one number, or several right-hand sides that share every coefficient of the factor.

use std::array::from_fn;
use std::ops::{Add, AddAssign, Div, Mul, SubAssign};

use super::precision::Scalar;

/// Right-hand sides solved together: in single precision one vector register holds a row of them.
pub(super) const SEVERAL: usize = 8;

/// Columns treated together: each entry of the running sums is then loaded once for four
/// coefficients.
pub(super) const COLUMNS: usize = 4;

/// Rows treated together in the dot products of one right-hand side.
const LANES: usize = 8;

/// An unknown of a system whose coefficients are of type T.
pub(super) trait Unknown<T>:
    Copy
    + Default
    + Send
    + Sync
    + Add<Output = Self>
    + AddAssign
    + SubAssign
    + Mul<T, Output = Self>
    + Div<T, Output = Self>
{
    /// The products columns[k]ᵀ y.
    fn four_dots(columns: [&[T]; COLUMNS], y: &[Self]) -> [Self; COLUMNS];

    /// columnᵀ y, summed in order.
    #[inline(always)]
    fn dot(column: &[T], y: &[Self]) -> Self
    where
        T: Copy,
    {
        let mut sum = Self::default();
        for (l, y) in column.iter().zip(y) {
            sum += *y * *l;
        }
        sum
    }
}

impl<T: Scalar> Unknown<T> for T {
    /// Each summed in interleaved parts.
    #[inline(always)]
    fn four_dots(columns: [&[T]; COLUMNS], y: &[T]) -> [T; COLUMNS] {
        let [a, b, c, d] = columns.map(|column| column[..y.len()].as_chunks::<LANES>());
        let (whole, rest) = y.as_chunks::<LANES>();
        let mut sums = [[T::default(); LANES]; COLUMNS];
        for ((((y, a), b), c), d) in whole.iter().zip(a.0).zip(b.0).zip(c.0).zip(d.0) {
            add_products(&mut sums[0], a, y);
            add_products(&mut sums[1], b, y);
            add_products(&mut sums[2], c, y);
            add_products(&mut sums[3], d, y);
        }
        let tails = [a.1, b.1, c.1, d.1];
        from_fn(|k| {
            let [a, b, c, d, e, f, g, h] = sums[k];
            ((a + b) + (c + d)) + ((e + f) + (g + h)) + T::dot(tails[k], rest)
        })
    }
}

#[inline(always)]
fn add_products<T: Scalar>(sums: &mut [T; LANES], x: &[T; LANES], y: &[T; LANES]) {
    for i in 0..LANES {
        sums[i] += x[i] * y[i];
    }
}

/// One row of several right-hand sides.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Several<T>(pub(super) [T; SEVERAL]);

impl<T: Scalar> Unknown<T> for Several<T> {
    #[inline(always)]
    fn four_dots(columns: [&[T]; COLUMNS], y: &[Self]) -> [Self; COLUMNS] {
        let [a, b, c, d] = columns.map(|column| &column[..y.len()]);
        let mut sums = [Self::default(); COLUMNS];
        for i in 0..y.len() {
            sums[0] += y[i] * a[i];
            sums[1] += y[i] * b[i];
            sums[2] += y[i] * c[i];
            sums[3] += y[i] * d[i];
        }
        sums
    }
}

impl<T: Scalar> Add for Several<T> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl<T: Scalar> AddAssign for Several<T> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        for i in 0..SEVERAL {
            self.0[i] += other.0[i];
        }
    }
}

impl<T: Scalar> SubAssign for Several<T> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        for i in 0..SEVERAL {
            self.0[i] -= other.0[i];
        }
    }
}

impl<T: Scalar> Mul<T> for Several<T> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        Self(self.0.map(|value| value * factor))
    }
}

impl<T: Scalar> Div<T> for Several<T> {
    type Output = Self;

    #[inline(always)]
    fn div(self, divisor: T) -> Self {
        Self(self.0.map(|value| value / divisor))
    }
}

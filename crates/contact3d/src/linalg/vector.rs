//! Dense vector kernels in a fixed summation order.

/// Runs a loop compiled for the widest vectors of the processor; what it calls must be inlined into it. Sums keep their order:
/// the bits do not depend on the processor.
#[inline(always)]
pub(crate) fn vectorised<R>(run: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(run)
}

/// xᵀy.
#[must_use]
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum()
}

/// ‖x‖ without overflow or underflow of the squares.
#[must_use]
pub fn norm(x: &[f64]) -> f64 {
    let largest = x.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if largest == 0.0 || !largest.is_finite() {
        let nan = x.iter().any(|v| v.is_nan());
        return if nan { f64::NAN } else { largest };
    }
    largest * x.iter().map(|v| (v / largest).powi(2)).sum::<f64>().sqrt()
}

/// A power of two near the largest entry: dividing by it brings the others into the small range of single precision and changes
/// no bits. `None` where all are zero.
pub(crate) fn power_of_two_near_largest(x: &[f64]) -> Option<f64> {
    let largest = x.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    (largest != 0.0).then(|| {
        if largest.is_finite() {
            largest.log2().floor().exp2()
        } else {
            1.0
        }
    })
}

/// x − y.
#[must_use]
pub fn difference(x: &[f64], y: &[f64]) -> Vec<f64> {
    x.iter().zip(y).map(|(x, y)| x - y).collect()
}

/// y ← y + a x.
pub fn add_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

#[cfg(test)]
mod tests {
    use super::norm;

    #[test]
    fn norms_neither_overflow_nor_hide_what_is_not_finite() {
        // Two roundings.
        assert!((norm(&[3e200, 4e200]) / 5e200 - 1.0).abs() < 1e-15);
        assert_eq!(norm(&[]), 0.0);
        assert!(norm(&[f64::NAN, 0.0]).is_nan() && norm(&[f64::INFINITY, f64::NAN]).is_nan());
        assert_eq!(norm(&[f64::INFINITY, 1.0]), f64::INFINITY);
    }
}

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
#[must_use]
pub fn power_of_two_near_largest(x: &[f64]) -> Option<f64> {
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

/// y ← y + Σ aₖ xₖ, one after another.
pub(crate) fn add_combination(y: &mut [f64], weights: &[f64], vectors: &[Vec<f64>]) {
    for (a, x) in weights.iter().zip(vectors) {
        add_scaled(y, *a, x);
    }
}

/// Takes the parts along orthonormal vectors out of a vector, by so many passes of Gram and Schmidt's modified method: two leave
/// it orthogonal to rounding. Gives these parts.
pub(crate) fn orthogonalise(vector: &mut [f64], basis: &[Vec<f64>], passes: usize) -> Vec<f64> {
    let mut parts = vec![0.0; basis.len()];
    for _ in 0..passes {
        for (part, v) in parts.iter_mut().zip(basis) {
            let along = dot(vector, v);
            *part += along;
            add_scaled(vector, -along, v);
        }
    }
    parts
}

//! Dense vectors: products in a fixed order, and sums and residuals in twice the working precision.

use rayon::prelude::*;

use super::sparse::CscMatrix;

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

/// The larger of two numbers; NaN where one of them is, which [`f64::max`] drops.
pub(crate) fn larger(x: f64, y: f64) -> f64 {
    if (x + y).is_nan() { f64::NAN } else { x.max(y) }
}

/// part / whole, and 0 for 0/0.
#[must_use]
pub fn ratio(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
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

/// A vector as the unevaluated sum of two, about 32 digits: what is left when large parts of it
/// cancel, as the rigid motion of a body does in the displacements of its contact face, is still
/// accurate.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Doubled {
    /// The vector, rounded.
    pub value: Vec<f64>,
    /// What rounding took from it.
    pub remainder: Vec<f64>,
}

impl From<Vec<f64>> for Doubled {
    fn from(value: Vec<f64>) -> Self {
        Self {
            remainder: vec![0.0; value.len()],
            value,
        }
    }
}

impl Doubled {
    /// Adds a correction.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn add(&mut self, correction: &[f64]) {
        assert_eq!(self.value.len(), correction.len());
        let parts = self.value.iter_mut().zip(&mut self.remainder);
        for ((value, remainder), c) in parts.zip(correction) {
            let (sum, error) = two_sum(*value, *c);
            (*value, *remainder) = two_sum(sum, error + *remainder);
        }
    }
}

/// a + b rounded, and what rounding took (D. E. Knuth).
#[inline(always)]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let virtual_part = sum - a;
    (sum, (a - (sum - virtual_part)) + (b - virtual_part))
}

impl CscMatrix {
    /// b − M x for a symmetric M, with sums and products in twice the working precision, rounded once at the end (T. Ogita, S. M. Rump,
    /// S. Oishi, SIAM J. Sci. Comput. 26 (2005) 1955, algorithm Dot2); rows in parallel.
    ///
    /// # Panics
    /// If `x` or `b` has another length than M has rows.
    pub(crate) fn symmetric_residual(&self, x: &Doubled, b: &[f64]) -> Vec<f64> {
        let mut residual = self.transposed_excess(x, b);
        residual.iter_mut().for_each(|r| *r = -*r);
        residual
    }

    /// Mᵀx − b in the same way.
    ///
    /// # Panics
    /// If `x` or `b` has another length than M has rows or columns.
    pub(crate) fn transposed_excess(&self, x: &Doubled, b: &[f64]) -> Vec<f64> {
        assert_eq!((x.value.len(), b.len()), (self.rows, self.cols));
        let mut excess: Vec<f64> = b.iter().map(|b| -b).collect();
        let columns = 1024;
        let chunks = excess.par_chunks_mut(columns).enumerate();
        chunks.for_each(|(chunk, excess)| {
            vectorised(
                #[inline(always)]
                || {
                    for (j, excess) in (chunk * columns..).zip(excess) {
                        let (mut sum, mut error) = (*excess, 0.0);
                        for k in self.indptr[j]..self.indptr[j + 1] {
                            let (a, row) = (self.data[k], self.indices[k]);
                            let product = a * x.value[row];
                            let product_error = a.mul_add(x.value[row], -product);
                            let (next, sum_error) = two_sum(sum, product);
                            sum = next;
                            error += product_error + sum_error;
                            error += a * x.remainder[row];
                        }
                        *excess = sum + error;
                    }
                },
            );
        });
        excess
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one_by_one(entry: f64) -> CscMatrix {
        CscMatrix {
            rows: 1,
            cols: 1,
            indptr: vec![0, 1],
            indices: vec![0],
            data: vec![entry],
        }
    }

    #[test]
    fn what_cancels_is_kept() {
        // (1 + 2⁻³⁰)² − (1 + 2⁻²⁹) = 2⁻⁶⁰, far below the rounding 2⁻⁵² of the product.
        let x = 1.0 + 2_f64.powi(-30);
        let matrix = one_by_one(x);
        let b = [1.0 + 2_f64.powi(-29)];
        let doubled = Doubled::from(vec![x]);
        assert_eq!(matrix.symmetric_residual(&doubled, &b), [-2_f64.powi(-60)]);
        assert_eq!(matrix.transposed_excess(&doubled, &b), [2_f64.powi(-60)]);
    }

    #[test]
    fn remainders_survive_addition() {
        let mut x = Doubled::from(vec![1.0]);
        x.add(&[2_f64.powi(-70)]);
        x.add(&[-1.0]);
        assert_eq!(x.value, [2_f64.powi(-70)]);
        let matrix = one_by_one(3.0);
        let mut y = Doubled::from(vec![1.0]);
        y.add(&[2_f64.powi(-70)]);
        assert_eq!(
            matrix.symmetric_residual(&y, &[3.0]),
            [-3.0 * 2_f64.powi(-70)]
        );
    }
}

//! Sums and residuals in twice the working precision.

use rayon::prelude::*;

use super::CscMatrix;
use super::vector::vectorised;

/// Columns of a matrix that one thread treats.
const CHUNK: usize = 1024;

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

/// A sum with its error (T. Ogita, S. M. Rump, S. Oishi, SIAM J. Sci. Comput. 26 (2005) 1955,
/// algorithm Dot2).
#[derive(Debug, Clone, Copy)]
struct Accumulator {
    sum: f64,
    error: f64,
}

impl Accumulator {
    fn new(start: f64) -> Self {
        Self {
            sum: start,
            error: 0.0,
        }
    }

    #[inline(always)]
    fn add_product(&mut self, a: f64, b: f64) {
        let product = a * b;
        let product_error = a.mul_add(b, -product);
        let (sum, sum_error) = two_sum(self.sum, product);
        self.sum = sum;
        self.error += product_error + sum_error;
    }

    fn rounded(self) -> f64 {
        self.sum + self.error
    }
}

impl CscMatrix {
    /// b − M x for a symmetric M, with sums and products in twice the working precision, rounded once at the end; rows in
    /// parallel.
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
        let chunks = excess.par_chunks_mut(CHUNK).enumerate();
        chunks.for_each(|(chunk, excess)| {
            vectorised(
                #[inline(always)]
                || {
                    for (j, excess) in (chunk * CHUNK..).zip(excess) {
                        let mut sum = Accumulator::new(*excess);
                        for k in self.indptr[j]..self.indptr[j + 1] {
                            let row = self.indices[k];
                            sum.add_product(self.data[k], x.value[row]);
                            sum.error += self.data[k] * x.remainder[row];
                        }
                        *excess = sum.rounded();
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

    #[test]
    fn what_cancels_is_kept() {
        // (1 + 2⁻³⁰)² − (1 + 2⁻²⁹) = 2⁻⁶⁰, far below the rounding 2⁻⁵² of the product.
        let x = 1.0 + 2_f64.powi(-30);
        let matrix = CscMatrix::new(1, 1, vec![0, 1], vec![0], vec![x]).unwrap();
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
        let matrix = CscMatrix::new(1, 1, vec![0, 1], vec![0], vec![3.0]).unwrap();
        let mut y = Doubled::from(vec![1.0]);
        y.add(&[2_f64.powi(-70)]);
        assert_eq!(
            matrix.symmetric_residual(&y, &[3.0]),
            [-3.0 * 2_f64.powi(-70)]
        );
    }
}

//! Residuals of linear systems in twice the working precision.

use super::CscMatrix;

impl CscMatrix {
    /// b − M x with sums and products in twice the working precision, rounded once at the end
    /// (T. Ogita, S. M. Rump, S. Oishi, SIAM J. Sci. Comput. 26 (2005) 1955, algorithm Dot2).
    ///
    /// # Panics
    /// If `x` or `b` has another length than M has columns or rows.
    #[must_use]
    pub fn residual(&self, x: &[f64], b: &[f64]) -> Vec<f64> {
        assert_eq!((x.len(), b.len()), (self.cols, self.rows));
        let mut sum = b.to_vec();
        let mut error = vec![0.0; b.len()];
        for (j, &x) in x.iter().enumerate() {
            for k in self.indptr[j]..self.indptr[j + 1] {
                let (row, entry) = (self.indices[k], -self.data[k]);
                let product = entry * x;
                let product_error = entry.mul_add(x, -product);
                let old = sum[row];
                let new = old + product;
                let virtual_part = new - old;
                let sum_error = (old - (new - virtual_part)) + (product - virtual_part);
                sum[row] = new;
                error[row] += product_error + sum_error;
            }
        }
        sum.iter().zip(&error).map(|(s, e)| s + e).collect()
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
        let residual = matrix.residual(&[x], &[1.0 + 2_f64.powi(-29)]);
        assert_eq!(residual, [-2_f64.powi(-60)]);
    }
}

//! The largest eigenvalue of an operator by Lanczos' method.

use super::{add_scaled, dot, norm};

/// Steps after which the estimate is taken as it is.
const MOST_STEPS: usize = 30;

/// The Ritz value is good enough when its residual is below this share of it.
const RELATIVE_RESIDUAL: f64 = 0.01;

/// An upper estimate of the largest eigenvalue of a positive semidefinite operator on ℝⁿ: the
/// largest Ritz value plus its residual, at most a hundredth of it unless the steps run out.
///
/// Lanczos' method with full orthogonalisation (B. N. Parlett, *The Symmetric Eigenvalue Problem*,
/// SIAM 1998, chapter 13), from the same start on every machine. Returns 0 for n = 0 and for the
/// zero operator.
#[must_use]
pub(crate) fn largest_eigenvalue(n: usize, mut apply: impl FnMut(&[f64]) -> Vec<f64>) -> f64 {
    if n == 0 {
        return 0.0;
    }
    let mut basis: Vec<Vec<f64>> = vec![start_vector(n)];
    let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
    loop {
        let k = basis.len() - 1;
        let mut next = apply(&basis[k]);
        diagonal.push(dot(&next, &basis[k]));
        for v in &basis {
            let along = dot(&next, v);
            add_scaled(&mut next, -along, v);
        }
        let beta = norm(&next);
        let (ritz, last_component) = largest_ritz_pair(&diagonal, &off_diagonal);
        let residual = beta * last_component.abs();
        if residual <= RELATIVE_RESIDUAL * ritz || basis.len() == MOST_STEPS.min(n) {
            return ritz + residual;
        }
        off_diagonal.push(beta);
        basis.push(next.iter().map(|v| v / beta).collect());
    }
}

/// A unit vector with components in every direction, the same on every machine.
fn start_vector(n: usize) -> Vec<f64> {
    let raw: Vec<f64> = (0..n)
        .map(|i| 1.0 + 0.5 * (i as f64 * 0.754_877_666).fract())
        .collect();
    let length = norm(&raw);
    raw.iter().map(|v| v / length).collect()
}

/// Largest eigenvalue of the Lanczos matrix and the last component of its unit eigenvector.
pub(crate) fn largest_ritz_pair(diagonal: &[f64], off_diagonal: &[f64]) -> (f64, f64) {
    let k = diagonal.len();
    let matrix = nalgebra::DMatrix::from_fn(k, k, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => off_diagonal[i.min(j)],
        _ => 0.0,
    });
    let eigen = matrix.symmetric_eigen();
    let largest = eigen.eigenvalues.imax();
    (
        eigen.eigenvalues[largest],
        eigen.eigenvectors[(k - 1, largest)],
    )
}

#[cfg(test)]
mod tests {
    use super::largest_eigenvalue;

    #[test]
    fn the_largest_of_known_eigenvalues_is_found_from_above() {
        let eigenvalues: Vec<f64> = (1..=200).map(f64::from).collect();
        let estimate = largest_eigenvalue(200, |v| {
            v.iter().zip(&eigenvalues).map(|(v, e)| v * e).collect()
        });
        // The residual of at most 1 % is added to a Ritz value that is at most 1 % too small.
        assert!((estimate / 200.0 - 1.0).abs() < 0.02, "{estimate}");
        assert_eq!(largest_eigenvalue(3, |_| vec![0.0; 3]), 0.0);
    }
}

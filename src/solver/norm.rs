use crate::{
    dual::DualOperator,
    linalg::{add_scaled, dot, norm},
};

/// An upper estimate of ‖S‖ by Lanczos' method: the largest Ritz value plus its residual.
///
/// Stops when the residual is below a hundredth of the Ritz value, which moves the steplength
/// 1.9/‖S‖ by at most one per cent; returns 0 for S = 0.
pub fn operator_norm(operator: &mut dyn DualOperator) -> f64 {
    const MOST_STEPS: usize = 30;
    const RELATIVE_RESIDUAL: f64 = 0.01;
    let n = operator.dimension();
    let mut basis: Vec<Vec<f64>> = vec![start_vector(n)];
    let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
    loop {
        let k = basis.len() - 1;
        let mut next = operator.apply(&basis[k]);
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

/// The steplength ᾱ = 1.9/‖S‖ of projected gradient steps in Pa/m³ (KPRGP asks for ᾱ in (0, 2/‖S‖)); 1 for
/// S = 0, where any will do.
pub(super) fn projected_gradient_steplength(operator: &mut dyn DualOperator) -> f64 {
    match operator_norm(operator) {
        0.0 => 1.0,
        largest => 1.9 / largest,
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
fn largest_ritz_pair(diagonal: &[f64], off_diagonal: &[f64]) -> (f64, f64) {
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

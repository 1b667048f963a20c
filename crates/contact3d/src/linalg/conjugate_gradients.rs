//! Conjugate gradients (M. R. Hestenes, E. Stiefel, *J. Res. Nat. Bur. Standards* 49 (1952) 409), preconditioned by a factor of
//! lower precision.

use super::precision::Factor;
use super::solve::Workspace;
use super::sparse::CscMatrix;
use super::vector::{add_scaled, dot};

/// Most steps; a factor that needs more is of no use.
const MOST_STEPS: usize = 200;

/// An approximate solution and how it was reached.
#[derive(Debug, Clone)]
pub(crate) struct CgSolution {
    pub(crate) solution: Vec<f64>,
    pub(crate) steps: usize,
    /// The error that is left, relative in the energy norm.
    pub(crate) error: f64,
}

impl CgSolution {
    /// Mean factor of the error in one step.
    pub(crate) fn contraction(&self) -> f64 {
        self.error.powf(1.0 / self.steps.max(1) as f64)
    }
}

/// x with ‖x − A⁻¹b‖_A ≤ `tolerance` ‖A⁻¹b‖_A, for a symmetric A and a factor with (LLᵀ)⁻¹ ≈ A⁻¹.
///
/// The error is √(rᵀ(LLᵀ)⁻¹r), and ‖x‖_A² is the sum of the steps α rᵀ(LLᵀ)⁻¹r. Ends early where the recurrence breaks down.
pub(crate) fn conjugate_gradients(
    a: &CscMatrix,
    factor: &Factor,
    b: &[f64],
    tolerance: f64,
    work: &mut Workspace,
) -> CgSolution {
    let mut solution = vec![0.0; b.len()];
    let mut residual = b.to_vec();
    let mut preconditioned = residual.clone();
    factor.solve_in_place(&mut preconditioned, work);
    let mut direction = preconditioned.clone();
    let mut product = vec![0.0; b.len()];
    let (mut rho, mut energy) = (dot(&residual, &preconditioned), 0.0);
    let (mut steps, mut error) = (0, 1.0);
    // A load of zero, and numbers that are none, end at once.
    while rho > 0.0 && steps < MOST_STEPS {
        a.mul_transposed(&direction, &mut product);
        let curvature = dot(&direction, &product);
        if !(curvature > 0.0 && curvature.is_finite()) {
            break;
        }
        let alpha = rho / curvature;
        add_scaled(&mut solution, alpha, &direction);
        add_scaled(&mut residual, -alpha, &product);
        energy += alpha * rho;
        steps += 1;
        preconditioned.copy_from_slice(&residual);
        factor.solve_in_place(&mut preconditioned, work);
        let next = dot(&residual, &preconditioned);
        error = (next.max(0.0) / energy).sqrt();
        if error <= tolerance || error.is_nan() {
            // The error itself, to the precision of the factor.
            add_scaled(&mut solution, 1.0, &preconditioned);
            break;
        }
        let beta = next / rho;
        for (d, z) in direction.iter_mut().zip(&preconditioned) {
            *d = z + beta * *d;
        }
        rho = next;
    }
    CgSolution {
        solution,
        steps,
        error,
    }
}

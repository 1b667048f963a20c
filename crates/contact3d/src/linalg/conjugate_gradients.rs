//! Conjugate gradients (M. R. Hestenes, E. Stiefel, *J. Res. Nat. Bur. Standards* 49 (1952) 409), preconditioned by a factor of
//! lower precision.

use super::precision::Factor;
use super::solve::Workspace;
use super::sparse::CscMatrix;
use super::vector::{add_scaled, dot, norm};

/// Most steps; a factor that needs more is of no use.
const MOST_STEPS: usize = 200;

/// An approximate solution and how it was reached.
#[derive(Debug, Clone)]
pub(crate) struct CgSolution {
    pub(crate) solution: Vec<f64>,
    pub(crate) steps: usize,
    /// The error before the last residual was added, preconditioned; relative in the energy norm.
    error: f64,
}

impl CgSolution {
    /// Mean factor of the error in one step.
    pub(crate) fn contraction(&self) -> f64 {
        self.error.powf(1.0 / self.steps.max(1) as f64)
    }

    /// The error that is left, relative in the energy norm: the last residual, preconditioned, is as good as a step.
    pub(crate) fn left(&self) -> f64 {
        self.error * self.contraction()
    }
}

/// What is asked of a solution x: an error of at most a share of ‖x‖, or of at most a length.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Accuracy {
    pub(crate) share: f64,
    pub(crate) length: f64,
}

/// A⁻¹b for every b given, for a symmetric A and a factor with (LLᵀ)⁻¹ ≈ A⁻¹.
///
/// The error in the energy norm is √(rᵀ(LLᵀ)⁻¹r), and ‖x‖_A² is the sum of the steps α rᵀ(LLᵀ)⁻¹r. Ends early where the recurrence breaks down.
/// Every b has an iteration of its own; they share the reading of the factor.
pub(crate) fn conjugate_gradients(
    a: &CscMatrix,
    factor: &Factor,
    rhs: &[&[f64]],
    accuracy: Accuracy,
    work: &mut Workspace,
) -> Vec<CgSolution> {
    let mut iterations: Vec<Iteration> = rhs.iter().map(|b| Iteration::new(b)).collect();
    loop {
        let mut active: Vec<&mut Iteration> =
            iterations.iter_mut().filter(|it| !it.is_done).collect();
        match &mut active[..] {
            [] => break,
            [one] => factor.solve_in_place(&mut one.preconditioned, work),
            several => {
                let several = several.iter_mut().map(|it| &mut it.preconditioned[..]);
                factor.solve_several(&mut several.collect::<Vec<_>>());
            }
        }
        for iteration in active {
            iteration.judge(accuracy);
            if !iteration.is_done {
                iteration.step(a);
            }
        }
    }
    iterations.into_iter().map(|it| it.reached).collect()
}

/// The iteration for one right-hand side.
struct Iteration {
    reached: CgSolution,
    residual: Vec<f64>,
    preconditioned: Vec<f64>,
    direction: Vec<f64>,
    /// rᵀ(LLᵀ)⁻¹r of the step before.
    rho: f64,
    /// ‖x‖_A².
    energy: f64,
    is_done: bool,
}

impl Iteration {
    fn new(b: &[f64]) -> Self {
        Self {
            reached: CgSolution {
                solution: vec![0.0; b.len()],
                steps: 0,
                error: 1.0,
            },
            residual: b.to_vec(),
            preconditioned: b.to_vec(),
            direction: vec![0.0; b.len()],
            rho: f64::INFINITY,
            energy: 0.0,
            is_done: false,
        }
    }

    /// With the residual preconditioned: is x accurate? Otherwise the next direction.
    fn judge(&mut self, accuracy: Accuracy) {
        let rho = dot(&self.residual, &self.preconditioned);
        let reached = &mut self.reached;
        if reached.steps > 0 {
            reached.error = (rho.max(0.0) / self.energy).sqrt();
            let left = reached.left();
            let enough =
                left <= accuracy.share || left * norm(&reached.solution) <= accuracy.length;
            if enough || reached.error.is_nan() {
                add_scaled(&mut reached.solution, 1.0, &self.preconditioned);
                self.is_done = true;
            }
        }
        // A load of zero, and numbers that are none, end at once.
        let goes_on = rho > 0.0 && reached.steps < MOST_STEPS;
        self.is_done |= !goes_on;
        let beta = rho / self.rho;
        for (d, z) in self.direction.iter_mut().zip(&self.preconditioned) {
            *d = z + beta * *d;
        }
        self.rho = rho;
    }

    /// A step along the direction, and the new residual to be preconditioned.
    fn step(&mut self, a: &CscMatrix) {
        let product = &mut self.preconditioned;
        a.mul_transposed(&self.direction, product);
        let curvature = dot(&self.direction, product);
        if !(curvature > 0.0 && curvature.is_finite()) {
            self.is_done = true;
            return;
        }
        let alpha = self.rho / curvature;
        add_scaled(&mut self.reached.solution, alpha, &self.direction);
        add_scaled(&mut self.residual, -alpha, product);
        self.energy += alpha * self.rho;
        self.reached.steps += 1;
        product.copy_from_slice(&self.residual);
    }
}

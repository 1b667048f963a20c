//! Iterative solvers: preconditioned conjugate gradients, and GMRES.

use super::{
    cholesky::Factor,
    sparse::CscMatrix,
    vector::{add_combination, add_scaled, dot, norm, orthogonalise},
};

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

/// x = A⁻¹b for every b given, with an error of at most a `share` of ‖x‖ or of at most a `length`, for a symmetric A and a factor with
/// (LLᵀ)⁻¹ ≈ A⁻¹.
///
/// The error in the energy norm is √(rᵀ(LLᵀ)⁻¹r), and ‖x‖_A² is the sum of the steps α rᵀ(LLᵀ)⁻¹r. Ends early where the recurrence breaks down.
/// Every b has an iteration of its own; they share the reading of the factor.
pub(crate) fn conjugate_gradients(
    a: &CscMatrix,
    factor: &Factor,
    rhs: &[&[f64]],
    share: f64,
    length: f64,
) -> Vec<CgSolution> {
    let mut iterations: Vec<Iteration> = rhs.iter().map(|b| Iteration::new(b)).collect();
    loop {
        let mut active: Vec<&mut Iteration> =
            iterations.iter_mut().filter(|it| !it.is_done).collect();
        if active.is_empty() {
            break;
        }
        let residuals = active.iter_mut().map(|it| &mut it.preconditioned[..]);
        factor.solve_several(&mut residuals.collect::<Vec<_>>());
        for iteration in active {
            iteration.assess(share, length);
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
    fn assess(&mut self, share: f64, length: f64) {
        let rho = dot(&self.residual, &self.preconditioned);
        let reached = &mut self.reached;
        if reached.steps > 0 {
            reached.error = (rho.max(0.0) / self.energy).sqrt();
            let left = reached.left();
            let enough = left <= share || left * norm(&reached.solution) <= length;
            if enough || reached.error.is_nan() {
                add_scaled(&mut reached.solution, 1.0, &self.preconditioned);
                self.is_done = true;
            }
        }
        // A load of zero, and numbers that are none, end at once; a factor that needs more steps is of no use.
        let goes_on = rho > 0.0 && reached.steps < 200;
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

/// An approximate solution of M x = b by GMRES (Y. Saad, M. H. Schultz, SIAM J. Sci. Stat. Comput.
/// 7 (1986) 856) without restarts: stops when ‖b − M x‖ ≤ `tolerance` ‖b‖ or after `most_steps`
/// products.
pub(crate) fn gmres(
    b: &[f64],
    tolerance: f64,
    most_steps: usize,
    mut apply: impl FnMut(&[f64]) -> Vec<f64>,
) -> Vec<f64> {
    let b = std::slice::from_ref(&b);
    gmres_several(b, tolerance, most_steps, |v| vec![apply(v[0])]).remove(0)
}

/// The same for several right-hand sides side by side, of which those that are not solved yet share each call of `apply`.
pub(crate) fn gmres_several(
    rhs: &[&[f64]],
    tolerance: f64,
    most_steps: usize,
    mut apply: impl FnMut(&[&[f64]]) -> Vec<Vec<f64>>,
) -> Vec<Vec<f64>> {
    let spaces = rhs.iter().map(|b| KrylovSpace::new(b, tolerance));
    let mut spaces: Vec<KrylovSpace> = spaces.collect();
    for k in 0..most_steps {
        let going = |space: &&mut KrylovSpace| !space.is_done && k < space.size_of_system;
        let mut open: Vec<&mut KrylovSpace> = spaces.iter_mut().filter(going).collect();
        if open.is_empty() {
            break;
        }
        let last: Vec<&[f64]> = open.iter().map(|space| space.basis[k].as_slice()).collect();
        let products = apply(&last);
        for (space, product) in open.iter_mut().zip(products) {
            space.extend(product);
        }
    }
    spaces.into_iter().map(KrylovSpace::solution).collect()
}

/// The Krylov space of one right-hand side.
struct KrylovSpace {
    size_of_system: usize,
    /// The residual that is small enough.
    enough: f64,
    basis: Vec<Vec<f64>>,
    /// Columns of the triangular factor of the Hessenberg matrix, the rotations that made it, and the right-hand side turned by them.
    triangle: Vec<Vec<f64>>,
    rotations: Vec<(f64, f64)>,
    turned: Vec<f64>,
    is_done: bool,
}

impl KrylovSpace {
    fn new(b: &[f64], tolerance: f64) -> Self {
        let size = norm(b);
        let is_done = !(size > 0.0 && size.is_finite());
        let first = if is_done {
            Vec::new()
        } else {
            vec![b.iter().map(|v| v / size).collect()]
        };
        Self {
            size_of_system: b.len(),
            enough: tolerance * size,
            basis: first,
            triangle: Vec::new(),
            rotations: Vec::new(),
            turned: vec![size],
            is_done,
        }
    }

    /// Takes M times the last vector of the basis in.
    fn extend(&mut self, mut next: Vec<f64>) {
        let k = self.triangle.len();
        let mut column = orthogonalise(&mut next, &self.basis, 2);
        let length = norm(&next);
        column.push(length);
        for (i, (c, s)) in self.rotations.iter().enumerate() {
            let (upper, lower) = (column[i], column[i + 1]);
            column[i] = c * upper + s * lower;
            column[i + 1] = c * lower - s * upper;
        }
        let diagonal = column[k].hypot(column[k + 1]);
        if !(diagonal > 0.0 && diagonal.is_finite()) {
            self.is_done = true;
            return;
        }
        let (c, s) = (column[k] / diagonal, column[k + 1] / diagonal);
        column.truncate(k + 1);
        column[k] = diagonal;
        self.triangle.push(column);
        self.rotations.push((c, s));
        self.turned.push(-s * self.turned[k]);
        self.turned[k] *= c;
        self.is_done = self.turned[k + 1].abs() <= self.enough || length == 0.0;
        if !self.is_done {
            self.basis.push(next.iter().map(|v| v / length).collect());
        }
    }

    fn solution(self) -> Vec<f64> {
        let mut solution = vec![0.0; self.size_of_system];
        let mut weights = self.turned[..self.triangle.len()].to_vec();
        for (k, column) in self.triangle.iter().enumerate().rev() {
            weights[k] /= column[k];
            let weight = weights[k];
            for (i, upper) in weights[..k].iter_mut().enumerate() {
                *upper -= column[i] * weight;
            }
        }
        add_combination(&mut solution, &weights, &self.basis);
        solution
    }
}

#[cfg(test)]
mod tests {
    use super::gmres;

    #[test]
    fn an_unsymmetric_system_is_solved_in_as_many_steps_as_it_has_unknowns() {
        let matrix = [[2.0, 1.0, 0.0], [-3.0, 4.0, 1.0], [0.0, 5.0, -1.0]];
        let apply = |x: &[f64]| -> Vec<f64> {
            let rows = matrix.iter();
            rows.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
                .collect()
        };
        let expected = [1.0, -2.0, 3.0];
        let found = gmres(&apply(&expected), 1e-14, 3, apply);
        for (found, expected) in found.iter().zip(expected) {
            // Some roundings of a well-conditioned system.
            assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        }
        assert_eq!(gmres(&[0.0; 3], 1e-14, 3, apply), [0.0; 3]);
    }
}

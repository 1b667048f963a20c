//! The interior point method.

use nalgebra::{DMatrix, DVector};

use super::{
    cone::{IDENTITY, Point, Scaling, inner, largest_step, product, shifted, smaller_eigenvalue},
    program::{Block, ConvexProgram},
};
use crate::{
    linalg::{DenseCholesky, add_scaled, dot},
    solver::tolerances::LOOP_MAX_STEPS,
};

/// Share of the largest step before the boundary: a step to the end leaves a hundredth of what it removes.
const BOUNDARY_FRACTION: f64 = 0.99;

/// Every s ∘ z keeps this share of their mean, and what is violated falls at least as μ does, but for this factor: the neighbourhood in
/// which convergence is proven, for any values; wide ones allow long steps.
const CENTRALITY: f64 = 1e-3;
const INFEASIBILITY: f64 = 1e6;

/// Least decrease of μ, as a share of the step, as in the proof: any that is positive and small.
const INTERIOR_DECREASE: f64 = 0.01;

/// Steps along the corrected direction that are shorter, so that ten would be needed for what one can do, give way to the centred one, of
/// which convergence is proven.
const SHORT_INTERIOR_STEP: f64 = 0.1;

/// What is violated may be this share of the solution when the active set is read off: a small part of the stresses that differ. Newton's
/// method removes it.
const BLOCK_VIOLATION: f64 = 1e-3;

/// What a Schur complement of unit diagonal resists less is a motion that contact does not hold: it has some hundreds of roundings.
const NULL_MOTION_PIVOT: f64 = 1e-13;

/// The primal–dual method of path following with Mehrotra's corrector on the cones of pressures and ellipses, one Cholesky
/// factor a step.
///
/// With s(x) the points of the cones, exact in every step, and their duals z, it follows A x − G α − b = z, Gᵀx + D α = q,
/// s ∘ z = μ to μ = 0, in the scaling of Nesterov and Todd. The corrected direction (S. Mehrotra, *SIAM J. Optim.* 2 (1992)
/// 575) has no proof of convergence; where it does not get on within the neighbourhood, the centred direction does: for linear
/// objectives over such cones, from a start as large as the solution, in a number of steps that is polynomial in that of the panes and
/// does not depend on conditioning (B. Rangarajan, *SIAM J. Optim.* 16 (2006) 1211); ours is convex and quadratic, whose A only adds
/// ds·dz ≥ 0.
pub(in crate::solver) struct InteriorPoint<'a> {
    program: &'a ConvexProgram,
    /// x.
    x: Vec<f64>,
    /// α.
    motion: Vec<f64>,
    /// z of each block.
    dual: Vec<Point>,
    /// The mean of s·z at the start.
    first_mu: f64,
    /// What is left of the violation at the start.
    violation_share: f64,
    /// Steps so far.
    pub(super) steps: usize,
}

/// A Newton direction.
struct InteriorStep {
    x: Vec<f64>,
    motion: Vec<f64>,
    /// ds and dz of each block.
    blocks: Vec<(Point, Point)>,
}

/// The linear system of one step.
struct StepSystem {
    scalings: Vec<Scaling>,
    /// Δ M Δ of unit diagonal for M = A + W⁻².
    factor: DenseCholesky,
    /// Δ.
    unit: Vec<f64>,
    /// M⁻¹G.
    response: Vec<Vec<f64>>,
    /// GᵀM⁻¹G + D.
    complement: DMatrix<f64>,
}

impl<'a> InteriorPoint<'a> {
    /// From equal pressures at least as large as the solution's largest, and no friction; `None` where nothing presses, pulls or is pulled, so that 0
    /// is the solution.
    pub(in crate::solver) fn new(program: &'a ConvexProgram) -> Option<Self> {
        let pressure = program.pressure_bound;
        if pressure == 0.0 || !pressure.is_finite() || program.is_solved_by_zero() {
            return None;
        }
        let x = program.of_blocks(|block| match block {
            Block::Pressure(_) => [pressure, 0.0, 0.0],
            Block::Pair { .. } => [0.0; 3],
        });
        // Inside the dual cones.
        let starts = program.blocks.iter();
        let starts = starts.map(|it| IDENTITY.map(|v| v * pressure * it.unit()));
        let mut method = Self {
            program,
            x,
            motion: vec![0.0; program.resultant.len()],
            dual: starts.collect(),
            first_mu: 0.0,
            violation_share: 1.0,
            steps: 0,
        };
        method.first_mu = mean_product(method.pairs());
        Some(method)
    }

    /// Steps until the natural map of every block is at most `indecision`, as a share of the largest stress;
    /// `false` where rounding, or the cap on steps, ends it before.
    pub(in crate::solver) fn run(&mut self, indecision: f64) -> bool {
        loop {
            let [undecided, violated] = self.open();
            let is_decided = undecided <= indecision && violated <= BLOCK_VIOLATION;
            // A larger violation lags behind the active set, and one more step, which leaves a hundredth of it, is worth its cost.
            if is_decided && violated <= 0.01 * BLOCK_VIOLATION {
                return true;
            }
            let moves = self.steps < LOOP_MAX_STEPS && self.advance().is_some();
            if is_decided || !moves {
                return is_decided;
            }
        }
    }

    /// λ and α.
    pub(in crate::solver) fn unknowns(&self, n_multipliers: usize) -> Vec<f64> {
        self.program.unknowns(&self.x, &self.motion, n_multipliers)
    }

    /// How far a block is from being decided, and what is violated, as shares of the largest stress.
    fn open(&self) -> [f64; 2] {
        let blocks = &self.program.blocks;
        let largest = |size: &dyn Fn(&Block) -> f64| blocks.iter().map(size).fold(0.0, f64::max);
        let violation = self.violation();
        let points = blocks.iter().zip(&self.dual);
        let indecision = points.map(|(it, z)| it.indecision(it.point(&self.x), *z));
        let violated = largest(&|block| block.size_of_gradient(&violation));
        let size = largest(&|block| block.size(&self.x));
        [indecision.fold(0.0, f64::max), violated].map(|open| open / size)
    }

    /// A x − G α − b − z.
    fn violation(&self) -> Vec<f64> {
        let mut violation = self.program.gradient(&self.x, &self.motion);
        for (block, z) in self.program.blocks.iter().zip(&self.dual) {
            block.add_to(&mut violation, z.map(|z| -z));
        }
        violation
    }

    fn pairs(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        let blocks = self.program.blocks.iter().zip(&self.dual);
        blocks.map(|(block, z)| (block.point(&self.x), *z))
    }

    fn shifted_pairs<'s>(
        &'s self,
        direction: &'s InteriorStep,
        length: f64,
    ) -> impl Iterator<Item = (Point, Point)> + 's {
        let pairs = self.pairs().zip(&direction.blocks);
        pairs.map(move |((s, z), (ds, dz))| (shifted(s, length, *ds), shifted(z, length, *dz)))
    }

    /// One step; `None` where rounding forbids it.
    fn advance(&mut self) -> Option<()> {
        let mu = mean_product(self.pairs());
        let system = StepSystem::new(self)?;
        let violation = self.violation();
        let imbalance = self.program.imbalance(&self.x, &self.motion);
        let towards = |target: f64, before: Option<&InteriorStep>| {
            let blocks = system.scalings.iter().enumerate();
            let wanted = blocks.map(|(at, scaling)| {
                let mut wanted = product(scaling.point, scaling.point).map(|v| -v);
                wanted[0] += target;
                if let Some(before) = before {
                    let (ds, dz) = before.blocks[at];
                    let second = product(scaling.apply_inverse(ds), scaling.apply(dz));
                    wanted = shifted(wanted, -1.0, second);
                }
                wanted
            });
            let wanted: Vec<Point> = wanted.collect();
            system.direction(self.program, &violation, &imbalance, &wanted)
        };
        let predictor = towards(0.0, None);
        let most = self.longest(&predictor).min(1.0);
        let centring = (mean_product(self.shifted_pairs(&predictor, most)) / mu).clamp(0.0, 1.0);
        let mut direction = towards(centring.powi(3) * mu, Some(&predictor));
        let mut step = self.admissible(&direction, mu);
        if step < SHORT_INTERIOR_STEP {
            // Half way: the centre of half of the present μ.
            let centred = towards(0.5 * mu, None);
            let longer = self.admissible(&centred, mu);
            if longer > step {
                (direction, step) = (centred, longer);
            }
        }
        if step == 0.0 {
            return None;
        }
        add_scaled(&mut self.x, step, &direction.x);
        add_scaled(&mut self.motion, step, &direction.motion);
        for (z, (_, dz)) in self.dual.iter_mut().zip(&direction.blocks) {
            *z = shifted(*z, step, *dz);
        }
        self.violation_share *= 1.0 - step;
        self.steps += 1;
        Some(())
    }

    /// The largest step before a block leaves its cones.
    fn longest(&self, direction: &InteriorStep) -> f64 {
        let pairs = self.pairs().zip(&direction.blocks);
        let steps = pairs.map(|((s, z), (ds, dz))| largest_step(s, *ds).min(largest_step(z, *dz)));
        steps.fold(f64::INFINITY, f64::min)
    }

    /// A step within the neighbourhood along which μ falls; 0 where rounding leaves none.
    fn admissible(&self, direction: &InteriorStep, mu: f64) -> f64 {
        let mut step = (BOUNDARY_FRACTION * self.longest(direction)).min(1.0);
        // Shorter steps move x by rounding alone.
        while step > 1e-10 {
            let next = mean_product(self.shifted_pairs(direction, step));
            let mut pairs = self.shifted_pairs(direction, step);
            let feasible =
                self.violation_share * (1.0 - step) <= INFEASIBILITY * next / self.first_mu;
            if next <= (1.0 - INTERIOR_DECREASE * step) * mu
                && feasible
                && pairs.all(|(s, z)| smaller_eigenvalue(s, z) >= CENTRALITY * next)
            {
                return step;
            }
            // Some seven tries for a digit.
            step *= 0.7;
        }
        0.0
    }
}

/// The mean of s·z.
fn mean_product(pairs: impl Iterator<Item = (Point, Point)>) -> f64 {
    let products: Vec<f64> = pairs.map(|(s, z)| inner(s, z)).collect();
    products.iter().sum::<f64>() / products.len() as f64
}

impl StepSystem {
    fn new(method: &InteriorPoint<'_>) -> Option<Self> {
        let program = method.program;
        let scalings: Vec<Scaling> = method.pairs().map(|(s, z)| Scaling::new(s, z)).collect();
        let mut matrix = program.matrix.clone();
        for (block, scaling) in program.blocks.iter().zip(&scalings) {
            for (i, k) in block.components() {
                for (j, l) in block.components() {
                    matrix[(i, j)] += scaling.inverse_square(k, l);
                }
            }
        }
        let n = matrix.nrows();
        let unit: Vec<f64> = (0..n).map(|i| matrix[(i, i)].sqrt().recip()).collect();
        for j in 0..n {
            for i in 0..n {
                matrix[(i, j)] *= unit[i] * unit[j];
            }
        }
        let mut system = Self {
            scalings,
            factor: DenseCholesky::shifted(&matrix)?,
            unit,
            response: Vec::new(),
            complement: DMatrix::zeros(0, 0),
        };
        system.response = program.motions.iter().map(|g| system.solve(g)).collect();
        let n = program.motions.len();
        system.complement = DMatrix::from_fn(n, n, |p, q| {
            let support = if p == q { program.support[p] } else { 0.0 };
            dot(&program.motions[p], &system.response[q]) + support
        });
        Some(system)
    }

    /// M⁻¹ v.
    fn solve(&self, v: &[f64]) -> Vec<f64> {
        let mut x: Vec<f64> = v.iter().zip(&self.unit).map(|(v, d)| v * d).collect();
        self.factor.solve(&mut x);
        x.iter_mut().zip(&self.unit).for_each(|(x, d)| *x *= d);
        x
    }

    /// The direction that removes what is violated and changes each λ ∘ λ by `wanted`, to first order.
    fn direction(
        &self,
        program: &ConvexProgram,
        violation: &[f64],
        imbalance: &[f64],
        wanted: &[Point],
    ) -> InteriorStep {
        let blocks = self.scalings.iter().zip(wanted);
        let free: Vec<Point> = blocks
            .map(|(scaling, wanted)| scaling.unscaled_quotient(*wanted))
            .collect();
        let mut rhs: Vec<f64> = violation.iter().map(|v| -v).collect();
        for (block, free) in program.blocks.iter().zip(&free) {
            block.add_to(&mut rhs, *free);
        }
        let mut x = self.solve(&rhs);
        let missing = program.motions.iter().zip(imbalance);
        let missing: Vec<f64> = missing.map(|(g, e)| e - dot(g, &x)).collect();
        let motion = self.motion(&missing);
        for (response, by) in self.response.iter().zip(&motion) {
            add_scaled(&mut x, *by, response);
        }
        let blocks = program.blocks.iter().zip(&self.scalings).zip(free);
        let blocks = blocks.map(|((block, scaling), free)| {
            let ds = block.part(&x);
            let back = scaling.apply_inverse(scaling.apply_inverse(ds));
            (ds, shifted(free, -1.0, back))
        });
        InteriorStep {
            blocks: blocks.collect(),
            motion,
            x,
        }
    }

    /// The motions of a resultant, as far as something resists them.
    fn motion(&self, resultant: &[f64]) -> Vec<f64> {
        let n = resultant.len();
        if n == 0 {
            return Vec::new();
        }
        let scale = |p: usize| match self.complement[(p, p)] {
            d if d > 0.0 => d.sqrt().recip(),
            _ => 0.0,
        };
        let scaled = DMatrix::from_fn(n, n, |p, q| scale(p) * self.complement[(p, q)] * scale(q));
        let rhs = DVector::from_fn(n, |p, _| scale(p) * resultant[p]);
        let motion = scaled.svd(true, true).solve(&rhs, NULL_MOTION_PIVOT);
        match motion {
            Ok(motion) => (0..n).map(|p| scale(p) * motion[p]).collect(),
            Err(_) => vec![0.0; n],
        }
    }
}

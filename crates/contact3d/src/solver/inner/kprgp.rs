//! KPRGP, the paper's inner solver.

use crate::{
    dual::DualOperator,
    linalg::{add_scaled, dot, norm},
    solver::{FeasibleSet, solution::StepCounts},
};

/// KPRGP: minimises ½ λᵀSλ − λᵀh over bounds and ellipses (Kučera, SIAM J. Optim. 19 (2008) 846).
#[derive(Debug, Clone, Copy)]
pub struct Kprgp {
    /// Steplength ᾱ ∈ (0, 2/‖S‖) of projected gradient steps, in Pa/m³.
    pub steplength: f64,
    /// Proportioning constant Γ.
    pub gamma: f64,
    /// Give up after this many applications of S.
    pub max_applications: usize,
}

/// What one inner solve did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InnerOutcome {
    /// Whether ‖g̃‖ reached the tolerance.
    pub converged: bool,
    /// Final norm of the reduced gradient g̃ in m³.
    pub reduced_gradient: f64,
    /// Steps of each kind.
    pub steps: StepCounts,
}

/// The reduced gradient g̃ ([`FeasibleSet::projected_step`]) split at the active set.
struct Gradients {
    free: Vec<bool>,
    /// r on free blocks, 0 elsewhere.
    free_gradient: Vec<f64>,
    /// ‖g̃‖.
    reduced_norm: f64,
    /// ‖β‖², the active part of g̃.
    active_square: f64,
    /// g̃_free · r_free.
    free_product: f64,
}

impl Kprgp {
    /// Improves an admissible `multiplier` until ‖g̃‖ ≤ `tolerance` (m³).
    pub fn minimise(
        &self,
        operator: &mut dyn DualOperator,
        set: &FeasibleSet,
        multiplier: &mut [f64],
        tolerance: f64,
    ) -> InnerOutcome {
        let first_application = operator.applications();
        let mut steps = StepCounts::default();
        let mut r = operator.gradient(multiplier);
        let mut split = self.split(set, multiplier, &r);
        let mut p = split.free_gradient.clone();
        loop {
            let converged = split.reduced_norm <= tolerance;
            let exhausted = operator.applications() - first_application >= self.max_applications;
            if converged || exhausted || !split.reduced_norm.is_finite() {
                return InnerOutcome {
                    converged,
                    reduced_gradient: split.reduced_norm,
                    steps,
                };
            }
            if split.active_square <= self.gamma * self.gamma * split.free_product {
                let s_p = operator.apply(&p);
                let curvature = dot(&p, &s_p);
                let cg_step = dot(&r, &p) / curvature;
                let feasible_step = set.largest_step(multiplier, &p);
                if cg_step <= feasible_step {
                    steps.conjugate_gradient += 1;
                    add_scaled(multiplier, -cg_step, &p);
                    add_scaled(&mut r, -cg_step, &s_p);
                    let next = self.split(set, multiplier, &r);
                    if next.free == split.free {
                        let conjugation = dot(&next.free_gradient, &s_p) / curvature;
                        for (p, gradient) in p.iter_mut().zip(&next.free_gradient) {
                            *p = gradient - conjugation * *p;
                        }
                    } else {
                        p.clone_from(&next.free_gradient);
                    }
                    split = next;
                    continue;
                }
                steps.expansion += 1;
                add_scaled(multiplier, -feasible_step, &p);
                add_scaled(&mut r, -feasible_step, &s_p);
                set.project(multiplier);
                let boundary = self.split(set, multiplier, &r);
                add_scaled(multiplier, -self.steplength, &boundary.free_gradient);
            } else {
                steps.proportioning += 1;
                add_scaled(multiplier, -self.steplength, &r);
            }
            set.project(multiplier);
            r = operator.gradient(multiplier);
            split = self.split(set, multiplier, &r);
            p.clone_from(&split.free_gradient);
        }
    }

    fn split(&self, set: &FeasibleSet, multiplier: &[f64], r: &[f64]) -> Gradients {
        let mut free = vec![false; r.len()];
        set.mark_free(multiplier, &mut free);
        let mut reduced = set.projected_step(multiplier, r, |_| self.steplength);
        reduced.iter_mut().for_each(|g| *g /= self.steplength);
        let free_gradient: Vec<f64> = r
            .iter()
            .zip(&free)
            .map(|(r, free)| if *free { *r } else { 0.0 })
            .collect();
        let active = reduced.iter().zip(&free).filter(|(_, free)| !**free);
        Gradients {
            active_square: active.map(|(g, _)| g * g).sum(),
            free_product: dot(&reduced, &free_gradient),
            reduced_norm: norm(&reduced),
            free,
            free_gradient,
        }
    }
}

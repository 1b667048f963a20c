//! Successive approximations (HKL Algorithm 4.1) and the mapping Ψ that they iterate.

mod mapping;

pub use mapping::{MappingValue, evaluate as evaluate_mapping, evaluate_at as evaluate_mapping_at};

use std::time::Instant;

pub(super) use mapping::relative_change;
use mapping::{CycleDetector, Stall};

use super::{
    ContactBody, Inner, Kprgp, OuterState, OuterStep, PaneLaws, Progress, Solution, SolvedBy,
    Start, Status,
    inner::{InnerSummary, projected_gradient_steplength},
};
use crate::{
    contact::{CoulombLaw, FrictionField},
    dual::BodyOperator,
    scene::{PrecisionControl, SolveSettings},
};

/// The inner tolerances of HKL Remark 4.1.
///
/// Two additions to the paper: control (b) never asks for more than r_tol · ε, and the outer loop
/// ends only when the inner residual has come down to that as well. Without them an inner problem
/// whose warm start already meets a loose tolerance takes no step, and the change of zero would
/// pass for convergence.
struct InnerPrecision<'a> {
    settings: &'a SolveSettings,
    tolerance: f64,
}

impl<'a> InnerPrecision<'a> {
    fn new(settings: &'a SolveSettings) -> Self {
        Self {
            settings,
            tolerance: settings.r_tol / settings.c_fact,
        }
    }

    /// The inner accuracy r_tol · ε that an answer of accuracy ε needs.
    fn final_tolerance(&self) -> f64 {
        self.settings.r_tol * self.settings.epsilon()
    }

    /// ε_λ⁽ᵏ⁾ from err⁽ᵏ⁻¹⁾.
    fn next(&mut self, last_change: f64) -> f64 {
        let s = self.settings;
        self.tolerance = match s.precision {
            PrecisionControl::Fixed => self.final_tolerance(),
            PrecisionControl::Adaptive => (s.r_tol * last_change)
                .min(s.c_fact * self.tolerance)
                .max(self.final_tolerance()),
        };
        self.tolerance
    }
}

/// The method of successive approximations (HKL Algorithm 4.1) with a chosen inner solver.
///
/// `observe` sees every outer step, and the state after every step but the last. An operator that knows
/// the contact face's displacement spares the solve over the body in all steps but the last.
#[allow(
    clippy::too_many_arguments,
    reason = "the method, the problem, its settings and its start"
)]
pub fn successive_approximations(
    inner: Inner<'_>,
    operator: &mut BodyOperator<'_, '_>,
    body: &ContactBody<'_>,
    laws: &PaneLaws,
    law: &CoulombLaw,
    settings: &SolveSettings,
    start: Start<'_>,
    observe: &mut dyn FnMut(Progress<'_>),
) -> Solution {
    let mut started = Instant::now();
    let mut actions_before = operator.as_dual().applications();
    let kprgp = Kprgp {
        steplength: match start.checkpoint {
            Some(state) => state.steplength,
            None => projected_gradient_steplength(operator.as_dual()),
        },
        gamma: settings.gamma,
        max_applications: settings.max_inner_actions,
    };
    let mut precision = InnerPrecision::new(settings);
    let mut change = 1.0;
    let follows_slip = law.depends_on_slip();
    let mut state = laws.unpressed(law, &[]);
    let mut solution = Solution {
        status: Status::MaxOuterSteps,
        solved_by: SolvedBy::FixedPoint,
        steplength: kprgp.steplength,
        multiplier: vec![0.0; laws.layout.n_multipliers()],
        accuracy: 1.0,
        ..Solution::default()
    };
    let mut cycle = CycleDetector::default();
    let mut stall = Stall::default();
    // The rounding of S λ, below which no change says anything.
    let attainable = laws.layout.n_multipliers() as f64 * f64::EPSILON;
    let balanced = match operator {
        BodyOperator::Held(_) => None,
        BodyOperator::Floating(operator) => Some(operator.balanced_start()),
    };
    let first = start.multiplier.or(balanced.as_deref());
    let mut moved = first.is_some() || start.checkpoint.is_some();
    if let Some(state) = start.checkpoint {
        solution.resume(state);
        change = solution.accuracy;
        precision.tolerance = state.tolerance;
        laws.restore_counters(state.law_evaluations, state.projections);
    } else if let Some(multiplier) = first {
        solution.multiplier = multiplier.to_vec();
        if follows_slip {
            let slip = solution.slip_at(operator, body, laws);
            solution.slip = Some(slip);
        }
    }
    for k in solution.history.len()..settings.max_outer_steps {
        if moved {
            let (normal, _) = laws.layout.split(&solution.multiplier);
            state.slip_bound = law.slip_bounds(normal, |l| l);
            if let Some(slip) = &solution.slip {
                state.friction = FrictionField::new(law, &laws.average, slip);
            }
        }
        moved = true;
        let set = laws.feasible_set(Some(&state));
        let tolerance = precision.next(change);
        let mut next = solution.multiplier.clone();
        let outcome = inner.minimise(operator, &kprgp, &set, &mut next, tolerance);
        change = relative_change(&next, &solution.multiplier);
        solution.multiplier = next;
        solution.accuracy = change;
        // An inner solver that a loose tolerance let do nothing says nothing by a change of zero.
        let asked = !inner.was_idle(outcome.steps) || tolerance <= precision.final_tolerance();
        let accurate =
            outcome.at_rounding || (asked && outcome.residual <= precision.final_tolerance());
        let closed = cycle.closes(&solution.multiplier, change).is_some();
        let end = stop(
            &outcome,
            accurate,
            change,
            settings.epsilon().max(attainable),
        )
        .or(closed.then_some(Status::Cycling))
        .or(stall
            .is_at_rounding(change, outcome.at_rounding)
            .then_some(Status::RoundingLimit))
        .map(|end| match end {
            Status::Converged if settings.epsilon() < attainable => Status::RoundingLimit,
            end => end,
        });
        if end == Some(Status::RoundingLimit) {
            solution.accuracy = change.max(outcome.residual).max(attainable);
        }
        let last = end.is_some() || k + 1 == settings.max_outer_steps;
        if follows_slip {
            let slip = solution.slip_at(operator, body, laws);
            solution.slip = Some(slip);
        }
        if last && solution.displacement.is_empty() {
            solution.displacement = operator.as_primal().to_primal(&solution.multiplier);
        }
        solution.history.push(OuterStep {
            change,
            inner_tolerance: tolerance,
            inner_residual: outcome.residual,
            steps: outcome.steps,
            applications: operator.as_dual().applications() - actions_before + outcome.applications,
            seconds: started.elapsed().as_secs_f64(),
        });
        solution.applications += solution.history[k].applications;
        actions_before = operator.as_dual().applications();
        started = Instant::now();
        observe(Progress::Outer(k, &solution.history[k]));
        if let Some(status) = end {
            solution.status = status;
            break;
        }
        // A state that could go on would have to hold the rigid motions, too.
        if !last && matches!(operator, BodyOperator::Held(_)) {
            observe(Progress::Between(&solution.outer_state(laws, tolerance)));
        }
    }
    solution.coulomb = Some(state);
    solution
}

impl Solution {
    /// What the next outer step depends on.
    fn outer_state(&self, laws: &PaneLaws, tolerance: f64) -> OuterState {
        OuterState {
            multiplier: self.multiplier.clone(),
            slip: self.slip.clone(),
            tolerance,
            steplength: self.steplength,
            history: self.history.clone(),
            law_evaluations: laws.law_evaluations(),
            projections: laws.projections(),
        }
    }

    /// Takes up the steps that led to a state.
    fn resume(&mut self, state: &OuterState) {
        self.multiplier.clone_from(&state.multiplier);
        self.slip.clone_from(&state.slip);
        self.history.clone_from(&state.history);
        self.applications = self.history.iter().map(|step| step.applications).sum();
        self.accuracy = self.history.last().map_or(1.0, |step| step.change);
    }

    /// φ of the multiplier; keeps u where φ comes from it.
    fn slip_at(
        &mut self,
        operator: &mut BodyOperator<'_, '_>,
        body: &ContactBody<'_>,
        laws: &PaneLaws,
    ) -> Vec<[f64; 2]> {
        let operator = operator.as_primal();
        if let Some(displacement) = operator.tangential_displacement(&self.multiplier) {
            return laws.slip.slip(&displacement);
        }
        self.displacement = operator.to_primal(&self.multiplier);
        laws.slip.slip(&body.tangential(&self.displacement))
    }
}

fn stop(outcome: &InnerSummary, accurate: bool, change: f64, epsilon: f64) -> Option<Status> {
    if !change.is_finite() || !outcome.residual.is_finite() {
        Some(Status::NumericalError)
    } else if outcome.failure.is_some() {
        outcome.failure
    } else if accurate && change <= epsilon {
        Some(Status::Converged)
    } else {
        None
    }
}

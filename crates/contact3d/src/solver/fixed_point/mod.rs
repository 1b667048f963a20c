//! Successive approximations (HKL Algorithm 4.1) and the mapping Ψ that they iterate.

mod mapping;

pub use mapping::{MappingValue, evaluate as evaluate_mapping};

use std::time::Instant;

pub(super) use mapping::relative_change;
use mapping::{CycleDetector, Stall};

use super::{
    ContactBody, CoulombState, FrictionState, Inner, Kprgp, MethodResult, OuterState, OuterStep,
    PaneLaws, Progress, Solution, SolvedBy, Start, StopReason, Trace,
    inner::{InnerSummary, projected_gradient_steplength},
    tolerances::rounding_of_products,
};
use crate::{
    contact::{CoulombLaw, FrictionField, slips},
    dual::BodyOperator,
    scene::{PrecisionControl, SolveSettings},
};

/// The method of successive approximations (HKL Algorithm 4.1): the problem, and what solves the inner ones.
#[derive(Debug, Clone, Copy)]
pub struct SuccessiveApproximations<'a> {
    /// The solver of the problems with a frozen admissible set.
    pub inner: Inner<'a>,
    /// The body, which turns multipliers into slips.
    pub body: &'a ContactBody<'a>,
    /// The laws of the panes.
    pub laws: &'a PaneLaws,
    /// Coulomb's law among them.
    pub law: &'a CoulombLaw,
    /// ε, the inner tolerances and the largest number of steps.
    pub settings: &'a SolveSettings,
}

impl SuccessiveApproximations<'_> {
    /// Solves the problem on an operator from a start.
    ///
    /// `observe` sees every outer step, and the state after every step but the last. An operator that knows
    /// the contact face's displacement spares the solve over the body in all steps but the last.
    pub fn solve(
        &self,
        operator: &mut BodyOperator<'_, '_>,
        start: Start<'_>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> MethodResult {
        let mut outer = OuterLoop::begin(self, operator, start);
        let most = self.settings.max_outer_steps;
        let mut stop = StopReason::MaxOuterSteps;
        for k in outer.trace.history.len()..most {
            outer.update_law();
            let summary = outer.minimise();
            let end = outer.end_after(&summary);
            let last = end.is_some() || k + 1 == most;
            outer.update_slip();
            outer.record(&summary, last);
            observe(Progress::Outer(k, &outer.trace.history[k]));
            if let Some(end) = end {
                stop = end;
                break;
            }
            // A state that could go on would have to hold the rigid motions, too.
            if !last && matches!(outer.operator, BodyOperator::Constrained(_)) {
                let state = outer.state();
                observe(Progress::Between(&state));
            }
        }
        MethodResult {
            stop,
            measure: outer.measure,
            solution: Solution {
                friction: Some(FrictionState {
                    slip: outer.slip,
                    coulomb: outer.frozen,
                    ..FrictionState::default()
                }),
                ..Solution::unassessed(outer.multiplier, outer.displacement, outer.trace)
            },
        }
    }
}

/// The outer loop between two steps.
struct OuterLoop<'s, 'o, 'b> {
    problem: &'s SuccessiveApproximations<'s>,
    operator: &'s mut BodyOperator<'o, 'b>,
    kprgp: Kprgp,
    /// ε_λ⁽ᵏ⁾ of the last inner problem.
    tolerance: f64,
    /// err⁽ᵏ⁾ = ‖λ⁽ᵏ⁺¹⁾ − λ⁽ᵏ⁾‖ / ‖λ⁽ᵏ⁺¹⁾‖ of the last step.
    change: f64,
    /// The same, or at rounding what that allows.
    measure: f64,
    /// g and 𝓕 of the inner problem.
    frozen: CoulombState,
    /// Whether the multipliers are not those that `frozen` belongs to.
    is_law_outdated: bool,
    cycle: CycleDetector,
    stall: Stall,
    started: Instant,
    applications_before: usize,
    /// φ of the multiplier where the coefficients follow it.
    slip: Option<Vec<[f64; 2]>>,
    multiplier: Vec<f64>,
    /// u⁽ᵏ⁺¹⁾ where a step needed it.
    displacement: Vec<f64>,
    trace: Trace,
}

impl<'s, 'o, 'b> OuterLoop<'s, 'o, 'b> {
    /// From a checkpoint, from given multipliers, or from those that balance a floating body or vanish.
    fn begin(
        problem: &'s SuccessiveApproximations<'s>,
        operator: &'s mut BodyOperator<'o, 'b>,
        start: Start<'_>,
    ) -> Self {
        let started = Instant::now();
        let applications_before = operator.as_dual().applications();
        let (laws, settings) = (problem.laws, problem.settings);
        let steplength = match start.checkpoint {
            Some(state) => state.steplength,
            None => projected_gradient_steplength(operator.as_dual()),
        };
        let balanced = match operator {
            BodyOperator::Constrained(_) => None,
            BodyOperator::Floating(operator) => Some(operator.balanced_start()),
        };
        let first = start.multiplier.or(balanced.as_deref());
        let mut outer = Self {
            problem,
            operator,
            kprgp: Kprgp {
                steplength,
                gamma: settings.gamma,
                max_applications: settings.max_operator_applications,
            },
            tolerance: settings.r_tol / settings.c_fact,
            change: 1.0,
            measure: 1.0,
            frozen: laws.without_pressure(problem.law, &[]),
            is_law_outdated: first.is_some() || start.checkpoint.is_some(),
            cycle: CycleDetector::default(),
            stall: Stall::default(),
            started,
            applications_before,
            slip: None,
            multiplier: vec![0.0; laws.layout.n_multipliers()],
            displacement: Vec::new(),
            trace: Trace {
                solved_by: SolvedBy::FixedPoint,
                steplength,
                ..Trace::default()
            },
        };
        if let Some(state) = start.checkpoint {
            outer.resume(state);
        } else if let Some(multiplier) = first {
            outer.multiplier = multiplier.to_vec();
            outer.update_slip();
        }
        outer
    }

    /// (iv) g = λ_ν and F(φ) of the last step, averaged over the panes.
    fn update_law(&mut self) {
        let SuccessiveApproximations { laws, law, .. } = *self.problem;
        if self.is_law_outdated {
            let (normal, _) = laws.layout.split(&self.multiplier);
            self.frozen.slip_bound = law.slip_bounds(normal);
            if let Some(slip) = &self.slip {
                self.frozen.friction = FrictionField::new(law, &laws.average, slip);
            }
        }
        self.is_law_outdated = true;
    }

    /// The inner accuracy r_tol · ε that an accuracy ε needs.
    fn final_tolerance(&self) -> f64 {
        self.problem.settings.r_tol * self.problem.settings.epsilon()
    }

    /// ε_λ⁽ᵏ⁾ from err⁽ᵏ⁻¹⁾ (HKL Remark 4.1).
    ///
    /// Two additions to the paper: control (b) never asks for more than r_tol · ε, and the outer loop
    /// ends only when the inner residual has come down to that as well. Without them an inner problem
    /// whose warm start already meets a loose tolerance takes no step, and the change of zero would
    /// pass for convergence.
    fn next_tolerance(&self) -> f64 {
        let s = self.problem.settings;
        match s.precision {
            PrecisionControl::Fixed => self.final_tolerance(),
            PrecisionControl::Adaptive => (s.r_tol * self.change)
                .min(s.c_fact * self.tolerance)
                .max(self.final_tolerance()),
        }
    }

    /// (i) λ⁽ᵏ⁺¹⁾, the minimiser on the frozen admissible set, from λ⁽ᵏ⁾.
    fn minimise(&mut self) -> InnerSummary {
        let SuccessiveApproximations { laws, inner, .. } = *self.problem;
        let set = laws.feasible_set(Some(&self.frozen));
        self.tolerance = self.next_tolerance();
        let mut next = self.multiplier.clone();
        let summary = inner.minimise(self.operator, &self.kprgp, &set, &mut next, self.tolerance);
        self.change = relative_change(&next, &self.multiplier);
        self.multiplier = next;
        self.measure = self.change;
        summary
    }

    /// (iii) How the loop ends with a step; `None` where it goes on.
    fn end_after(&mut self, summary: &InnerSummary) -> Option<StopReason> {
        let (change, tolerance) = (self.change, self.tolerance);
        let epsilon = self.problem.settings.epsilon();
        // The rounding of S λ, below which no change says anything.
        let attainable = rounding_of_products(self.multiplier.len());
        let least = self.final_tolerance();
        // An inner solver that a loose tolerance let do nothing says nothing by a change of zero.
        let asked = !self.problem.inner.was_idle(summary.steps) || tolerance <= least;
        let accurate = summary.at_rounding || (asked && summary.residual <= least);
        let cycle = self.cycle.closes(&self.multiplier, change);
        let is_finite = change.is_finite() && summary.residual.is_finite();
        let end = (!is_finite).then_some(StopReason::NumericalError);
        let met = accurate && change <= epsilon.max(attainable);
        let end = end
            .or(summary.failure)
            .or(met.then_some(StopReason::Converged))
            .or(cycle.map(|_| StopReason::Cycling))
            .or(self
                .stall
                .is_at_rounding(change, summary.at_rounding)
                .then_some(StopReason::RoundingLimit))
            .map(|end| match end {
                StopReason::Converged if epsilon < attainable => StopReason::RoundingLimit,
                end => end,
            });
        if end == Some(StopReason::RoundingLimit) {
            self.measure = change.max(summary.residual).max(attainable);
        }
        end
    }

    /// (ii) φ⁽ᵏ⁺¹⁾ where the coefficients follow it.
    fn update_slip(&mut self) {
        let SuccessiveApproximations { laws, law, .. } = *self.problem;
        if law.depends_on_slip() {
            let operator = self.operator.as_primal();
            let known = operator.tangential_displacement(&self.multiplier);
            let tangential = known.unwrap_or_else(|| {
                self.displacement = operator.to_primal(&self.multiplier);
                self.problem.body.tangential(&self.displacement)
            });
            self.slip = Some(slips(laws.previous.as_ref(), &tangential));
        }
    }

    /// Keeps what a step took, and u⁽ᵏ⁺¹⁾ of the last one.
    fn record(&mut self, summary: &InnerSummary, last: bool) {
        if last && self.displacement.is_empty() {
            let operator = self.operator.as_primal();
            self.displacement = operator.to_primal(&self.multiplier);
        }
        let applied = self.operator.as_dual().applications();
        let applications = applied - self.applications_before + summary.applications;
        self.trace.history.push(OuterStep {
            change: self.change,
            inner_tolerance: self.tolerance,
            inner_residual: summary.residual,
            steps: summary.steps,
            applications,
            seconds: self.started.elapsed().as_secs_f64(),
        });
        self.trace.applications += applications;
        self.applications_before = applied;
        self.started = Instant::now();
    }

    /// What the next outer step depends on.
    fn state(&self) -> OuterState {
        let (laws, trace) = (self.problem.laws, &self.trace);
        OuterState {
            multiplier: self.multiplier.clone(),
            slip: self.slip.clone(),
            tolerance: self.tolerance,
            steplength: trace.steplength,
            history: trace.history.clone(),
            law_evaluations: laws.law_evaluations(),
        }
    }

    /// Takes up the steps that led to a state.
    fn resume(&mut self, state: &OuterState) {
        self.multiplier.clone_from(&state.multiplier);
        self.slip.clone_from(&state.slip);
        let trace = &mut self.trace;
        trace.history.clone_from(&state.history);
        trace.applications = state.history.iter().map(|step| step.applications).sum();
        self.change = state.history.last().map_or(1.0, |step| step.change);
        self.measure = self.change;
        self.tolerance = state.tolerance;
        self.problem.law.set_evaluations(state.law_evaluations);
    }
}

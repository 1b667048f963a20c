//! Newton's method: damped steps, stalls and how they end, for any problem that knows a step.
//!
//! One loop serves three models of the derivative R': the dense matrix of its columns ([`super::dense`]), that matrix bordered by
//! coefficients of friction ([`super::friction_graph`]), and products with GMRES ([`crate::solver::newton_krylov`]).

use std::time::Instant;

use crate::{
    dual::ExplicitDual,
    solver::{
        NewtonStep, StopReason,
        conditions::Evaluation,
        tolerances::{LOOP_MAX_STEPS, ROUNDING_STALL_STEPS, STAGNATION_STEPS},
    },
};

/// Halvings of one step before the full step is taken all the same: ‖R‖ falls along a length of 1/4096 or in another zone only.
const STEP_MAX_HALVINGS: usize = 12;

/// The same as [`STAGNATION_STEPS`] from a good start, which wins some digits a step or fails.
const NEAR_STAGNATION_STEPS: usize = 6;

/// Below this relative residual a stall is rounding: Newton's steps win half of the digits or more there, unless none are left.
pub(super) const ROUNDING_REGIME: f64 = 1e-9;

/// When Newton's method ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewtonSettings {
    /// Stop when ‖R‖ ≤ tolerance · ‖λ‖.
    pub tolerance: f64,
    /// Most steps.
    pub max_steps: usize,
    /// Fewer steps are taken only where R = 0: a start within the tolerance is measured and not believed.
    pub least_steps: usize,
    /// Steps in which the best residual must halve.
    pub stagnation_steps: usize,
    /// The same at rounding.
    pub rounding_steps: usize,
}

/// To rounding: no n ε_M of fewer than 4500 multipliers is larger.
impl Default for NewtonSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-12,
            max_steps: LOOP_MAX_STEPS,
            least_steps: 0,
            stagnation_steps: STAGNATION_STEPS,
            rounding_steps: ROUNDING_STALL_STEPS,
        }
    }
}

impl NewtonSettings {
    /// To the rounding of S λ.
    pub(in crate::solver) fn to_rounding(dual: &ExplicitDual) -> Self {
        Self {
            tolerance: dual.rounding(),
            ..Self::default()
        }
    }

    /// From a good start, which needs few steps; and there are other starts.
    pub(in crate::solver) fn near_solution(self) -> Self {
        Self {
            stagnation_steps: NEAR_STAGNATION_STEPS,
            ..self
        }
    }
}

/// Unknowns with the natural map R there.
pub(in crate::solver) struct Iterate<P> {
    /// x with what a step from there needs.
    pub(in crate::solver) point: P,
    /// What ‖R‖ is measured by: ‖λ‖, beside the stresses that weak supports take off the face.
    pub(in crate::solver) size: f64,
    pub(in crate::solver) evaluation: Evaluation,
}

impl<P> Iterate<P> {
    /// ‖R‖ / ‖λ‖, and 0 for 0/0.
    pub(in crate::solver) fn relative(&self) -> f64 {
        self.evaluation.relative_to(self.size)
    }

    fn norm(&self) -> f64 {
        self.evaluation.norm
    }
}

/// A problem R(x) = 0 as Newton's method sees it.
pub(in crate::solver) trait NewtonModel {
    /// x with what a step from there needs.
    type Point;

    /// d with R'(x) d = −R(x), and the number of its coupled unknowns; `None` where R' is singular.
    fn direction(&mut self, from: &Iterate<Self::Point>) -> Option<(Vec<f64>, usize)>;

    /// The trial iterate at x + s d for a length s ≤ 1, which a model may improve by relaxation.
    fn trial(
        &mut self,
        from: &Iterate<Self::Point>,
        direction: &[f64],
        length: f64,
    ) -> Iterate<Self::Point>;

    /// Whether steps are halved until ‖R‖ falls.
    fn is_damped(&self) -> bool {
        true
    }

    /// Whether a stall with this iterate as the best one is rounding.
    fn is_at_rounding(&self, best: &Iterate<Self::Point>) -> bool {
        best.relative() < ROUNDING_REGIME
    }

    /// Where the method begins once more after a stall, if anywhere.
    fn restart(&mut self) -> Option<Iterate<Self::Point>> {
        None
    }

    /// What comes closer than the best iterate without Newton's step, after a stall or where R' is singular.
    fn safeguard(&mut self, _best: &Iterate<Self::Point>) -> Option<Iterate<Self::Point>> {
        None
    }
}

/// Runs the damped method from a start: a step is halved until ‖R‖ falls, and taken in full where it never does. A stall leads to the
/// model's restart, then, as a singular R' does, to its safeguard, and ends the method where it has neither.
///
/// Returns why it stopped, the last iterate where it converged, else the one with the least residual, and the record of its steps.
pub(in crate::solver) fn iterate<M: NewtonModel>(
    model: &mut M,
    start: Iterate<M::Point>,
    settings: &NewtonSettings,
    mut observe: impl FnMut(usize, &NewtonStep),
) -> (StopReason, Iterate<M::Point>, Vec<NewtonStep>) {
    let mut run = NewtonRun::new(start);
    let mut history: Vec<NewtonStep> = Vec::new();
    let stop = loop {
        if let Some(stop) = run.stop(model, settings, history.len()) {
            break stop;
        }
        let stalls = run.stalled_for(settings.stagnation_steps);
        if stalls && let Some(start) = model.restart() {
            run.restart(start);
            continue;
        }
        let started = Instant::now();
        let direction = match stalls {
            true => None,
            false => model.direction(&run.current),
        };
        let reached = match direction {
            Some((direction, coupled)) => Some(damped(model, &run.current, &direction, coupled)),
            None => run.safeguarded(model),
        };
        let Some((reached, step)) = reached else {
            break StopReason::MaxSteps;
        };
        let step = NewtonStep {
            residual: reached.relative(),
            zone_changes: zone_changes(&run.current.evaluation, &reached.evaluation),
            seconds: started.elapsed().as_secs_f64(),
            ..step
        };
        observe(history.len(), &step);
        history.push(step);
        run.move_to(reached);
    };
    let reached = match (stop, run.earlier) {
        (StopReason::Converged, _) | (_, None) => run.current,
        (_, Some(best)) => best,
    };
    (stop, reached, history)
}

/// The damped step: halved until ‖R‖ falls, in full where it never does.
fn damped<M: NewtonModel>(
    model: &mut M,
    from: &Iterate<M::Point>,
    direction: &[f64],
    free_unknowns: usize,
) -> (Iterate<M::Point>, NewtonStep) {
    let step = |halvings: usize, step_length: f64| NewtonStep {
        step_length,
        halvings,
        free_unknowns,
        ..NewtonStep::default()
    };
    let mut full = None;
    for halvings in 0..=STEP_MAX_HALVINGS {
        let length = 0.5_f64.powi(halvings as i32);
        let reached = model.trial(from, direction, length);
        if reached.norm() < from.norm() || !model.is_damped() {
            return (reached, step(halvings, length));
        }
        full.get_or_insert(reached);
    }
    let full = full.expect("the full step is the first");
    (full, step(STEP_MAX_HALVINGS, 1.0))
}

/// Panes that change between open, stick and slip.
fn zone_changes(before: &Evaluation, after: &Evaluation) -> usize {
    let panes = before.panes.iter().zip(&after.panes);
    panes.filter(|(a, b)| a.zone() != b.zone()).count()
}

/// Where a run of Newton's method is, and how its residuals fell.
struct NewtonRun<P> {
    current: Iterate<P>,
    /// The iterate with the least residual, where that is not the present one.
    earlier: Option<Iterate<P>>,
    /// The least residual after each step.
    least: Vec<f64>,
    /// The first of these that a stall is measured from.
    first: usize,
}

impl<P> NewtonRun<P> {
    fn new(start: Iterate<P>) -> Self {
        Self {
            least: vec![start.norm()],
            current: start,
            earlier: None,
            first: 0,
        }
    }

    /// The iterate with the least residual. Rounding is told there, since a step along what hardly anything resists may be so long that
    /// its own rounding explains any residual.
    fn best(&self) -> &Iterate<P> {
        self.earlier.as_ref().unwrap_or(&self.current)
    }

    /// Whether the method ends after so many steps, and why.
    fn stop<M: NewtonModel<Point = P>>(
        &self,
        model: &M,
        settings: &NewtonSettings,
        steps: usize,
    ) -> Option<StopReason> {
        let norm = self.current.norm();
        let is_small = self.current.relative() <= settings.tolerance;
        if norm == 0.0 || is_small && steps >= settings.least_steps {
            return Some(StopReason::Converged);
        }
        if !norm.is_finite() {
            return Some(StopReason::NumericalError);
        }
        if self.stalled_for(settings.rounding_steps) && model.is_at_rounding(self.best()) {
            return Some(StopReason::RoundingLimit);
        }
        (steps == settings.max_steps).then_some(StopReason::MaxSteps)
    }

    /// Whether the last steps, so many, have not halved the least residual.
    fn stalled_for(&self, steps: usize) -> bool {
        let last = self.least.len() - 1;
        last >= self.first + steps && self.least[last] > 0.5 * self.least[last - steps]
    }

    /// Begins once more, and remembers the best iterate.
    fn restart(&mut self, start: Iterate<P>) {
        (self.least, self.first) = (vec![start.norm()], 0);
        let last = std::mem::replace(&mut self.current, start);
        self.earlier.get_or_insert(last);
    }

    /// What the safeguard makes of the best iterate; stalls are measured from there on.
    fn safeguarded<M: NewtonModel<Point = P>>(
        &mut self,
        model: &mut M,
    ) -> Option<(Iterate<P>, NewtonStep)> {
        let reached = model.safeguard(self.best())?;
        self.first = self.least.len();
        let step = NewtonStep {
            step_length: 1.0,
            safeguard: true,
            ..NewtonStep::default()
        };
        Some((reached, step))
    }

    fn move_to(&mut self, next: Iterate<P>) {
        let (norm, least) = (next.norm(), self.best().norm());
        let last = std::mem::replace(&mut self.current, next);
        if norm < least {
            self.earlier = None;
        } else {
            self.earlier.get_or_insert(last);
        }
        let least = self.least[self.least.len() - 1];
        self.least.push(least.min(norm));
    }
}

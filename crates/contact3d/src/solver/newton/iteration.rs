//! Newton's method: damped steps, stalls and how they end, for any problem that knows a step.
//!
//! One loop serves three models of the derivative R': the dense matrix of its columns ([`super::dense`]), that matrix bordered by
//! coefficients of friction ([`super::friction_graph`]), and products with GMRES ([`crate::solver::newton_krylov`]).

use std::time::Instant;

use crate::{
    dual::ExplicitDual,
    solver::{NewtonStep, StopReason, conditions::Evaluation, tolerances::ROUNDING_STALL_STEPS},
};

/// Halvings of one step before the full step is taken all the same: ‖R‖ falls along a length of 1/4096 or in another zone only.
const STEP_MAX_HALVINGS: usize = 12;

/// The same as [`STAGNATION_STEPS`](crate::solver::tolerances::STAGNATION_STEPS) from a good start, which wins some digits a step or fails.
const NEAR_STAGNATION_STEPS: usize = 6;

/// Below this relative residual a stall is rounding: Newton's steps win half of the digits or more there, unless none are left.
pub(super) const ROUNDING_ZONE: f64 = 1e-9;

/// How Newton's method is stopped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewtonSettings {
    /// Stop when ‖R‖ ≤ tolerance · ‖λ‖.
    pub tolerance: f64,
    /// Most steps.
    pub max_steps: usize,
}

/// To rounding: no n ε of fewer than 4500 multipliers is larger.
impl Default for NewtonSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-12,
            max_steps: 100,
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
}

/// A problem R(x) = 0 as Newton's method sees it.
pub(in crate::solver) trait NewtonModel {
    /// x with R(x) and what a step from there needs.
    type Iterate;

    /// R at an iterate.
    fn evaluation<'i>(&self, iterate: &'i Self::Iterate) -> &'i Evaluation;

    /// ‖R‖ / ‖λ‖, and 0 for 0/0.
    fn relative(&self, iterate: &Self::Iterate) -> f64;

    /// d with R'(x) d = −R(x), and the number of its coupled unknowns; `None` where R' is singular.
    fn direction(&mut self, from: &Self::Iterate) -> Option<(Vec<f64>, usize)>;

    /// The trial iterate at x + s d for a length s ≤ 1, which a model may improve by relaxation.
    fn trial(&mut self, from: &Self::Iterate, direction: &[f64], length: f64) -> Self::Iterate;

    /// Whether a stall with this iterate as the best one is rounding.
    fn is_at_rounding(&self, best: &Self::Iterate) -> bool {
        self.relative(best) < ROUNDING_ZONE
    }

    /// Where the method begins once more after a stall, if anywhere.
    fn restart(&mut self) -> Option<Self::Iterate> {
        None
    }

    /// What comes closer than the best iterate without Newton's step, after a stall or where R' is singular.
    fn safeguard(&mut self, _best: &Self::Iterate) -> Option<Self::Iterate> {
        None
    }
}

/// When Newton's method ends.
pub(in crate::solver) struct StoppingRule {
    pub(in crate::solver) settings: NewtonSettings,
    /// Fewer steps are taken only where R = 0.
    pub(in crate::solver) least_steps: usize,
    /// Steps in which the best residual must halve.
    pub(in crate::solver) stagnation_steps: usize,
    /// The same at rounding.
    pub(in crate::solver) rounding_steps: usize,
}

impl StoppingRule {
    /// From a good start, which needs few steps; and there are other starts.
    pub(in crate::solver) fn from_near(settings: NewtonSettings) -> Self {
        Self {
            settings,
            least_steps: 0,
            stagnation_steps: NEAR_STAGNATION_STEPS,
            rounding_steps: ROUNDING_STALL_STEPS,
        }
    }
}

/// How Newton's method ended, and where.
pub(in crate::solver) struct NewtonOutcome<I> {
    pub(in crate::solver) stop: StopReason,
    /// The last iterate where the method converged, else the one with the least residual.
    pub(in crate::solver) iterate: I,
    pub(in crate::solver) history: Vec<NewtonStep>,
}

/// Runs the damped method from a start: a step is halved until ‖R‖ falls, and taken in full where it never does. A stall leads to the
/// model's restart, then, as a singular R' does, to its safeguard, and ends the method where it has neither.
pub(in crate::solver) fn iterate<M: NewtonModel>(
    model: &mut M,
    start: M::Iterate,
    rule: &StoppingRule,
    mut observe: impl FnMut(usize, &NewtonStep),
) -> NewtonOutcome<M::Iterate> {
    let mut current = start;
    // The iterate with the least residual, where that is not the present one.
    let mut earlier: Option<M::Iterate> = None;
    let mut residuals = BestResiduals::new(model.evaluation(&current).norm);
    let mut history: Vec<NewtonStep> = Vec::new();
    let stop = loop {
        let norm = model.evaluation(&current).norm;
        let is_small = model.relative(&current) <= rule.settings.tolerance;
        if norm == 0.0 || is_small && history.len() >= rule.least_steps {
            break StopReason::Converged;
        }
        if !norm.is_finite() {
            break StopReason::NumericalError;
        }
        // Of the best iterate: a step along what hardly anything resists may be so long that its own rounding explains any residual.
        let best = earlier.as_ref().unwrap_or(&current);
        if residuals.stalled_for(rule.rounding_steps) && model.is_at_rounding(best) {
            break StopReason::RoundingLimit;
        }
        if history.len() == rule.settings.max_steps {
            break StopReason::MaxSteps;
        }
        let stalls = residuals.stalled_for(rule.stagnation_steps);
        if stalls && let Some(start) = model.restart() {
            residuals = BestResiduals::new(model.evaluation(&start).norm);
            earlier.get_or_insert(std::mem::replace(&mut current, start));
            continue;
        }
        let started = Instant::now();
        let direction = match stalls {
            true => None,
            false => model.direction(&current),
        };
        let (reached, step) = match &direction {
            Some((direction, coupled)) => {
                let (reached, step) = halved(model, &current, direction);
                let free_unknowns = *coupled;
                (
                    reached,
                    NewtonStep {
                        free_unknowns,
                        ..step
                    },
                )
            }
            None => match model.safeguard(best) {
                Some(reached) => {
                    residuals.begin_anew();
                    let step = NewtonStep {
                        step_length: 1.0,
                        safeguard: true,
                        ..NewtonStep::default()
                    };
                    (reached, step)
                }
                None => break StopReason::MaxSteps,
            },
        };
        let least = model.evaluation(best).norm;
        let [before, after] =
            [&current, &reached].map(|iterate| model.evaluation(iterate).panes.iter());
        let zone_changes = before.zip(after).filter(|(a, b)| a.zone() != b.zone());
        history.push(NewtonStep {
            residual: model.relative(&reached),
            zone_changes: zone_changes.count(),
            seconds: started.elapsed().as_secs_f64(),
            ..step
        });
        observe(history.len() - 1, &history[history.len() - 1]);
        let previous = std::mem::replace(&mut current, reached);
        let norm = model.evaluation(&current).norm;
        if norm < least {
            earlier = None;
        } else {
            earlier.get_or_insert(previous);
        }
        residuals.push(norm);
    };
    NewtonOutcome {
        iterate: match (stop, earlier) {
            (StopReason::Converged, _) | (_, None) => current,
            (_, Some(best)) => best,
        },
        stop,
        history,
    }
}

/// Halves a step until ‖R‖ falls, the full step where it never does: what it led to, with its length and halvings.
fn halved<M: NewtonModel>(
    model: &mut M,
    from: &M::Iterate,
    direction: &[f64],
) -> (M::Iterate, NewtonStep) {
    let norm = model.evaluation(from).norm;
    let mut full = None;
    for halvings in 0..=STEP_MAX_HALVINGS {
        let length = 0.5_f64.powi(halvings as i32);
        let reached = model.trial(from, direction, length);
        if model.evaluation(&reached).norm < norm {
            let step = NewtonStep {
                step_length: length,
                halvings,
                ..NewtonStep::default()
            };
            return (reached, step);
        }
        full.get_or_insert(reached);
    }
    let step = NewtonStep {
        step_length: 1.0,
        halvings: STEP_MAX_HALVINGS,
        ..NewtonStep::default()
    };
    (full.expect("the full step is the first"), step)
}

/// The least residual after each step.
struct BestResiduals {
    least: Vec<f64>,
    /// The first one that a stall is measured from.
    first: usize,
}

impl BestResiduals {
    fn new(norm: f64) -> Self {
        Self {
            least: vec![norm],
            first: 0,
        }
    }

    fn push(&mut self, norm: f64) {
        let least = self.least[self.least.len() - 1];
        self.least.push(least.min(norm));
    }

    /// Measures stalls from the next step on.
    fn begin_anew(&mut self) {
        self.first = self.least.len();
    }

    /// Whether the last steps, so many, have not halved the residual.
    fn stalled_for(&self, steps: usize) -> bool {
        let last = self.least.len() - 1;
        last >= self.first + steps && self.least[last] > 0.5 * self.least[last - steps]
    }
}

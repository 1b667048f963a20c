use std::time::Instant;

use super::natural_map::{Evaluation, NaturalMap, PaneZone};
use crate::linalg::norm;

/// Halvings of one step before the full step is taken all the same.
const MOST_HALVINGS: usize = 12;

/// Steps in which the best residual must halve; otherwise Newton's method has stalled.
const PATIENCE: usize = 10;

/// Below this relative residual a stall within `ROUNDING_PATIENCE` steps is rounding.
const ROUNDING_ZONE: f64 = 1e-9;
const ROUNDING_PATIENCE: usize = 3;

/// How Newton's method is stopped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewtonSettings {
    /// Stop when ‖R‖ ≤ tolerance · ‖λ‖.
    pub tolerance: f64,
    /// Most steps.
    pub max_steps: usize,
}

impl Default for NewtonSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-12,
            max_steps: 100,
        }
    }
}

/// How Newton's method ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NewtonStatus {
    /// ‖R‖ ≤ tolerance · ‖λ‖.
    Converged,
    /// The residual fell below 1e-9 · ‖λ‖ and then no further: rounding forbids the tolerance, and
    /// the final residual is the attainable accuracy.
    RoundingLimit,
    /// The steps ran out.
    MaxSteps,
    /// A value was not finite.
    NumericalError,
}

/// One step of Newton's method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewtonStep {
    /// ‖R‖ / ‖λ‖ after the step.
    pub residual: f64,
    /// Share s of the step d in λ ← λ + s d.
    pub step_length: f64,
    /// Halvings tried.
    pub halvings: usize,
    /// Panes that changed between open, stick and slip.
    pub zone_changes: usize,
    /// Unknowns of the dense system.
    pub free_unknowns: usize,
    /// Whether a safeguard replaced Newton's step.
    pub fallback: bool,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// Where the iteration ended.
pub(super) struct NewtonOutcome {
    pub(super) status: NewtonStatus,
    pub(super) multiplier: Vec<f64>,
    /// ‖R‖ / ‖λ‖.
    pub(super) residual: f64,
    pub(super) history: Vec<NewtonStep>,
    /// Evaluations of R, one action of S each.
    pub(super) evaluations: usize,
}

/// An iterate and its residual.
struct Iterate {
    multiplier: Vec<f64>,
    evaluation: Evaluation,
}

impl Iterate {
    fn new(map: &NaturalMap<'_>, multiplier: Vec<f64>) -> Self {
        let evaluation = map.evaluate(&multiplier);
        Self {
            multiplier,
            evaluation,
        }
    }

    /// ‖R‖ / ‖λ‖, and 0 for 0/0.
    fn relative(&self) -> f64 {
        match self.evaluation.norm {
            0.0 => 0.0,
            residual => residual / norm(&self.multiplier),
        }
    }

    fn zones(&self) -> impl Iterator<Item = PaneZone> + '_ {
        self.evaluation.panes.iter().map(|pane| pane.zone())
    }
}

/// Runs the damped semismooth Newton method from a start; `safeguard` gives a
/// better multiplier when Newton's step is singular or the residual stalls. At least `least_steps`
/// are taken unless R = 0.
pub(super) fn iterate(
    map: &NaturalMap<'_>,
    start: Vec<f64>,
    settings: &NewtonSettings,
    least_steps: usize,
    mut safeguard: impl FnMut(&[f64]) -> Vec<f64>,
    mut observe: impl FnMut(usize, &NewtonStep),
) -> NewtonOutcome {
    let mut current = Iterate::new(map, start);
    let mut best = (
        current.evaluation.norm,
        current.multiplier.clone(),
        current.relative(),
    );
    let mut best_norms = vec![best.0];
    let mut window_start = 0;
    let mut evaluations = 1;
    let mut history: Vec<NewtonStep> = Vec::new();
    let status = loop {
        let relative = current.relative();
        let small = relative <= settings.tolerance && history.len() >= least_steps;
        if small || current.evaluation.norm == 0.0 {
            break NewtonStatus::Converged;
        }
        if !current.evaluation.norm.is_finite() {
            break NewtonStatus::NumericalError;
        }
        let stalled_for = |steps: usize| {
            let last = best_norms.len() - 1;
            last >= window_start + steps && best_norms[last] > 0.5 * best_norms[last - steps]
        };
        if best.2 < ROUNDING_ZONE && stalled_for(ROUNDING_PATIENCE) {
            break NewtonStatus::RoundingLimit;
        }
        if history.len() == settings.max_steps {
            break NewtonStatus::MaxSteps;
        }
        let started = Instant::now();
        let direction = if stalled_for(PATIENCE) {
            None
        } else {
            map.newton_step(&current.evaluation)
        };
        let (next, step_length, halvings) = match &direction {
            Some((direction, _)) => backtrack(map, &current, direction),
            None => {
                window_start = best_norms.len();
                (Iterate::new(map, safeguard(&best.1)), 1.0, 0)
            }
        };
        evaluations += 1 + halvings;
        let step = NewtonStep {
            residual: next.relative(),
            step_length,
            halvings,
            zone_changes: current
                .zones()
                .zip(next.zones())
                .filter(|(a, b)| a != b)
                .count(),
            free_unknowns: direction.as_ref().map_or(0, |(_, free)| *free),
            fallback: direction.is_none(),
            seconds: started.elapsed().as_secs_f64(),
        };
        observe(history.len(), &step);
        history.push(step);
        current = next;
        if current.evaluation.norm < best.0 {
            best = (
                current.evaluation.norm,
                current.multiplier.clone(),
                current.relative(),
            );
        }
        best_norms.push(best.0);
    };
    let (multiplier, residual) = if status == NewtonStatus::Converged {
        (current.multiplier.clone(), current.relative())
    } else {
        (best.1, best.2)
    };
    NewtonOutcome {
        status,
        multiplier,
        residual,
        history,
        evaluations,
    }
}

/// Halves the step until ‖R‖ decreases; the full step when that fails.
fn backtrack(map: &NaturalMap<'_>, from: &Iterate, direction: &[f64]) -> (Iterate, f64, usize) {
    let at = |share: f64| {
        let moved = from.multiplier.iter().zip(direction);
        Iterate::new(map, moved.map(|(l, d)| l + share * d).collect())
    };
    let full = at(1.0);
    if full.evaluation.norm < from.evaluation.norm {
        return (full, 1.0, 0);
    }
    let mut share = 1.0;
    for halvings in 1..=MOST_HALVINGS {
        share *= 0.5;
        let next = at(share);
        if next.evaluation.norm < from.evaluation.norm {
            return (next, share, halvings);
        }
    }
    (full, 1.0, MOST_HALVINGS)
}

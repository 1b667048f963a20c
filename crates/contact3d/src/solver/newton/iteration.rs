//! Semismooth Newton on the natural map of the problem.

use std::time::Instant;

use super::{
    NewtonSolution,
    damping::{BestResiduals, Damped, ROUNDING_ZONE, STAGNATION_STEPS, halved},
    natural_map::NaturalMap,
};
use crate::{
    dual::ExplicitDual,
    solver::{
        conditions::{Evaluation, PaneZone},
        solution::NewtonStep,
    },
};

/// Sweeps of relaxation at the start and after every trial step.
const FIRST_SWEEPS: usize = 20;
const SWEEPS_PER_STEP: usize = 10;

/// A step that reduces ‖R‖ to this share lies in the range of fast convergence: nothing to relax.
const FAST_DECREASE: f64 = 0.01;

/// [`STAGNATION_STEPS`] without relaxation, fewer: a good start needs few steps, and there are other starts.
const PLAIN_STAGNATION_STEPS: usize = 6;

/// In [`ROUNDING_ZONE`], or below what rounding of S λ makes of the residual, a stall within so many steps is rounding.
const ROUNDING_STAGNATION_STEPS: usize = 3;

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

impl NewtonSettings {
    /// To the rounding of S λ.
    pub(in crate::solver) fn to_rounding(dual: &ExplicitDual) -> Self {
        Self {
            tolerance: dual.rounding(),
            ..Self::default()
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
    /// The steps ran out, or the residual fell no further and nothing was left to try.
    MaxSteps,
    /// A value was not finite.
    NumericalError,
}

/// What helps Newton's method on its way.
pub(in crate::solver) enum Globalisation<'f> {
    /// Sweeps of relaxation, and, after a stall, steps of a safeguard from the best iterate.
    Relaxed(&'f mut dyn FnMut(&[f64]) -> Vec<f64>),
    /// A good start alone; a stall ends the method, at rounding after so many steps.
    Plain(usize),
}

/// An iterate and its residual.
struct Iterate {
    multiplier: Vec<f64>,
    /// ‖λ‖, beside the stresses that weak supports take off the face.
    size: f64,
    evaluation: Evaluation,
}

impl Iterate {
    fn new(map: &NaturalMap<'_>, multiplier: Vec<f64>) -> Self {
        let evaluation = map.evaluate(&multiplier);
        Self {
            size: map.size(&multiplier),
            multiplier,
            evaluation,
        }
    }

    /// This iterate or its relaxation, whichever has the smaller ‖R‖.
    fn relaxed(self, map: &NaturalMap<'_>, sweeps: usize) -> Self {
        let mut multiplier = self.multiplier.clone();
        map.relax(&mut multiplier, sweeps);
        let relaxed = Self::new(map, multiplier);
        if relaxed.evaluation.norm < self.evaluation.norm {
            relaxed
        } else {
            self
        }
    }

    /// ‖R‖ / ‖λ‖, and 0 for 0/0.
    fn relative(&self) -> f64 {
        match self.evaluation.norm {
            0.0 => 0.0,
            residual => residual / self.size,
        }
    }

    fn zones(&self) -> impl Iterator<Item = PaneZone> + '_ {
        self.evaluation.panes.iter().map(|pane| pane.zone())
    }
}

/// Runs the damped semismooth Newton method from a start.
///
/// [`Globalisation::Relaxed`]: with relaxed trial steps until the residual stalls and then once more
/// without; after that, or when Newton's step is singular, the safeguard gives a better multiplier.
/// [`Globalisation::Plain`] ends there. At least `least_steps` are taken unless R = 0.
pub(in crate::solver) fn iterate(
    map: &NaturalMap<'_>,
    start: Vec<f64>,
    settings: &NewtonSettings,
    least_steps: usize,
    mut globalisation: Globalisation<'_>,
    mut observe: impl FnMut(usize, &NewtonStep),
) -> NewtonSolution {
    let mut current = Iterate::new(map, start.clone());
    let mut evaluations = 1;
    let (patience, rounding_patience, mut relaxing) = match globalisation {
        Globalisation::Plain(rounding_patience) => {
            (PLAIN_STAGNATION_STEPS, rounding_patience, false)
        }
        Globalisation::Relaxed(_) => (STAGNATION_STEPS, ROUNDING_STAGNATION_STEPS, true),
    };
    if relaxing && current.evaluation.norm.is_finite() && current.relative() > settings.tolerance {
        current = current.relaxed(map, FIRST_SWEEPS);
        evaluations += FIRST_SWEEPS + 2;
    }
    let mut best = (
        current.evaluation.norm,
        current.multiplier.clone(),
        current.relative(),
    );
    let mut residuals = BestResiduals::new(best.0);
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
        // Of the best iterate: a step along what hardly anything resists may be so long that its own rounding explains any residual.
        let rounding = || map.rounding(&best.1, &map.evaluate(&best.1));
        if residuals.stalled_for(rounding_patience)
            && (best.2 < ROUNDING_ZONE || best.2 < rounding())
        {
            break NewtonStatus::RoundingLimit;
        }
        if history.len() == settings.max_steps {
            break NewtonStatus::MaxSteps;
        }
        if relaxing && residuals.stalled_for(patience) {
            relaxing = false;
            current = Iterate::new(map, start.clone());
            evaluations += 1;
            residuals = BestResiduals::new(current.evaluation.norm);
            continue;
        }
        let started = Instant::now();
        let direction = if residuals.stalled_for(patience) {
            None
        } else {
            map.newton_step(&current.evaluation)
        };
        let (step, applications) = match (&direction, &mut globalisation) {
            (Some((direction, _)), _) => backtrack(map, &current, direction, relaxing),
            (None, Globalisation::Plain(_)) => break NewtonStatus::MaxSteps,
            (None, Globalisation::Relaxed(safeguard)) => {
                residuals.begin_anew();
                let safe = Damped {
                    reached: Iterate::new(map, safeguard(&best.1)),
                    length: 1.0,
                    halvings: 0,
                };
                (safe, 1)
            }
        };
        let Damped {
            reached: next,
            length: step_length,
            halvings,
        } = step;
        evaluations += applications;
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
            law_share: 1.0,
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
        residuals.push(current.evaluation.norm);
    };
    let (multiplier, residual) = if status == NewtonStatus::Converged {
        (current.multiplier.clone(), current.relative())
    } else {
        (best.1, best.2)
    };
    NewtonSolution {
        status,
        multiplier,
        residual,
        history,
        evaluations,
    }
}

/// A step after which ‖R‖, relaxed or not, decreases, and the applications of S that it took.
fn backtrack(
    map: &NaturalMap<'_>,
    from: &Iterate,
    direction: &[f64],
    relaxing: bool,
) -> (Damped<Iterate>, usize) {
    let mut applications = 0;
    let at = |share: f64| {
        let moved = from.multiplier.iter().zip(direction);
        let next = Iterate::new(map, moved.map(|(l, d)| l + share * d).collect());
        applications += 1;
        if !relaxing || next.evaluation.norm < FAST_DECREASE * from.evaluation.norm {
            return next;
        }
        applications += SWEEPS_PER_STEP + 2;
        next.relaxed(map, SWEEPS_PER_STEP)
    };
    let step = halved(at, |next| next.evaluation.norm < from.evaluation.norm);
    (step, applications)
}

use super::{ContactState, NewtonSettings, NewtonSolution, NewtonStatus, NewtonStep, newton};
use crate::{contact::CoulombLaw, dual::ExplicitDual};

/// The constant coefficient F₀ that the path begins with: contact with little friction is nearly
/// that without, which is convex.
const REFERENCE: f64 = 0.1;

/// First and smallest step in the share τ.
const FIRST_STEP: f64 = 0.25;
const SMALLEST_STEP: f64 = 1.0 / 512.0;

/// Most steps of Newton's method at one τ: a start so close needs few.
const MOST_STEPS: usize = 40;

/// Follows the solutions for the laws F₀^(1−τ) F^τ from τ = 0 to 1, each from the one before, by
/// steps in τ that double after a success and halve after a failure.
///
/// The path may end before τ = 1 where solutions vanish in pairs; the status is then that of the last
/// failure. `observe` sees the steps, numbered from `done` on.
pub(super) fn continuation(
    dual: &ExplicitDual,
    contact: &ContactState<'_>,
    law: &CoulombLaw,
    settings: &NewtonSettings,
    done: usize,
    mut observe: impl FnMut(usize, &NewtonStep),
) -> NewtonSolution {
    let on_path = NewtonSettings {
        max_steps: settings.max_steps.min(MOST_STEPS),
        ..*settings
    };
    let mut history: Vec<NewtonStep> = Vec::new();
    let mut evaluations = 0;
    let mut at = |share: f64, start: Option<&[f64]>| {
        let law = law.softened(REFERENCE, share);
        let mut found = newton(dual, contact, &law, start, &on_path, |_, _| {});
        for step in &mut found.history {
            step.law_share = share;
            observe(done + history.len(), step);
            history.push(*step);
        }
        evaluations += found.evaluations;
        found
    };
    let mut last = at(0.0, None);
    let (mut share, mut step) = (0.0, FIRST_STEP);
    while share < 1.0 && is_solution(&last) {
        let target = f64::min(share + step, 1.0);
        let found = at(target, Some(&last.multiplier));
        if is_solution(&found) {
            (last, share) = (found, target);
            step *= 2.0;
        } else if step <= SMALLEST_STEP {
            last.status = found.status;
            break;
        } else {
            step /= 2.0;
        }
    }
    NewtonSolution {
        history,
        evaluations,
        ..last
    }
}

/// Whether Newton's method found what it looked for.
pub(super) fn is_solution(found: &NewtonSolution) -> bool {
    matches!(
        found.status,
        NewtonStatus::Converged | NewtonStatus::RoundingLimit
    )
}

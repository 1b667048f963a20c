//! Approach to a hard law of friction through easier ones.

use super::NewtonSolution;
use crate::solver::NewtonStep;

/// Smallest step in the share τ.
const SMALLEST_SHARE_STEP: f64 = 1.0 / 512.0;

/// Follows the solutions of problems from an easy one at τ = 0 to that of the scene at τ = 1, each from the one before, by
/// steps in τ that double after a success and halve after a failure; `solve` finds the solution for a τ from a start.
///
/// The path may end before τ = 1 where solutions vanish in pairs; the status is then that of the last failure.
pub(in crate::solver) fn continuation(
    observe: &mut dyn FnMut(usize, &NewtonStep),
    mut solve: impl FnMut(f64, Option<&[f64]>) -> NewtonSolution,
) -> NewtonSolution {
    let mut history: Vec<NewtonStep> = Vec::new();
    let mut evaluations = 0;
    let mut at = |share: f64, start: Option<&[f64]>| {
        let mut found = solve(share, start);
        for step in &mut found.history {
            step.law_share = share;
            observe(history.len(), step);
            history.push(*step);
        }
        evaluations += found.evaluations;
        found
    };
    let mut last = at(0.0, None);
    let (mut share, mut step) = (0.0, 0.25);
    while share < 1.0 && last.is_solution() {
        let target = f64::min(share + step, 1.0);
        let found = at(target, Some(&last.multiplier));
        if found.is_solution() {
            (last, share) = (found, target);
            step *= 2.0;
        } else if step <= SMALLEST_SHARE_STEP {
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

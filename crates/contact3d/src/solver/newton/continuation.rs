//! Approach to a hard law of friction through easier ones.

use super::NewtonSolution;

/// Smallest step in τ.
const SMALLEST_PATH_STEP: f64 = 1.0 / 512.0;

/// Follows the solutions of problems from an easy one at τ = 0 to that of the scene at τ = 1, each from the one before, by
/// steps in τ that double after a success and halve after a failure; `solve` finds the solution for a τ from a start.
///
/// The path may end before τ = 1 where solutions vanish in pairs; the reason to stop is then that of the last failure.
pub(in crate::solver) fn continuation(
    mut solve: impl FnMut(f64, Option<&[f64]>) -> NewtonSolution,
) -> NewtonSolution {
    let mut last = solve(0.0, None);
    let (mut tau, mut step) = (0.0, 0.25);
    while tau < 1.0 && last.stop.is_solution() {
        let target = f64::min(tau + step, 1.0);
        let found = solve(target, Some(&last.multiplier));
        if found.stop.is_solution() {
            (last, tau) = (last.merged_with(found), target);
            step *= 2.0;
            continue;
        }
        last.evaluations += found.evaluations;
        last.history.extend(found.history);
        if step <= SMALLEST_PATH_STEP {
            last.stop = found.stop;
            break;
        }
        step /= 2.0;
    }
    last
}

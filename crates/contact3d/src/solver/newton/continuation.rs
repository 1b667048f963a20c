//! Approach to a hard problem through easier ones: to a law of friction, and to a body that only contact holds through springs that
//! vanish.

use super::{NewtonSolution, search::Search};
use crate::{contact::CoulombLaw, solver::NewtonStep};

/// The constant coefficient F₀ that the path begins with: contact with little friction is nearly
/// that without, which is convex.
const REFERENCE: f64 = 0.1;

/// First and smallest step in the share τ.
const FIRST_STEP: f64 = 0.25;
const SMALLEST_STEP: f64 = 1.0 / 512.0;

/// Follows the solutions for the laws F₀^(1−τ) F^τ from τ = 0 to 1, each from the one before, by
/// steps in τ that double after a success and halve after a failure; `solve` finds a solution for a
/// law from a start.
///
/// The path may end before τ = 1 where solutions vanish in pairs; the status is then that of the last
/// failure.
pub(in crate::solver) fn continuation(
    law: &CoulombLaw,
    observe: &mut dyn FnMut(usize, &NewtonStep),
    mut solve: impl FnMut(&CoulombLaw, Option<&[f64]>) -> NewtonSolution,
) -> NewtonSolution {
    let mut history: Vec<NewtonStep> = Vec::new();
    let mut evaluations = 0;
    let mut at = |share: f64, start: Option<&[f64]>| {
        let mut found = solve(&law.softened(REFERENCE, share), start);
        for step in &mut found.history {
            step.law_share = share;
            observe(history.len(), step);
            history.push(*step);
        }
        evaluations += found.evaluations;
        found
    };
    let mut last = at(0.0, None);
    let (mut share, mut step) = (0.0, FIRST_STEP);
    while share < 1.0 && last.is_solution() {
        let target = f64::min(share + step, 1.0);
        let found = at(target, Some(&last.multiplier));
        if found.is_solution() {
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

/// Share of the springs in the next problem, and the nearest to one that is tried before the path counts as lost.
const FIRST_SHARE: f64 = 0.125;
const LAST_SHARE: f64 = 0.9;

/// Springs below this share of the body's own stiffness leave the body no further to go.
const SOFTEST: f64 = 1e-13;

/// Where springs of this share less carry this part of the load still, nothing else will.
const PATIENCE: f64 = 1e-4;
const STILL_CARRIED: f64 = 0.5;

/// Follows the solutions of the body on springs at its pins from springs as stiff as the body to none, each from the one before;
/// after each, Newton's method is tried without springs.
///
/// Springs bound what a motion does, so that every one of these problems is that of a body that is held, and the zones are found
/// before the motion matters. Where the load has no equilibrium the springs carry it to the end.
pub(super) fn softened(
    search: &Search<'_>,
    observe: &mut dyn FnMut(usize, &NewtonStep),
) -> NewtonSolution {
    let mut history: Vec<NewtonStep> = Vec::new();
    let mut evaluations = 0;
    let mut note = |found: &NewtonSolution| {
        for step in &found.history {
            observe(history.len(), step);
            history.push(*step);
        }
        evaluations += found.evaluations;
    };
    let mut last: Option<NewtonSolution> = None;
    let (mut springs, mut share) = (1.0, FIRST_SHARE);
    // The springs of each problem solved, and what they carry.
    let mut carried: Vec<(f64, f64)> = Vec::new();
    let mut free = None;
    while springs > SOFTEST {
        let dual = search.dual.on_springs(springs);
        let on_springs = Search {
            dual: &dual,
            bound: search.bound,
            local: search.local,
            start: last.as_ref().map(|found| found.multiplier.as_slice()),
        };
        let found = next(&on_springs);
        note(&found);
        if found.is_solution() {
            let without = search.from(found.multiplier.clone(), &mut |_, _| {});
            note(&without);
            if without.is_solution() {
                free = Some(without);
                break;
            }
            if let Some(balance) = &dual.balance {
                let now = balance.share_of_supports(dual.motion(&found.multiplier));
                let before = carried.iter().rfind(|(then, _)| springs <= PATIENCE * then);
                if before.is_some_and(|(_, before)| now > STILL_CARRIED * before) {
                    break;
                }
                carried.push((springs, now));
            }
            last = Some(found);
            share = (share * share).max(FIRST_SHARE);
            springs *= share;
        } else {
            share = share.sqrt();
            if last.is_none() || share > LAST_SHARE {
                break;
            }
            // From the last springs with which it went.
            springs = carried.last().map_or(springs, |(before, _)| before * share);
        }
    }
    // What springs hold is no answer.
    NewtonSolution {
        history,
        evaluations,
        ..free.unwrap_or_else(|| NewtonSolution::none(search.dual))
    }
}

/// The solution of the next problem: from that of the last or by relaxation from there; of the first, by any way.
fn next(search: &Search<'_>) -> NewtonSolution {
    let Some(start) = search.start else {
        return search.first();
    };
    let found = search.from(start.to_vec(), &mut |_, _| {});
    if found.is_solution() {
        found
    } else {
        search.relaxed(&mut |_, _| {})
    }
}

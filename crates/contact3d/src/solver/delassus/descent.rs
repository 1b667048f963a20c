//! Newton's method from easier problems.

use super::{
    Candidate,
    proximal::step,
    scaled::{MatrixForm, Scaled},
};
use crate::dual::LocalStiffness;

/// The first share of the diagonal, and by which share the next is smaller, of one descent after the other: others go by other points. A
/// whole diagonal leaves every contact nearly to itself.
const DESCENTS: [[f64; 2]; 5] = [
    [1.0, 0.56],
    [100.0, 0.56],
    [0.1, 0.56],
    [1.0, 0.32],
    [1.0, 0.8],
];

/// A share at which a proximal step on the right zones ends within rounding.
const LEAST_SHARE: f64 = 1e-9;

/// Steps in a row without a solution that end a descent: a nearby start may help the next once or twice, not for ever.
const MOST_LOST: usize = 4;

/// Proximal steps whose share of the diagonal falls: S + α diag S in place of S and h + α diag S λ in place of h, for the
/// last λ.
///
/// Steps of a large share have one solution that is easily found, and a fixed point of any of them solves the given problem. For a large
/// μ on a singular W a step of a small share alone is as hard as the problem itself, and its start nowhere near; here each starts where the one
/// before ended. Nothing proves that they lead to a solution: Coulomb's law is not monotone.
pub(super) fn solve(scaled: &Scaled<'_>, form: MatrixForm, tolerance: f64) -> Candidate {
    let mut best = Candidate::zero(scaled);
    let mut least = f64::INFINITY;
    let laws = scaled.laws();
    for [first, ratio] in DESCENTS {
        let mut found = Candidate {
            newton_steps: best.newton_steps,
            outer_steps: best.outer_steps,
            applications: best.applications,
            ..Candidate::zero(scaled)
        };
        let mut share = first;
        let mut lost = 0;
        while share >= LEAST_SHARE && least > tolerance && lost < MOST_LOST {
            let about = found.multiplier.clone();
            let dual = scaled.shifted(form, share, &about);
            let local = LocalStiffness::new(&dual);
            let is_solved = step(&dual, &local, &laws, Some(&about), &mut found);
            lost = if is_solved { 0 } else { lost + 1 };
            let error = scaled.worst_error(&found.multiplier);
            if error < least {
                least = error;
                best.multiplier.clone_from(&found.multiplier);
            }
            share *= ratio;
        }
        best = Candidate {
            multiplier: best.multiplier,
            ..found
        };
        if least <= tolerance {
            break;
        }
    }
    best
}

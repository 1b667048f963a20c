//! Newton's method on the problem itself, or by proximal steps.

use super::{
    Candidate,
    scaled::{MatrixForm, Scaled},
};
use crate::{
    dual::{ExplicitDual, LocalStiffness},
    solver::{
        NewtonSettings, PaneLaws,
        conditions::Bound,
        fixed_point::relative_change,
        newton::{natural_map::NaturalMap, newton_to_rounding, search::Search},
    },
};

/// Where a contact moves this many times further with the others than against them, W is singular as far as rounding can tell.
const SINGULAR: f64 = 1e7;

/// Shares of the diagonal that proximal steps add: the first, and the least.
const FIRST_SHARE: f64 = 1e-6;
const LEAST_SHARE: f64 = 1e-10;

/// A proximal step that leaves more of the error than this asks for a smaller share.
const SLOW: f64 = 0.1;

/// Most proximal steps, and those without progress that end them.
const MOST_STEPS: usize = 40;
const IDLE_STEPS: usize = 4;

/// Newton's method on the matrix in one of its forms.
///
/// A singular W leaves some forces undetermined and makes R' singular. Proximal steps solve for λ⁺ with S + α diag S in place of S
/// and h + α diag S λ in place of h: each has one isolated solution, a fixed point solves the given problem, and the error
/// falls by about α per step in all directions in which S is not zero (R. T. Rockafellar, *SIAM J. Control Optim.* 14 (1976) 877).
pub(super) fn solve(scaled: &Scaled<'_>, form: MatrixForm, tolerance: f64) -> Candidate {
    let mut found = Candidate::zero(scaled);
    let zero = found.multiplier.clone();
    if zero.is_empty() {
        return found;
    }
    let laws = scaled.laws();
    let exact = scaled.shifted(form, 0.0, &zero);
    let local = LocalStiffness::new(&exact);
    if local.mobility() < SINGULAR {
        step(&exact, &local, &laws, None, &mut found);
        if scaled.worst_error(&found.multiplier) <= tolerance {
            return found;
        }
    }
    drop((exact, local));
    let mut share = FIRST_SHARE;
    let mut error = scaled.worst_error(&found.multiplier);
    let mut idle = 0;
    for _ in 0..MOST_STEPS {
        let about = found.multiplier.clone();
        let dual = scaled.shifted(form, share, &about);
        let local = LocalStiffness::new(&dual);
        step(&dual, &local, &laws, Some(&about), &mut found);
        let next = scaled.worst_error(&found.multiplier);
        if next <= tolerance || !next.is_finite() {
            break;
        }
        if next > error {
            found.multiplier = about.clone();
        }
        if next > SLOW * error {
            share = (0.1 * share).max(LEAST_SHARE);
            idle += 1;
        } else {
            idle = 0;
        }
        if idle == IDLE_STEPS || relative_change(&found.multiplier, &about) == 0.0 && idle > 1 {
            break;
        }
        error = next.min(error);
    }
    found
}

/// One solve, by one way after the other; whether one of them led to a solution.
pub(super) fn step(
    dual: &ExplicitDual,
    local: &LocalStiffness,
    laws: &PaneLaws,
    start: Option<&[f64]>,
    found: &mut Candidate,
) -> bool {
    found.outer_steps += 1;
    let set = laws.feasible_set(None);
    let bound = Bound::of(laws, &set);
    let search = Search {
        dual,
        bound,
        local,
        start,
    };
    let map = NaturalMap::new(dual, bound);
    let mut best = f64::INFINITY;
    for way in search.ways() {
        let near = search.go(way, 0, |_, _| {});
        let settings = NewtonSettings::to_rounding(dual);
        let sharp = newton_to_rounding(&map, near.multiplier.clone(), &settings);
        found.newton_steps += near.history.len() + sharp.history.len();
        found.applications += near.evaluations + sharp.evaluations;
        let is_near = near.is_solution();
        let norm_at = |multiplier: &[f64]| map.evaluate(multiplier).norm;
        for candidate in [near.multiplier, sharp.multiplier] {
            let residual = norm_at(&candidate);
            if residual < best {
                best = residual;
                found.multiplier = candidate;
            }
        }
        if is_near {
            return true;
        }
    }
    false
}

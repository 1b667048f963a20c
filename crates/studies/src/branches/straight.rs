//! Loads and gaps that move along a straight line with the parameter.

use contact3d::{AssembledProblem, dual::ExplicitDual};

/// How far they may be from it, relative to the largest load; their own rounding is some ε.
const STRAIGHT: f64 = 1e-13;

/// Whether loads and gap of a problem lie on the line between two others, at a share of it.
pub(super) fn on_line(
    first: &AssembledProblem,
    second: &AssembledProblem,
    share: f64,
    between: &AssembledProblem,
) -> bool {
    let load = |problem: &AssembledProblem| problem.system().assembly.primal.load.clone();
    let held = |problem: &AssembledProblem| {
        let prescribed = problem.system().assembly.primal.dofs.prescribed.as_ref();
        prescribed.map_or_else(Vec::new, |held| held.as_flattened().to_vec())
    };
    let gap = |problem: &AssembledProblem| {
        let state = problem.contact_state();
        state
            .and_then(|state| state.interface.gap.clone())
            .unwrap_or_default()
    };
    let straight = |values: [Vec<f64>; 3]| {
        let [a, b, c] = values;
        let longest = a.len().max(b.len()).max(c.len());
        let at = |v: &[f64], i: usize| v.get(i).copied().unwrap_or(0.0);
        let size = [&a, &b]
            .into_iter()
            .flatten()
            .fold(0.0, |m, v| f64::max(m, v.abs()));
        (0..longest).all(|i| {
            let line = at(&a, i) + share * (at(&b, i) - at(&a, i));
            (at(&c, i) - line).abs() <= STRAIGHT * size
        })
    };
    straight([load(first), load(second), load(between)])
        && straight([held(first), held(second), held(between)])
        && straight([gap(first), gap(second), gap(between)])
}

/// h and the free slip at a share of the way between those of two problems.
pub(super) fn between(ends: &[ExplicitDual; 2], share: f64) -> ExplicitDual {
    let line = |a: f64, b: f64| a + share * (b - a);
    let mut dual = ends[0].clone();
    for (h, other) in dual.rhs.iter_mut().zip(&ends[1].rhs) {
        *h = line(*h, *other);
    }
    if let (Some(own), Some(other)) = (&mut dual.compliance, &ends[1].compliance) {
        let slips = own.slip_free.as_flattened_mut().iter_mut();
        for (u, other) in slips.zip(other.slip_free.as_flattened()) {
            *u = line(*u, *other);
        }
    }
    dual
}

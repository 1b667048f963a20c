//! The semismooth Newton method on the natural map, its starts, and its linearisation.

mod coefficient;
mod dense;
mod driver;
mod friction_graph;
pub(in crate::solver) mod iteration;
mod linearisation;
pub(in crate::solver) mod natural_map;
pub(in crate::solver) mod proximal;
mod relaxation;
mod system;
#[cfg(test)]
mod tests;

pub(in crate::solver) use dense::local_newton;
pub use iteration::NewtonSettings;
pub use linearisation::{Linearisation, contraction_of_mapping};

pub(in crate::solver) use driver::NewtonDriver;
pub(in crate::solver) use friction_graph::FrictionGraph;
use proximal::proximal_point;

use dense::{SWEEPS_PER_STEP, globalised_newton};
use natural_map::NaturalMap;

use super::{
    FeasibleSet, NewtonStep, PaneLaws, StopReason, conditions::Bound, pane_laws::coulomb_state,
};
use crate::{contact::CoulombLaw, dual::ExplicitDual};

/// The unknowns that Newton's method found and how they were reached.
#[derive(Debug, Clone)]
pub struct NewtonSolution {
    /// Why the method stopped.
    pub stop: StopReason,
    /// λ in Pa, `[n_multipliers]`, then the rigid motions α where there are some, `[n_unknowns]`.
    pub unknowns: Vec<f64>,
    /// Final ‖R‖ / ‖λ‖.
    pub residual: f64,
    /// One record per step.
    pub history: Vec<NewtonStep>,
    /// Applications of S: evaluations of R and sweeps of relaxation.
    pub evaluations: usize,
}

/// Solves the contact problem with Coulomb friction and F(u) at once, without an outer loop, by a
/// semismooth Newton method on the natural map ([`NaturalMap`]), from `start` or from λ = 0.
///
/// The admissible set moves with λ: g = max(z_ν, 0) and 𝓕 = 𝓕(u_t(λ)), and R' contains both
/// dependences.
///
/// For most of its steps a semismooth Newton method only looks for the zones: a pane on the wrong side of
/// a kink spoils the whole step, and ‖R‖ forbids it. Such errors are local, and sweeps of nonlinear
/// block Gauss–Seidel, each as cheap as one application of S, remove them; errors over many panes
/// are slow for the sweeps and easy for Newton's step. So the start and every trial step are
/// relaxed by a few sweeps (kept when ‖R‖ falls), as in nonsmooth Newton multigrid methods (C.
/// Gräser, R. Kornhuber, J. Comput. Math. 27 (2009) 1–44), and the zones settle in a few steps on
/// any mesh.
///
/// Steps are halved until the relaxed ‖R‖ decreases (the full step after 12 halvings). When the
/// best ‖R‖ has not halved in 10 steps, the method starts again without sweeps; when that stalls or
/// R' is singular, half a step of the mapping Ψ of HKL (one problem with frozen g and 𝓕) is taken
/// from the best iterate and marked in the history.
/// `observe` is called after every step with its number and record.
#[must_use]
pub fn newton(
    dual: &ExplicitDual,
    laws: &PaneLaws,
    law: &CoulombLaw,
    start: Option<&[f64]>,
    settings: &NewtonSettings,
    observe: impl FnMut(usize, &NewtonStep),
) -> NewtonSolution {
    let start = dual.unknowns(start.unwrap_or_default());
    let map = NaturalMap::new(dual, Bound::Coulomb(laws, law));
    let mut hidden_evaluations = 0;
    let mut safeguard = |unknowns: &mut [f64]| {
        // Ψ by relaxed steps alone.
        let state = coulomb_state(dual, laws, law, unknowns);
        let set = laws.feasible_set(Some(&state));
        let settings = NewtonSettings {
            least_steps: 1,
            ..NewtonSettings::to_rounding(dual)
        };
        let image = minimise_frozen(dual, &set, unknowns, &settings, |_, _| {});
        hidden_evaluations += image.evaluations;
        // Half of Ψ's step: Ψ may expand with a negative slope, where the mean of λ and Ψ(λ) is nearer to its fixed point.
        let pairs = unknowns.iter_mut().zip(&image.unknowns);
        pairs.for_each(|(l, next)| *l += 0.5 * (next - *l));
    };
    let mut found = globalised_newton(&map, start, settings, &mut safeguard, observe);
    found.evaluations += hidden_evaluations;
    found
}

/// Minimises ½ λᵀSλ − λᵀh over a frozen admissible set (Tresca friction) by the same Newton
/// method; sweeps of block relaxation, which always decrease the energy, are its safeguard.
#[must_use]
pub fn minimise_frozen(
    dual: &ExplicitDual,
    set: &FeasibleSet,
    start: &[f64],
    settings: &NewtonSettings,
    observe: impl FnMut(usize, &NewtonStep),
) -> NewtonSolution {
    // One safeguard step is all that a stall has: as many sweeps as five relaxed steps.
    let sweeps = 5 * SWEEPS_PER_STEP;
    let map = NaturalMap::new(dual, Bound::Given(set));
    let mut first = dual.unknowns(start);
    set.project(&mut first);
    let mut relaxation_applications = 0;
    let mut safeguard = |unknowns: &mut [f64]| {
        set.project(unknowns);
        map.relax(unknowns, sweeps);
        relaxation_applications += sweeps + 1;
    };
    let mut found = globalised_newton(&map, first, settings, &mut safeguard, observe);
    found.evaluations += relaxation_applications;
    found
}

impl NewtonSolution {
    /// No solution: λ = 0, and no step.
    pub(in crate::solver) fn failed(dual: &ExplicitDual) -> Self {
        Self {
            stop: StopReason::MaxSteps,
            unknowns: dual.unknowns(&[]),
            residual: f64::INFINITY,
            history: Vec::new(),
            evaluations: 0,
        }
    }

    /// A later solution with the steps and evaluations of both.
    pub(in crate::solver) fn merged_with(self, next: Self) -> Self {
        Self {
            history: [self.history, next.history].concat(),
            evaluations: self.evaluations + next.evaluations,
            ..next
        }
    }
}

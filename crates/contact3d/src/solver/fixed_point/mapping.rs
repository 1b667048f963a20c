//! The mapping Ψ whose fixed points are the discrete solutions.

use crate::{
    contact::CoulombLaw,
    dual::{ExplicitDual, LocalStiffness},
    linalg::{difference, norm},
    solver::{
        CoulombState, PaneLaws,
        conditions::Bound,
        newton::{NewtonSettings, NewtonSolution, NewtonStatus, search::Search},
        pane_laws::coulomb_state,
    },
};

/// One value of the mapping Ψ whose fixed points are the discrete solutions (HKL §3).
#[derive(Debug, Clone)]
pub struct MappingValue {
    /// How the inner problem ended; [`NewtonStatus::RoundingLimit`] is as good as it gets.
    pub status: NewtonStatus,
    /// Ψ(λ), `[n_multipliers]`, in Pa.
    pub multiplier: Vec<f64>,
    /// ‖Ψ(λ) − λ‖ / ‖λ‖, and 0 when both vanish.
    pub relative_change: f64,
    /// Final ‖R‖ / ‖λ‖ of the inner problem.
    pub inner_residual: f64,
    /// Steps of Newton's method in the inner problem.
    pub inner_steps: usize,
    /// Applications of S.
    pub evaluations: usize,
}

/// Evaluates Ψ once: freezes g, the slip bound of λ_ν, and 𝓕 = 𝓕(u_t(λ)) and solves that problem to rounding.
///
/// A multiplier is a solution of the contact problem with Coulomb friction and F(u) exactly when
/// it is a fixed point, so a small change certifies the answer of any other method.
#[must_use]
pub fn evaluate(
    dual: &ExplicitDual,
    local: &LocalStiffness,
    laws: &PaneLaws,
    law: &CoulombLaw,
    multiplier: &[f64],
) -> MappingValue {
    let state = coulomb_state(dual, laws, law, multiplier);
    evaluate_at(dual, local, laws, &state, multiplier)
}

/// Evaluates Ψ at any slip bound and friction, the frozen problem of (φ, g), from a multiplier nearby; its change is the
/// distance to that multiplier.
#[must_use]
pub fn evaluate_at(
    dual: &ExplicitDual,
    local: &LocalStiffness,
    laws: &PaneLaws,
    state: &CoulombState,
    multiplier: &[f64],
) -> MappingValue {
    let set = laws.feasible_set(Some(state));
    let search = Search {
        dual,
        bound: Bound::Frozen(&set),
        local,
        start: Some(multiplier),
    };
    MappingValue::new(
        search.minimise(&set, &NewtonSettings::to_rounding(dual)),
        dual.multipliers(multiplier),
    )
}

impl MappingValue {
    fn new(inner: NewtonSolution, multiplier: &[f64]) -> Self {
        Self {
            status: inner.status,
            // The rigid motions of a body that floats stay aside.
            relative_change: match norm(&difference(multiplier, &inner.multiplier)) {
                0.0 => 0.0,
                change => change / norm(multiplier),
            },
            multiplier: inner.multiplier,
            inner_residual: inner.residual,
            inner_steps: inner.history.len(),
            evaluations: inner.evaluations,
        }
    }
}

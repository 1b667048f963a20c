use super::{
    ContactState, CoulombState, NewtonSettings, NewtonSolution, NewtonStatus, conditions::Bound,
    newton::minimise_frozen_in, search::Search,
};
use crate::{
    contact::{CoulombLaw, FrictionField},
    dual::{ExplicitDual, LocalStiffness},
    linalg::{difference, norm},
};

/// One value of the mapping Ψ whose fixed points are the discrete solutions (HKL §3).
#[derive(Debug, Clone)]
pub struct MappingValue {
    /// How the inner problem ended; [`NewtonStatus::RoundingLimit`] is as good as it gets.
    pub status: NewtonStatus,
    /// Ψ(λ), `[3 n_panes]`, in Pa.
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
    contact: &ContactState<'_>,
    law: &CoulombLaw,
    multiplier: &[f64],
) -> MappingValue {
    let state = coulomb_state(dual, contact, law, multiplier);
    let set = contact.feasible_set(Some(&state));
    let search = Search {
        dual,
        bound: Bound::Frozen(&set),
        local,
        start: Some(multiplier),
    };
    MappingValue::new(search.minimise(&set, &to_rounding(dual)), multiplier)
}

/// [`evaluate`] by relaxed Newton steps alone.
pub(super) fn evaluate_by_relaxation(
    dual: &ExplicitDual,
    contact: &ContactState<'_>,
    law: &CoulombLaw,
    multiplier: &[f64],
) -> MappingValue {
    let state = coulomb_state(dual, contact, law, multiplier);
    let set = contact.feasible_set(Some(&state));
    // One step at least, so that a start already within the tolerance is measured and not believed.
    let inner = minimise_frozen_in(dual, &set, multiplier, &to_rounding(dual), 1, |_, _| {});
    MappingValue::new(inner, multiplier)
}

fn to_rounding(dual: &ExplicitDual) -> NewtonSettings {
    NewtonSettings {
        tolerance: dual.rounding(),
        ..NewtonSettings::default()
    }
}

impl MappingValue {
    fn new(inner: NewtonSolution, multiplier: &[f64]) -> Self {
        Self {
            status: inner.status,
            relative_change: match norm(&difference(&inner.multiplier, multiplier)) {
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

/// (|u_t1|, |u_t2|) at the contact nodes for a multiplier; empty unless the law follows the slip.
pub(super) fn slip_of(dual: &ExplicitDual, multiplier: &[f64]) -> Vec<[f64; 2]> {
    let displacement = dual.tangential_displacement(multiplier);
    displacement.iter().map(|u| u.map(f64::abs)).collect()
}

/// The state of friction that a multiplier itself makes: the slip bound g of λ_ν and 𝓕 = 𝓕(u_t(λ)).
#[must_use]
pub fn coulomb_state(
    dual: &ExplicitDual,
    contact: &ContactState<'_>,
    law: &CoulombLaw,
    multiplier: &[f64],
) -> CoulombState {
    let (normal, _) = dual.layout.split(multiplier);
    CoulombState {
        slip_bound: normal.iter().map(|l| law.slip_bound(l.max(0.0))).collect(),
        friction: FrictionField::new(law, contact.surface, &slip_of(dual, multiplier)),
    }
}

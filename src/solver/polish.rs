use super::{
    NewtonSettings, NewtonSolution,
    natural_map::{Bound, NaturalMap},
    newton::newton_in,
    solve::Problem,
};
use crate::{contact::CoulombLaw, dual::ExplicitDual};

/// Violations of contact and friction below this share are left as they are.
const STRICT: f64 = 1e-11;

/// Most rounds; each wins the digits that the conditioning of A leaves.
const MOST_ROUNDS: usize = 3;

/// Most Newton steps in one round: one or two, more where the correction moves panes between zones.
const STEPS: usize = 20;

/// An answer and the dual problem with h and slip corrected at it.
pub(super) struct Polished {
    pub(super) found: NewtonSolution,
    pub(super) dual: ExplicitDual,
    /// u in m, to rounding.
    pub(super) displacement: Vec<f64>,
    violation: f64,
}

impl Problem<'_> {
    /// Refines the answer of Newton's method where ‖R‖ ≤ ε ‖λ‖ hides violations: where pressures
    /// hardly depend on displacements (slender bodies), or friction along one axis is a small part of
    /// ‖λ‖.
    ///
    /// In each round u = A⁻¹(l − Bᵀλ) is solved to rounding, h and the slip are corrected so that
    /// they belong to it, and Newton's method takes a step or two from λ. A round that does not
    /// lessen the violation is forgotten.
    pub(super) fn polished(
        &self,
        dual: &ExplicitDual,
        law: &CoulombLaw,
        found: NewtonSolution,
    ) -> Polished {
        let goal = STRICT.max(10.0 * self.settings.epsilon());
        let settings = NewtonSettings {
            tolerance: dual.rounding(),
            max_steps: STEPS,
        };
        let original = dual.clone();
        let mut best = self.corrected(dual, law, found);
        if best.violation <= goal {
            best.dual = original;
            return best;
        }
        for _ in 0..MOST_ROUNDS {
            let start = Some(best.found.multiplier.as_slice());
            let mut next = newton_in(
                &best.dual,
                self.contact,
                law,
                start,
                &settings,
                1,
                |_, _| {},
            );
            next.history = [best.found.history.clone(), next.history].concat();
            next.evaluations += best.found.evaluations;
            next.status = best.found.status;
            let next = self.corrected(&best.dual, law, next);
            if next.violation.is_nan() || next.violation > 0.5 * best.violation {
                break;
            }
            best = next;
            if best.violation <= goal {
                break;
            }
        }
        best
    }

    /// The answer as it is, with its u.
    pub(super) fn unpolished(
        &self,
        dual: &ExplicitDual,
        law: &CoulombLaw,
        found: NewtonSolution,
    ) -> Polished {
        Polished {
            dual: dual.clone(),
            ..self.corrected(dual, law, found)
        }
    }

    /// The answer with its u, and the dual problem that belongs to it.
    fn corrected(&self, dual: &ExplicitDual, law: &CoulombLaw, found: NewtonSolution) -> Polished {
        let (surface, interface) = (self.contact.surface, self.contact.interface);
        let displacement = self
            .dual
            .refined_displacement(self.assembly, &found.multiplier);
        let closing = self.dual.closing(&displacement, surface, interface);
        let dual = dual.corrected(
            &found.multiplier,
            &displacement,
            &closing,
            surface,
            &interface.frame,
            &self.assembly.primal.dofs,
        );
        let largest = displacement
            .iter()
            .fold(0.0_f64, |most, u| most.max(u.abs()));
        let map = NaturalMap::new(&dual, Bound::Coulomb(self.contact, law));
        Polished {
            violation: map.violation(&found.multiplier, &surface.pane_area, largest),
            found,
            dual,
            displacement,
        }
    }
}

impl NaturalMap<'_> {
    /// How far λ is from satisfying the laws pane by pane: the larger of |R_i / ρ_i| over the area
    /// of the pane and the largest displacement, and of |𝓕⁻¹ R_t| over the largest pressure.
    fn violation(&self, multiplier: &[f64], area: &[f64], displacement: f64) -> f64 {
        let evaluation = self.evaluate(multiplier);
        if evaluation.norm.is_nan() {
            return f64::NAN;
        }
        let m = area.len();
        let pressure = multiplier[..m].iter().copied().fold(0.0, f64::max);
        let mut violation = 0.0_f64;
        for (i, residual) in evaluation.residual.iter().enumerate() {
            let pane = if i < m { i } else { (i - m) / 2 };
            let rho = self.steplengths[i];
            if rho > 0.0 && displacement > 0.0 {
                violation = violation.max(residual.abs() / (rho * area[pane] * displacement));
            }
            if i >= m && pressure > 0.0 {
                let inverse = evaluation.panes[pane].inverse[(i - m) % 2];
                violation = violation.max(residual.abs() * inverse / pressure);
            }
        }
        violation
    }
}

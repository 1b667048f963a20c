//! The mapping of successive approximations, and how iterations of it fail: by cycles and by stalling.

use std::collections::VecDeque;

use crate::{
    contact::CoulombLaw,
    dual::{ExplicitDual, LocalStiffness},
    linalg::{difference, norm, ratio},
    solver::{
        PaneLaws,
        conditions::Bound,
        newton::{NewtonDriver, NewtonSettings},
        pane_laws::coulomb_state,
    },
};

/// One value of the mapping Ψ whose fixed points are the discrete solutions (HKL §3).
#[derive(Debug, Clone)]
pub struct MappingValue {
    /// Ψ(λ) in Pa and the rigid motions that belong to it, `[n_unknowns]`.
    pub unknowns: Vec<f64>,
    /// ‖Ψ(λ) − λ‖ / ‖λ‖, and 0 when both vanish; infinite where the frozen problem was not solved.
    pub relative_change: f64,
    /// Applications of S.
    pub evaluations: usize,
}

/// Evaluates Ψ once: freezes g, the slip bound of λ_ν, and 𝓕 = 𝓕(u_t(λ)) and solves that problem to rounding.
///
/// A multiplier is a solution of the contact problem with Coulomb friction and F(u) exactly when
/// it is a fixed point, so a small change certifies the solution of any other method.
#[must_use]
pub fn evaluate(
    dual: &ExplicitDual,
    local: &LocalStiffness,
    laws: &PaneLaws,
    law: &CoulombLaw,
    unknowns: &[f64],
) -> MappingValue {
    let state = coulomb_state(dual, laws, law, unknowns);
    let set = laws.feasible_set(Some(&state));
    let driver = NewtonDriver::new(dual, local, Bound::Given(&set), Some(unknowns));
    let inner = driver.minimise(&set, &NewtonSettings::to_rounding(dual));
    MappingValue {
        // The rigid motions of a body that floats stay aside.
        relative_change: match inner.stop.is_solution() {
            true => relative_change(&dual.stresses(unknowns), &dual.stresses(&inner.unknowns)),
            false => f64::INFINITY,
        },
        unknowns: inner.unknowns,
        evaluations: inner.evaluations,
    }
}

/// Longest period that is looked for, in steps: so many iterates are kept.
const CYCLE_LONGEST_PERIOD: usize = 8;

/// A return this much closer than the steps of the round is a cycle: linear convergence that slow
/// would need a million steps for one digit.
const CYCLE_CLOSED: f64 = 1e-6;

/// Remembers the last iterates of successive approximations, to tell a cycle from slow convergence.
#[derive(Debug, Default)]
pub(in crate::solver) struct CycleDetector {
    /// The latest last.
    recent: VecDeque<Vec<f64>>,
    /// ‖λ⁽ᵏ⁺¹⁾ − λ⁽ᵏ⁾‖ / ‖λ⁽ᵏ⁺¹⁾‖, likewise.
    changes: VecDeque<f64>,
}

impl CycleDetector {
    /// Takes up an iterate and its relative change; returns the period of the cycle that it closes.
    pub(in crate::solver) fn closes(&mut self, multiplier: &[f64], change: f64) -> Option<usize> {
        self.changes.push_back(change);
        let period = (2..=self.recent.len()).find(|&period| {
            let before = &self.recent[self.recent.len() - period];
            let round = self.changes.range(self.changes.len() - period..);
            let least = round.copied().fold(f64::INFINITY, f64::min);
            relative_change(multiplier, before) <= CYCLE_CLOSED * least
        });
        self.recent.push_back(multiplier.to_vec());
        if self.recent.len() > CYCLE_LONGEST_PERIOD {
            self.recent.pop_front();
            self.changes.pop_front();
        }
        period.filter(|_| change > 0.0)
    }
}

/// ‖λ' − λ‖ / ‖λ'‖, and 0 when both vanish.
pub(in crate::solver) fn relative_change(next: &[f64], last: &[f64]) -> f64 {
    ratio(norm(&difference(next, last)), norm(next))
}

/// Steps in which changes must halve; a contraction of 0.993 a step does that.
const STALL_STEPS: usize = 100;

/// A larger change is not rounding: 1e-8 is left where the body's rigid motion takes half the digits.
const STALL_LARGEST_CHANGE: f64 = 1e-8;

/// Watches the changes of successive approximations whose inner problems are solved to rounding.
#[derive(Debug, Default)]
pub(super) struct Stall {
    /// The last change that was half the one before it in this row, and the steps since.
    best: Option<f64>,
    idle: usize,
}

impl Stall {
    /// Whether small changes have not halved in [`STALL_STEPS`] steps, all with inner problems solved to rounding.
    pub(super) fn is_at_rounding(&mut self, change: f64, inner_at_rounding: bool) -> bool {
        let falls = self.best.is_none_or(|best| change <= 0.5 * best);
        if falls || !inner_at_rounding || change > STALL_LARGEST_CHANGE {
            self.best = Some(self.best.map_or(change, |best| best.min(change)));
            self.idle = 0;
            return false;
        }
        self.idle += 1;
        self.idle >= STALL_STEPS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of steps until a cycle is seen in x ← f(x), and its period.
    fn watch(mut x: f64, f: impl Fn(f64) -> f64) -> Option<(usize, usize)> {
        let mut detector = CycleDetector::default();
        (0..200).find_map(|k| {
            let next = f(x);
            let period = detector.closes(&[next], relative_change(&[next], &[x]));
            x = next;
            period.map(|period| (k, period))
        })
    }

    #[test]
    fn cycles_are_found_with_their_period() {
        assert_eq!(watch(0.3, |x| 1.0 - x).map(|(_, period)| period), Some(2));
        // The logistic map at 3.5 has a stable cycle of four.
        let logistic = |x: f64| 3.5 * x * (1.0 - x);
        assert_eq!(watch(0.3, logistic).map(|(_, period)| period), Some(4));
    }

    #[test]
    fn slow_convergence_is_no_cycle() {
        for factor in [-0.999, -0.5, 0.5, 0.999] {
            assert_eq!(watch(0.3, |x| 1.0 + factor * (x - 1.0)), None, "{factor}");
        }
        assert_eq!(watch(1.0, |x| x), None);
    }

    #[test]
    fn noise_is_seen_and_slow_convergence_is_not_noise() {
        let mut noise = Stall::default();
        let at =
            (0..).position(|k| noise.is_at_rounding(if k % 2 == 0 { 1e-10 } else { 2e-10 }, true));
        assert_eq!(at, Some(STALL_STEPS));
        let mut slow = Stall::default();
        assert!((0..2000).all(|k| !slow.is_at_rounding(1e-9 * 0.99_f64.powi(k), true)));
        let mut large = Stall::default();
        assert!((0..2000).all(|_| !large.is_at_rounding(1e-3, true)));
        let mut loose = Stall::default();
        assert!((0..2000).all(|_| !loose.is_at_rounding(1e-10, false)));
    }
}

//! Telling a cycle from slow convergence.

use std::collections::VecDeque;

use crate::linalg::norm;

/// Longest period that is looked for.
const LONGEST: usize = 8;

/// A return this much closer than the steps of the round is a cycle: linear convergence that slow
/// would need a million steps for one digit.
const CLOSED: f64 = 1e-6;

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
            relative_change(multiplier, before) <= CLOSED * least
        });
        self.recent.push_back(multiplier.to_vec());
        if self.recent.len() > LONGEST {
            self.recent.pop_front();
            self.changes.pop_front();
        }
        period.filter(|_| change > 0.0)
    }
}

/// ‖λ' − λ‖ / ‖λ'‖, and 0 when both vanish.
pub(super) fn relative_change(next: &[f64], last: &[f64]) -> f64 {
    let difference: Vec<f64> = next.iter().zip(last).map(|(a, b)| a - b).collect();
    match (norm(&difference), norm(next)) {
        (0.0, _) => 0.0,
        (difference, size) => difference / size,
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
}

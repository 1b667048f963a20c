//! Solves with A: its factor, and refinement or conjugate gradients about it.

use super::Assembly;
use crate::linalg::{CgSolution, Doubled, Precision, conjugate_gradients, norm};

/// What conjugate gradients leave of a correction at most, where the factor is in single precision: after two steps or so.
pub(super) const CG_LEFT: f64 = 1e-8;

impl Assembly {
    /// The displacement A⁻¹l over the free degrees of freedom in m: the body without contact.
    #[must_use]
    pub fn unconstrained(&self) -> Vec<f64> {
        self.solve(&self.primal.load)
    }

    /// The displacement A⁻¹f of nodal forces f in N over the free degrees of freedom, in m.
    #[must_use]
    pub fn solve(&self, forces: &[f64]) -> Vec<f64> {
        match self.factor.precision() {
            Precision::Double => self.solve_once(forces),
            Precision::Single => self.solve_refined(forces, None, f64::EPSILON).value,
        }
    }

    fn solve_once(&self, forces: &[f64]) -> Vec<f64> {
        let mut displacement = forces.to_vec();
        self.factor.solve_in_place(&mut displacement);
        displacement
    }

    /// A⁻¹f for several f but for a `share` of each, by conjugate gradients that share the reading of the factor.
    pub(crate) fn solve_several(&self, forces: &[Vec<f64>], share: f64) -> Vec<Vec<f64>> {
        let forces: Vec<&[f64]> = forces.iter().map(Vec::as_slice).collect();
        let a = self.primal.invertible();
        let solved = conjugate_gradients(a, &self.factor, &forces, share, 0.0);
        solved.into_iter().map(|solved| solved.solution).collect()
    }

    /// A⁻¹f by conjugate gradients, but for a share of it or a length.
    pub(super) fn by_gradients(&self, forces: &[f64], share: f64, length: f64) -> CgSolution {
        let a = self.primal.invertible();
        conjugate_gradients(a, &self.factor, &[forces], share, length).remove(0)
    }

    /// A⁻¹f from a start, or from zero, refined with residuals in twice the working precision until the
    /// corrections no longer fall, or are below `target` ‖u‖: accurate while ε cond(A) < 1
    /// (N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, SIAM 2002, theorem 12.1).
    pub(crate) fn solve_refined(
        &self,
        forces: &[f64],
        start: Option<&Doubled>,
        target: f64,
    ) -> Doubled {
        let mut displacement = match start {
            Some(start) => start.clone(),
            None => Doubled::from(vec![0.0; forces.len()]),
        };
        let mut last = f64::INFINITY;
        // Each of six refinements wins at least the digits that cond(A) leaves.
        for _ in 0..=6 {
            let whole = norm(&displacement.value);
            let residual = match whole {
                0.0 => forces.to_vec(),
                _ => self
                    .primal
                    .invertible()
                    .symmetric_residual(&displacement, forces),
            };
            let (correction, left) = self.correction(&residual, whole, target);
            let size = norm(&correction);
            // A first correction of no more than rounding changes nothing; NaN ends here too.
            if !(size > 0.0 && size < 0.5 * last) {
                break;
            }
            // What the next correction would be: those of a factor in double precision fall by one factor, ε cond(A).
            let next = match left {
                Some(left) => left * size,
                None if whole == 0.0 => f64::INFINITY,
                None => size * size / if last.is_finite() { last } else { whole },
            };
            displacement.add(&correction);
            if whole > 0.0 {
                last = size;
            }
            if next <= target * whole.max(size) {
                break;
            }
        }
        displacement
    }

    /// A⁻¹r for the residual r of a displacement of length `whole`, and the share of it that is left, where that is known.
    fn correction(&self, residual: &[f64], whole: f64, target: f64) -> (Vec<f64>, Option<f64>) {
        match self.factor.precision() {
            Precision::Double => (self.solve_once(residual), None),
            Precision::Single => {
                let least = if whole > 0.0 { 0.0 } else { target };
                let (share, length) = (CG_LEFT.max(least), target * whole);
                let solved = self.by_gradients(residual, share, length);
                let left = solved.left();
                (solved.solution, Some(left))
            }
        }
    }
}

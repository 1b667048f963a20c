//! Solves with A: its factor, and refinement or conjugate gradients about it.

use faer::{Mat, MatMut, Par, linalg::triangular_inverse::invert_lower_triangular};

use super::{Assembly, ExplicitDual};
use crate::linalg::{
    CgSolution, DenseCholesky, Doubled, Precision, StoppingRule, conjugate_gradients, norm,
};

/// Steps of iterative refinement; each wins at least the digits that cond(A) leaves.
const MOST_REFINEMENTS: usize = 6;

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
        let accuracy = StoppingRule { share, length: 0.0 };
        let a = self.primal.invertible();
        let solved = conjugate_gradients(a, &self.factor, &forces, accuracy);
        solved.into_iter().map(|solved| solved.solution).collect()
    }

    /// A⁻¹f by conjugate gradients.
    pub(super) fn by_gradients(&self, forces: &[f64], accuracy: StoppingRule) -> CgSolution {
        let a = self.primal.invertible();
        conjugate_gradients(a, &self.factor, &[forces], accuracy).remove(0)
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
        for _ in 0..=MOST_REFINEMENTS {
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
                let solved = self.by_gradients(residual, StoppingRule { share, length });
                let left = solved.left();
                (solved.solution, Some(left))
            }
        }
    }
}

/// LLᵀ = D S D + shift for D = diag(1/√S_ii) over the components whose rows do not vanish.
#[derive(Debug, Clone)]
pub(super) struct StiffnessFactor {
    /// Those components, ascending.
    pub(super) kept: Vec<usize>,
    /// 1/√S_ii of them.
    pub(super) scale: Vec<f64>,
    /// `None` of numbers that are not finite.
    factor: Option<DenseCholesky>,
}

impl StiffnessFactor {
    /// A third of n³ operations for n multipliers.
    pub(super) fn new(dual: &ExplicitDual) -> Self {
        let (kept, scale) = units(dual);
        Self {
            factor: DenseCholesky::shifted(&unit_diagonal(dual, &kept, &scale)),
            kept,
            scale,
        }
    }

    /// S⁻¹h in Pa for h in m³ with the components before one: all, or the normal ones. The others are zero.
    pub(super) fn solve(&self, rhs: &[f64], end: usize) -> Vec<f64> {
        let count = self.kept.partition_point(|&j| j < end);
        let scaled = (0..count).map(|i| self.scale[i] * rhs[self.kept[i]]);
        let mut x: Vec<f64> = scaled.collect();
        match &self.factor {
            None => x.fill(f64::NAN),
            Some(factor) => factor.solve(&mut x),
        }
        let mut solution = vec![0.0; rhs.len()];
        for (i, x) in x.iter().enumerate() {
            solution[self.kept[i]] = self.scale[i] * x;
        }
        solution
    }

    /// The diagonal of (LLᵀ)⁻¹.
    pub(super) fn inverse_diagonal(&self) -> Vec<f64> {
        match &self.factor {
            None => vec![f64::NAN; self.kept.len()],
            Some(factor) => inverse_diagonal(factor),
        }
    }
}

/// The components whose rows of S do not vanish, and 1/√S_ii of those.
pub(super) fn units(dual: &ExplicitDual) -> (Vec<usize>, Vec<f64>) {
    let kept = (0..dual.dimension()).filter(|&j| dual.diagonal(j) > 0.0);
    kept.map(|j| (j, dual.diagonal(j).sqrt().recip())).unzip()
}

/// D S D over some components.
pub(super) fn unit_diagonal(dual: &ExplicitDual, kept: &[usize], scale: &[f64]) -> Mat<f64> {
    Mat::from_fn(kept.len(), kept.len(), |i, j| {
        scale[i] * dual.column(kept[j])[kept[i]] * scale[j]
    })
}

/// The diagonal of (LLᵀ)⁻¹: squared lengths of the columns of L⁻¹.
fn inverse_diagonal(factor: &DenseCholesky) -> Vec<f64> {
    let n = factor.lower().nrows();
    let mut inverse = Mat::<f64>::zeros(n, n);
    invert_lower_triangular(
        inverse.as_mut() as MatMut<'_, f64>,
        factor.lower(),
        Par::Seq,
    );
    (0..n)
        .map(|j| (j..n).map(|i| inverse[(i, j)].powi(2)).sum())
        .collect()
}

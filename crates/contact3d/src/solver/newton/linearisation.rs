//! The derivative of the natural map at a solution: sign, sensitivity.

use faer::{Mat, MatRef, prelude::Solve};

use super::{contraction::moving_part, local_mapping::NEAR_FOLD, natural_map::NaturalMap};
use crate::{
    dual::ExplicitDual,
    linalg::{distance_to_one, largest_eigenvalue, norm, spectral_radius, transpositions},
    solver::{FeasibleSet, PaneLaws, conditions::Bound, coulomb_state},
};

/// The generalised derivative R' of the natural map R(λ) = λ − P(λ − ρ (S λ − h)) at some λ.
///
/// R' has no unit, since λ and R are stresses. det R' > 0 where the solution is a strong one that
/// follows small changes of the data; where several solutions exist, some have det R' < 0 (the
/// indices of all solutions add up to 1), and det R' = 0 where two of them meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearisation {
    /// ‖R(λ)‖ / ‖λ‖, and 0 for 0/0.
    pub residual: f64,
    /// Sign of det R': 1, −1, or 0 for a singular R'.
    pub determinant: i8,
    /// ‖R'⁻¹‖₂: how much a residual R moves λ; infinite for a singular R'.
    pub sensitivity: f64,
    /// Spectral radius of Ψ' for the mapping Ψ of HKL: successive approximations converge to the solution from nearby where it is
    /// below 1; 0 without Coulomb friction, infinite where the problem with frozen friction is singular.
    pub contraction: f64,
    /// The least |1 − μ| over the eigenvalues μ of Ψ', as [`super::LocalMapping`] has it; 1 without Coulomb friction.
    pub fold_distance: f64,
}

impl Linearisation {
    /// Whether det R' = 0 is near, and so perhaps another solution.
    #[must_use]
    pub fn is_near_fold(&self) -> bool {
        self.fold_distance < NEAR_FOLD
    }

    /// ‖R(λ)‖ / ‖λ‖ alone, for the contact problem of any law.
    #[must_use]
    pub(crate) fn residual_of(dual: &ExplicitDual, laws: &PaneLaws, unknowns: &[f64]) -> f64 {
        let frozen = laws.feasible_set(None);
        let map = NaturalMap::new(dual, bound(laws, &frozen));
        relative(map.evaluate(unknowns).norm, dual.multipliers(unknowns))
    }

    /// Linearises the contact problem of any law at λ, `[n_multipliers]` in Pa, followed by the rigid motions of a body that floats.
    #[must_use]
    pub fn new(dual: &ExplicitDual, laws: &PaneLaws, unknowns: &[f64]) -> Self {
        let frozen = laws.feasible_set(None);
        let map = NaturalMap::new(dual, bound(laws, &frozen));
        let evaluation = map.evaluate(unknowns);
        let matrix = map.derivative(&evaluation);
        let (n, n_multipliers) = (unknowns.len(), dual.dimension());
        let lu = MatRef::from_column_major_slice(&matrix, n, n).partial_piv_lu();
        let pivots: Vec<f64> = (0..n).map(|i| lu.U()[(i, i)]).collect();
        let (permutation, _) = lu.P().arrays();
        // Each row of the balance turns the sign of what is left after its motion is eliminated.
        let turned = n - n_multipliers;
        let negative = pivots.iter().filter(|p| **p < 0.0).count();
        let negative = negative + transpositions(permutation) + turned;
        let singular = pivots.iter().any(|p| *p == 0.0 || !p.is_finite());
        // ‖R'⁻¹‖² is the largest eigenvalue of R'⁻¹R'⁻ᵀ; of its rows and columns of λ where the body floats.
        let inverse_square = |v: &[f64]| {
            let mut x = Mat::from_fn(n, 1, |i, _| v.get(i).copied().unwrap_or(0.0));
            lu.solve_transpose_in_place(x.as_mut());
            (n_multipliers..n).for_each(|i| x[(i, 0)] = 0.0);
            lu.solve_in_place(x.as_mut());
            (0..n_multipliers).map(|i| x[(i, 0)]).collect()
        };
        let [contraction, fold_distance] = match laws.coulomb() {
            None => [0.0, 1.0],
            Some(law) => {
                let state = coulomb_state(dual, laws, law, unknowns);
                let set = laws.feasible_set(Some(&state));
                let map = NaturalMap::new(dual, Bound::Frozen(&set));
                let frozen = map.derivative(&map.evaluate(unknowns));
                moving_part(&frozen, &matrix, n).map_or([f64::INFINITY, 0.0], |moving| {
                    [spectral_radius(&moving), distance_to_one(&moving).min(1.0)]
                })
            }
        };
        Self {
            residual: relative(evaluation.norm, dual.multipliers(unknowns)),
            determinant: match (singular, negative % 2) {
                (true, _) => 0,
                (false, 0) => 1,
                (false, _) => -1,
            },
            sensitivity: if singular {
                f64::INFINITY
            } else {
                largest_eigenvalue(n_multipliers, inverse_square).sqrt()
            },
            contraction,
            fold_distance,
        }
    }
}

/// What moves the ellipses: the law of the scene, or nothing.
fn bound<'a>(laws: &'a PaneLaws, frozen: &'a FeasibleSet<'a>) -> Bound<'a> {
    match laws.coulomb() {
        Some(law) => Bound::Coulomb(laws, law),
        None => Bound::Frozen(frozen),
    }
}

fn relative(residual: f64, multiplier: &[f64]) -> f64 {
    match residual {
        0.0 => 0.0,
        residual => residual / norm(multiplier),
    }
}

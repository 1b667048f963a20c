//! The derivative of the mapping Ψ at a solution: spectral radius, determinant, distance from a fold.

use faer::{Mat, MatRef, prelude::Solve};

use super::natural_map::NaturalMap;
use crate::{
    contact::CoulombLaw,
    dual::ExplicitDual,
    linalg::{
        DenseLu, distance_to_one, dot, figures_by_products, largest_eigenvalue, least_modulus,
        norm, product, spectral_radius, transpositions,
    },
    solver::{LocalMapping, PaneLaws, conditions::Bound, coulomb_state, solution::NEAR_FOLD},
};

/// The generalised derivative R' of the natural map at some λ.
///
/// R' has no unit, since λ and R are stresses. det R' > 0 where the solution is a strong one that
/// follows small changes of the data; where several solutions exist, some have det R' < 0 (the
/// indices of all solutions add up to 1), and det R' = 0 where two of them meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linearisation {
    /// ‖R(λ)‖ / ‖λ‖, and 0 for 0/0.
    pub residual: f64,
    /// Sign of det R': 1, −1, or 0 for a singular R'.
    pub determinant_sign: i8,
    /// ‖R'⁻¹‖₂: how much a residual R moves λ; infinite for a singular R'.
    pub sensitivity: f64,
    /// Spectral radius of Ψ' for the mapping Ψ of HKL: successive approximations converge to the solution from nearby where it is
    /// below 1; 0 without Coulomb friction, infinite where the problem with frozen friction is singular.
    pub contraction: f64,
    /// The least |1 − μ| over the eigenvalues μ of Ψ', as [`crate::solver::LocalMapping`] has it; 1 without Coulomb friction.
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
    pub fn residual_of(dual: &ExplicitDual, laws: &PaneLaws, unknowns: &[f64]) -> f64 {
        let frozen = laws.feasible_set(None);
        let map = NaturalMap::new(dual, Bound::of(laws, &frozen));
        map.evaluate(unknowns)
            .relative_to(norm(dual.multipliers(unknowns)))
    }

    /// Linearises the contact problem of any law at λ, `[n_multipliers]` in Pa, followed by the rigid motions of a body that floats.
    #[must_use]
    pub fn new(dual: &ExplicitDual, laws: &PaneLaws, unknowns: &[f64]) -> Self {
        let frozen = laws.feasible_set(None);
        let map = NaturalMap::new(dual, Bound::of(laws, &frozen));
        let evaluation = map.evaluate(unknowns);
        let matrix = map.derivative(&evaluation);
        let (n, n_multipliers) = (unknowns.len(), dual.dimension());
        let lu = MatRef::from_column_major_slice(&matrix, n, n).partial_piv_lu();
        let pivots: Vec<f64> = (0..n).map(|i| lu.U()[(i, i)]).collect();
        let (permutation, _) = lu.P().arrays();
        // Each row of the balance turns the sign of what is left after its motion is eliminated.
        let n_motions = n - n_multipliers;
        let negative = pivots.iter().filter(|p| **p < 0.0).count();
        let negative = negative + transpositions(permutation) + n_motions;
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
                let map = NaturalMap::new(dual, Bound::Given(&set));
                let frozen = map.derivative(&map.evaluate(unknowns));
                FrictionCorrection::new(&frozen, &matrix, n).map_or(
                    [f64::INFINITY, 0.0],
                    |correction| {
                        let correction = correction.matrix();
                        [
                            spectral_radius(&correction),
                            distance_to_one(&correction).min(1.0),
                        ]
                    },
                )
            }
        };
        Self {
            residual: evaluation.relative_to(norm(dual.multipliers(unknowns))),
            determinant_sign: match (singular, negative % 2) {
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

/// The spectral radius of Ψ' at a solution, from the derivatives R_λ of the natural map with frozen friction and R' with friction
/// that follows λ, both column-major, `[n, n]`; `None` where R_λ is singular.
///
/// Successive approximations converge to the solution from nearby where it is below 1, and at that rate ([`LocalMapping`]).
#[must_use]
pub fn contraction_of_mapping(frozen: &[f64], followed: &[f64], n: usize) -> Option<f64> {
    FrictionCorrection::new(frozen, followed, n)
        .map(|correction| spectral_radius(&correction.matrix()))
}

impl LocalMapping {
    /// Linearises Ψ at a solution λ, `[n_multipliers]` in Pa, of the problem with Coulomb's law.
    ///
    /// Ψ freezes the slip bounds and the coefficients that λ makes, and solves for λ: Ψ' = 1 − R_λ⁻¹R'. Only the tangential rows of
    /// slipping panes differ, so the eigenvalues other than zero are those of M = −W R_λ⁻¹E, where E picks these rows and
    /// W = Eᵀ(R' − R_λ). One factorisation of the coupled rows of R_λ and some tens of solves give ρ(M); det R_λ > 0, since the
    /// problem with frozen friction is a strictly convex minimisation. `None` where a pane is so near to opening that rounding tells
    /// its zone.
    pub(in crate::solver) fn new(
        dual: &ExplicitDual,
        laws: &PaneLaws,
        law: &CoulombLaw,
        multiplier: &[f64],
    ) -> Option<Self> {
        let state = coulomb_state(dual, laws, law, multiplier);
        let set = laws.feasible_set(Some(&state));
        let derivative = |bound| {
            let map = NaturalMap::new(dual, bound);
            map.coupled_derivative(&map.evaluate(multiplier))
        };
        let (coupled, frozen) = derivative(Bound::Given(&set));
        let (followed_by, followed) = derivative(Bound::Coulomb(laws, law));
        if coupled != followed_by {
            return None;
        }
        let correction = FrictionCorrection::new(&frozen, &followed, coupled.len());
        Some(correction.map_or(
            Self {
                spectral_radius: f64::INFINITY,
                determinant_sign: 0,
                fold_distance: 0.0,
            },
            |correction| correction.local_mapping(),
        ))
    }
}

/// R_λ factorised, and the rows in which R' differs from it.
struct FrictionCorrection {
    n: usize,
    lu: DenseLu,
    rows: Vec<usize>,
    /// W, row-major, `[rows, n]`.
    differences: Vec<f64>,
}

impl FrictionCorrection {
    /// From both matrices, column-major, `[n, n]`; `None` where R_λ is singular.
    fn new(frozen: &[f64], followed: &[f64], n: usize) -> Option<Self> {
        let differs = |row: &usize| (0..n).any(|j| frozen[j * n + row] != followed[j * n + row]);
        let rows: Vec<usize> = (0..n).filter(differs).collect();
        let difference = |row: &usize| {
            let row = *row;
            (0..n).map(move |j| followed[j * n + row] - frozen[j * n + row])
        };
        Some(Self {
            n,
            lu: DenseLu::new(frozen, n)?,
            differences: rows.iter().flat_map(difference).collect(),
            rows,
        })
    }

    fn local_mapping(&self) -> LocalMapping {
        let figures = |hessenberg: &Mat<f64>| {
            let radius = spectral_radius(hessenberg);
            let distance = (radius < 1.0).then(|| distance_to_one(hessenberg));
            [radius, distance.unwrap_or(0.0)]
        };
        let product = |v: &[f64]| self.product(v);
        let [spectral_radius, distance] = figures_by_products(self.rows.len(), product, figures);
        let (determinant_sign, distance) = if spectral_radius < 1.0 {
            (1, distance)
        } else {
            self.sign_and_distance()
        };
        LocalMapping {
            spectral_radius,
            determinant_sign,
            // Rows without friction have the eigenvalue 0.
            fold_distance: distance.min(1.0),
        }
    }

    /// M v.
    fn product(&self, v: &[f64]) -> Vec<f64> {
        let mut solved = vec![0.0; self.n];
        for (row, value) in self.rows.iter().zip(v) {
            solved[*row] = *value;
        }
        self.lu.solve(&mut solved);
        let rows = self.differences.chunks_exact(self.n.max(1));
        rows.map(|row| -dot(row, &solved)).collect()
    }

    /// M = −W R_λ⁻¹E.
    fn matrix(&self) -> Mat<f64> {
        let count = self.rows.len();
        let mut picked = vec![0.0; self.n * count];
        for (column, row) in picked.chunks_exact_mut(self.n.max(1)).zip(&self.rows) {
            column[*row] = 1.0;
        }
        self.lu.solve(&mut picked);
        let inverse = MatRef::from_column_major_slice(&picked, self.n, count);
        let correction = MatRef::from_row_major_slice(&self.differences, count, self.n);
        -product(correction, inverse)
    }

    /// The sign of det(1 − M), and the least modulus of its eigenvalues.
    fn sign_and_distance(&self) -> (i8, f64) {
        let count = self.rows.len();
        let sum = Mat::<f64>::identity(count, count) - self.matrix();
        DenseLu::of(sum).map_or((0, 0.0), |lu| (lu.sign, least_modulus(&lu, count)))
    }
}

#[cfg(test)]
mod tests {
    use super::FrictionCorrection;

    /// R_λ = 1 and R' = 1 − Ψ' with a known Ψ'.
    fn local(mapping: [[f64; 3]; 3]) -> (f64, i8, f64) {
        let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
        let entry = |k: usize| (k % 3, k / 3);
        let frozen: Vec<f64> = (0..9).map(|k| unit(entry(k).0, entry(k).1)).collect();
        let followed: Vec<f64> = (0..9)
            .map(|k| unit(entry(k).0, entry(k).1) - mapping[entry(k).0][entry(k).1])
            .collect();
        let local = FrictionCorrection::new(&frozen, &followed, 3)
            .unwrap()
            .local_mapping();
        (
            local.spectral_radius,
            local.determinant_sign,
            local.fold_distance,
        )
    }

    #[test]
    fn radii_and_signs_of_known_derivatives() {
        // No row differs; a contraction; an eigenvalue beyond 1, one below −1, two beyond 1.
        assert_eq!(local([[0.0; 3]; 3]), (0.0, 1, 1.0));
        let cases = [
            (
                [[0.0, 0.0, 0.0], [0.3, 0.5, 0.0], [0.0, 0.0, 0.0]],
                0.5,
                1,
                0.5,
            ),
            (
                [[3.0, 0.0, 0.0], [0.3, 0.5, 0.0], [0.0, 0.0, 0.0]],
                3.0,
                -1,
                0.5,
            ),
            (
                [[-3.0, 0.0, 0.0], [0.3, 0.5, 0.0], [0.0, 0.0, 0.0]],
                3.0,
                1,
                0.5,
            ),
            (
                [[3.0, 0.0, 0.0], [0.3, 1.25, 0.0], [0.0, 0.0, 0.0]],
                3.0,
                1,
                0.25,
            ),
        ];
        for (mapping, radius, sign, distance) in cases {
            let found = local(mapping);
            // The last of 22 squarings takes the root of a number near one.
            assert!((found.0 - radius).abs() < 1e-6 * radius, "{found:?}");
            assert_eq!(found.1, sign);
            assert!((found.2 - distance).abs() < 1e-6, "{found:?}");
        }
    }
}

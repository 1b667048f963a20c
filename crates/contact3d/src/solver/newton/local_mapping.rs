//! How the mapping Ψ of HKL behaves at a solution, at the cost of one step of Newton's method.

use faer::{Mat, MatRef};

use super::natural_map::NaturalMap;
use crate::{
    contact::CoulombLaw,
    dual::ExplicitDual,
    linalg::{
        DenseLu, distance_to_one, dot, figures_by_products, least_modulus, product, spectral_radius,
    },
    solver::{PaneLaws, conditions::Bound, coulomb_state},
};

/// The linearisation of the mapping Ψ of HKL, whose fixed points are the solutions, at one of them.
///
/// On the way to the solution some pane may change its zone: then Ψ has a kink there, and this is what holds on one side of it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LocalMapping {
    /// ρ(Ψ'): successive approximations converge to the solution from nearby where it is below 1, and at that rate; infinite where
    /// the problem with frozen friction is singular.
    pub spectral_radius: f64,
    /// The sign of det R' = det R_λ det(1 − Ψ') for the natural map R, with frozen friction R_λ; 0 where it vanishes. The signs over
    /// all solutions add up to 1, so where it is −1 there are at least two other solutions.
    pub determinant: i8,
    /// The least |1 − μ| over the eigenvalues μ of Ψ', from 0, where det R' = 0, to 1: small changes of the data move the solution in
    /// proportion to its inverse, and where a real μ is that near, a fold is, in which this solution and another one meet. Ends of pieces,
    /// where panes change their zones, may be folds that no eigenvalue announces.
    pub fold_distance: f64,
}

/// A fold is near where the distance is below this.
pub(super) const NEAR_FOLD: f64 = 0.1;

impl LocalMapping {
    /// Whether det R' = 0 is near, and so perhaps another solution.
    #[must_use]
    pub fn is_near_fold(&self) -> bool {
        self.fold_distance < NEAR_FOLD
    }

    /// Whether successive approximations converge to the solution from nearby.
    #[must_use]
    pub fn is_attracting(&self) -> bool {
        self.spectral_radius < 1.0
    }

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
        let (coupled, frozen) = derivative(Bound::Frozen(&set));
        let (followed_by, followed) = derivative(Bound::Coulomb(laws, law));
        if coupled != followed_by {
            return None;
        }
        let moving = Moving::new(&frozen, &followed, coupled.len());
        Some(moving.map_or(
            Self {
                spectral_radius: f64::INFINITY,
                determinant: 0,
                fold_distance: 0.0,
            },
            |moving| moving.local(),
        ))
    }
}

/// R_λ factorised, and the rows in which R' differs from it.
struct Moving {
    n: usize,
    lu: DenseLu,
    rows: Vec<usize>,
    /// W, row-major, `[rows, n]`.
    differences: Vec<f64>,
}

impl Moving {
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

    fn local(&self) -> LocalMapping {
        let figures = |hessenberg: &Mat<f64>| {
            let radius = spectral_radius(hessenberg);
            let is_outer = radius < 1.0;
            [
                radius,
                if is_outer {
                    distance_to_one(hessenberg)
                } else {
                    0.0
                },
            ]
        };
        let product = |v: &[f64]| self.product(v);
        let [spectral_radius, distance] = figures_by_products(self.rows.len(), product, figures);
        let (determinant, distance) = match spectral_radius < 1.0 {
            true => (1, distance),
            false => self.sign_and_distance(),
        };
        LocalMapping {
            spectral_radius,
            determinant,
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

    /// The sign of det(1 − M), and the least modulus of its eigenvalues.
    fn sign_and_distance(&self) -> (i8, f64) {
        let count = self.rows.len();
        let mut picked = vec![0.0; self.n * count];
        for (column, row) in picked.chunks_exact_mut(self.n.max(1)).zip(&self.rows) {
            column[*row] = 1.0;
        }
        self.lu.solve(&mut picked);
        let inverse = MatRef::from_column_major_slice(&picked, self.n, count);
        let moving = MatRef::from_row_major_slice(&self.differences, count, self.n);
        let sum = product(moving, inverse) + Mat::<f64>::identity(count, count);
        let entries: Vec<f64> = (0..count)
            .flat_map(|j| (0..count).map(move |i| (i, j)))
            .map(|at| sum[at])
            .collect();
        DenseLu::new(&entries, count).map_or((0, 0.0), |lu| (lu.sign(), least_modulus(&lu, count)))
    }
}

#[cfg(test)]
mod tests {
    use super::Moving;

    /// R_λ = 1 and R' = 1 − Ψ' with a known Ψ'.
    fn local(mapping: [[f64; 3]; 3]) -> (f64, i8, f64) {
        let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
        let entry = |k: usize| (k % 3, k / 3);
        let frozen: Vec<f64> = (0..9).map(|k| unit(entry(k).0, entry(k).1)).collect();
        let followed: Vec<f64> = (0..9)
            .map(|k| unit(entry(k).0, entry(k).1) - mapping[entry(k).0][entry(k).1])
            .collect();
        let local = Moving::new(&frozen, &followed, 3).unwrap().local();
        (
            local.spectral_radius,
            local.determinant,
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

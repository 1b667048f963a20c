//! The derivative of Ψ at a solution.

use faer::Mat;

use super::{
    dense::{alone, congruent, inverse, root, symmetric},
    level::TheoryProblem,
    trace::{Blocks, PartNorms, norm_on_sum, part_norms},
};
use contact3d::{
    contact::{CoulombLaw, FrictionField, Interface, SlipOperatorDerivative},
    solver::{CoulombState, PaneLaws, Solution, frozen_response},
};

/// Ψ′ at a solution.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LocalContraction {
    /// The largest modulus of an eigenvalue of Ψ′: the rate of successive approximations near the solution.
    pub spectral_radius: f64,
    /// Sign of det(I − Ψ′); the signs of all solutions add up to 1 (HKL Theorem 3.1 by Brouwer's degree).
    pub index: i8,
    /// Norms of its parts in L²(Γ_c) and ‖·‖_{*,h}, for each norm of displacements.
    pub parts: Vec<PartNorms>,
    /// ‖Ψ′‖ in HKL's norm ‖φ‖ + ‖μ‖ in the units of the scene, for each norm of displacements; `None` where not asked for.
    pub paper: Option<Vec<f64>>,
}

/// Ψ′ = O Z D: D takes (φ, g) to (g, 𝓕⁻¹), Z these to λ, O takes λ to (φ, λ_ν).
struct Chain {
    /// D on φ: one row for each diagonal entry of 𝓕⁻¹, `[2 m, 2 n_contact_nodes]`.
    inverse_by_slip: Mat<f64>,
    /// Z: λ by g and by 𝓕⁻¹, times the slope of the slip bound for g.
    by_pressure: Mat<f64>,
    by_inverse: Mat<f64>,
    /// The part of O that gives φ, `[2 n_contact_nodes, 3 m]`.
    slip: Mat<f64>,
}

impl TheoryProblem {
    /// Ψ′ with its norms at a solution for the law of an interface; `None` where the derivative of the frozen problem is
    /// singular.
    pub(super) fn contraction(
        &self,
        interface: &Interface,
        solution: &Solution,
        with_paper: bool,
    ) -> Option<LocalContraction> {
        let chain = self.chain(interface, solution)?;
        let (spectral_radius, index) = chain.spectrum();
        let slip_ball = root(&chain.slip_ball(self));
        let blocks = [0, 1].map(|k| chain.blocks(self, k, &slip_ball));
        Some(LocalContraction {
            spectral_radius,
            index,
            parts: blocks.iter().map(part_norms).collect(),
            paper: with_paper.then(|| blocks.iter().map(norm_on_sum).collect()),
        })
    }

    fn chain(&self, interface: &Interface, solution: &Solution) -> Option<Chain> {
        let (dual, law) = (self.dual(), interface.coulomb()?);
        let laws = self.laws_of(interface);
        let (m, n) = (dual.layout.n_panes(), dual.layout.n_multipliers());
        let operator = &laws.slip.operator;
        let tangential = self.tangential_of(&solution.displacement);
        let slip = operator.slip(&tangential);
        let (normal, _) = dual.layout.split(&solution.multiplier);
        let state = CoulombState {
            slip_bound: law.slip_bounds(normal, |l| l.max(0.0)),
            friction: FrictionField::new(law, &laws.average, &slip),
        };
        let response = frozen_response(dual, &self.local, &laws, &state, &solution.multiplier)?;
        let z = |row: usize, column: usize| response[column * n + row];
        let slope = |pane: usize| law.slip_bound_slope(pane, normal[pane].max(0.0));
        Some(Chain {
            inverse_by_slip: inverse_by_slip(law, &laws, &state, &slip),
            by_pressure: Mat::from_fn(n, m, |i, pane| slope(pane) * z(i, pane)),
            by_inverse: Mat::from_fn(n, 2 * m, |i, k| z(i, m + k)),
            slip: self.slip_by_multiplier(&operator.derivative(&tangential)),
        })
    }

    /// ∂φ/∂λ, `[2 n_contact_nodes, 3 m]`.
    fn slip_by_multiplier(&self, derivative: &SlipOperatorDerivative) -> Mat<f64> {
        let compliance = &self.compliance;
        let columns: Vec<Vec<[f64; 2]>> = (0..compliance.ncols())
            .map(|j| derivative.apply(|node| [0, 1].map(|k| -compliance[(2 * node + k, j)])))
            .collect();
        Mat::from_fn(compliance.nrows(), compliance.ncols(), |row, j| {
            columns[j][row / 2][row % 2]
        })
    }
}

/// ∂𝓕_i⁻¹/∂φ: −w ∂F/∂φ / F² at the nodes of each pane.
fn inverse_by_slip(
    law: &CoulombLaw,
    laws: &PaneLaws,
    state: &CoulombState,
    slip: &[[f64; 2]],
) -> Mat<f64> {
    let m = state.slip_bound.len();
    let mut rows = Mat::zeros(2 * m, 2 * slip.len());
    if !law.depends_on_slip() {
        return rows;
    }
    for pane in 0..m {
        for (node, weight) in laws.average.entries(pane) {
            let derivative = law.derivative(node, slip[node]);
            let coefficients = state.friction.nodal[node];
            for k in 0..2 {
                for l in 0..2 {
                    let slope = -derivative[k][l] / (coefficients[k] * coefficients[k]);
                    rows[(2 * pane + k, 2 * node + l)] += weight * slope;
                }
            }
        }
    }
    rows
}

impl Chain {
    /// Number of panes m.
    fn n_panes(&self) -> usize {
        self.by_pressure.ncols()
    }

    /// The spectral radius, and the sign of det(I − Ψ′): nonzero eigenvalues of O Z D are those of D O Z.
    fn spectrum(&self) -> (f64, i8) {
        let m = self.n_panes();
        let by_slip = alone(|| &self.inverse_by_slip * &self.slip);
        let (of_inverse, of_pressure) =
            alone(|| (&by_slip * &self.by_inverse, &by_slip * &self.by_pressure));
        let entry = |i: usize, j: usize| match (i.checked_sub(m), j.checked_sub(m)) {
            (None, None) => self.by_pressure[(i, j)],
            (None, Some(k)) => self.by_inverse[(i, k)],
            (Some(row), None) => of_pressure[(row, j)],
            (Some(row), Some(k)) => of_inverse[(row, k)],
        };
        let kept = recurrent(3 * m, entry);
        let cycle = Mat::from_fn(kept.len(), kept.len(), |i, j| entry(kept[i], kept[j]));
        let eigenvalues = alone(|| cycle.eigenvalues()).unwrap_or_default();
        let moduli = eigenvalues.iter().map(|e| e.re.hypot(e.im));
        let radius = moduli.fold(0.0, f64::max);
        // Pairs of complex eigenvalues add positive factors.
        let real = eigenvalues.iter().filter(|e| e.im == 0.0);
        let beyond = real.clone().filter(|e| e.re > 1.0).count();
        let on = real.clone().any(|e| e.re == 1.0);
        let index = match (on || eigenvalues.len() < kept.len(), beyond % 2) {
            (true, _) => 0,
            (false, 0) => 1,
            (false, _) => -1,
        };
        (radius, index)
    }

    /// The forms of both images over unit balls of both arguments.
    fn blocks(&self, problem: &TheoryProblem, norm: usize, slip_ball: &Mat<f64>) -> Blocks {
        let m = self.n_panes();
        let (pressure, factor) = &problem.pressure[norm];
        let slip_form = |z: &Mat<f64>| {
            let moved = alone(|| &self.slip * z);
            let columns = (0..moved.ncols()).map(|j| {
                let column: Vec<f64> = moved.col(j).iter().copied().collect();
                problem.face.mass_product(&problem.forms.mass, &column, 2)
            });
            let columns: Vec<Vec<f64>> = columns.collect();
            let weighed = Mat::from_fn(moved.nrows(), moved.ncols(), |i, j| columns[j][i]);
            symmetric(alone(|| moved.transpose() * &weighed))
        };
        let pressure_form = |z: &Mat<f64>| {
            let normal = z.submatrix(0, 0, m, z.ncols()).to_owned();
            congruent(&normal, pressure)
        };
        let identity = Mat::<f64>::identity(m, m);
        let pressure_ball = root(&symmetric(factor.solve(&identity)));
        let form = |z: &Mat<f64>, ball: &Mat<f64>| {
            let [slip, pressure] = [slip_form(z), pressure_form(z)];
            [congruent(ball, &slip), congruent(ball, &pressure)]
        };
        [
            form(&self.by_inverse, slip_ball),
            form(&self.by_pressure, &pressure_ball),
        ]
    }

    /// D M⁻¹ Dᵀ: the image of the unit ball of Y^h × Y^h in 𝓕⁻¹.
    fn slip_ball(&self, problem: &TheoryProblem) -> Mat<f64> {
        let (d, free) = (&self.inverse_by_slip, problem.face.free_nodes());
        let mut inverse = inverse(&problem.mass_factor);
        let mut ball = Mat::zeros(d.nrows(), d.nrows());
        for l in 0..2 {
            let part = Mat::from_fn(d.nrows(), free.len(), |row, j| d[(row, 2 * free[j] + l)]);
            let rows = (0..d.nrows()).map(|row| part.row(row).iter().copied().collect());
            let solved: Vec<Vec<f64>> = rows.map(&mut inverse).collect();
            let solved = Mat::from_fn(free.len(), d.nrows(), |j, row| solved[row][j]);
            ball += alone(|| &part * &solved);
        }
        symmetric(ball)
    }
}

/// The components that act on themselves through others: those without a row or a column of their own add the eigenvalue 0
/// and nothing else, such as the slip bounds of open panes, which move tangential stresses and stay 0.
fn recurrent(n: usize, entry: impl Fn(usize, usize) -> f64) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..n).collect();
    loop {
        let acts = |&i: &usize| {
            kept.iter().any(|&j| entry(i, j) != 0.0) && kept.iter().any(|&j| entry(j, i) != 0.0)
        };
        let next: Vec<usize> = kept.iter().copied().filter(acts).collect();
        if next.len() == kept.len() {
            return kept;
        }
        kept = next;
    }
}

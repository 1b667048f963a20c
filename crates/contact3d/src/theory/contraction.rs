//! The derivative of Ψ at a solution.

use faer::Mat;

use super::{
    dense::{Factor, alone, congruent, largest, root, symmetric},
    face::Face,
    scatter::factorised,
};
use crate::{
    contact::{CoulombLaw, SlipOperatorDerivative},
    dual::{ExplicitDual, LocalStiffness},
    linalg::{CholeskyFactor, CscMatrix, Workspace},
    solver::{ContactState, CoulombState, frozen_response},
};

/// The logarithm of the ratio of two weights is searched this far to both sides, to an accuracy whose square is rounding.
const REACH: f64 = 40.0;
const VALLEY: f64 = 1e-6;

/// The norms of Y^h × Y^h and of L^H.
pub(super) struct SpaceNorms {
    /// M_Γ of scalar functions, over the free nodes.
    mass: CscMatrix,
    mass_factor: CholeskyFactor,
    /// ‖·‖²_{*,h} in each norm of displacements, `[m, m]`, and its factor.
    pressure: Vec<(Mat<f64>, Factor)>,
}

impl SpaceNorms {
    /// `None` where a form has no factor.
    pub(super) fn new(mass: CscMatrix, pressure: Vec<Mat<f64>>) -> Option<Self> {
        let factors = pressure.into_iter().map(|form| {
            let factor = Factor::new(&form)?;
            Some((form, factor))
        });
        Some(Self {
            mass_factor: factorised(&mass)?,
            pressure: factors.collect::<Option<_>>()?,
            mass,
        })
    }

    pub(super) fn mass(&self) -> &CscMatrix {
        &self.mass
    }

    /// ‖μ‖_{*,h} in one of the norms of displacements.
    pub(super) fn of_pressure(&self, norm: usize, multiplier: &[f64]) -> f64 {
        let form = &self.pressure[norm].0;
        let terms = (0..form.ncols()).map(|j| {
            let column = (0..form.nrows()).map(|i| form[(i, j)] * multiplier[i]);
            multiplier[j] * column.sum::<f64>()
        });
        terms.sum::<f64>().max(0.0).sqrt()
    }
}

/// Norms of the four parts of Ψ′: how much slip and pressure move with slip and pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartNorms {
    /// ‖∂φ′/∂φ‖.
    pub slip_by_slip: f64,
    /// ‖∂φ′/∂g‖.
    pub slip_by_pressure: f64,
    /// ‖∂λ_ν′/∂φ‖.
    pub pressure_by_slip: f64,
    /// ‖∂λ_ν′/∂g‖.
    pub pressure_by_pressure: f64,
}

impl PartNorms {
    /// The largest eigenvalue of the 2 × 2 matrix of the norms: the least bound of ‖Ψ′‖ in w ‖φ‖ + ‖μ‖ over all weights w,
    /// as far as norms of parts tell.
    #[must_use]
    pub fn weighted(self) -> f64 {
        let (a, d) = (self.slip_by_slip, self.pressure_by_pressure);
        let mixed = self.slip_by_pressure * self.pressure_by_slip;
        0.5 * (a + d) + (0.25 * (a - d) * (a - d) + mixed).sqrt()
    }

    /// The weight w for which w ‖φ‖ + ‖μ‖ has that bound; 0 where nothing depends on the slip.
    #[must_use]
    pub fn weight(self) -> f64 {
        let rest = self.weighted() - self.slip_by_slip;
        if self.pressure_by_slip == 0.0 || rest <= 0.0 {
            return 0.0;
        }
        self.pressure_by_slip / rest
    }
}

/// Ψ′ at a solution.
#[derive(Debug, Clone, PartialEq)]
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

/// A solution at which Ψ is differentiated.
pub(super) struct AtSolution<'a> {
    pub(super) dual: &'a ExplicitDual,
    pub(super) local: &'a LocalStiffness,
    pub(super) contact: ContactState<'a>,
    pub(super) law: &'a CoulombLaw,
    pub(super) face: &'a Face,
    /// The compliance u_t = … − G λ of the contact nodes, `[2 n_contact_nodes, 3 m]`.
    pub(super) compliance: &'a Mat<f64>,
    pub(super) multiplier: &'a [f64],
    /// (u_t1, u_t2) at the contact nodes, signed.
    pub(super) tangential: &'a [[f64; 2]],
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

impl AtSolution<'_> {
    /// Ψ′ with its norms; `None` where the derivative of the frozen problem is singular.
    pub(super) fn contraction(
        &self,
        norms: &SpaceNorms,
        with_paper: bool,
    ) -> Option<LocalContraction> {
        let chain = self.chain()?;
        let (spectral_radius, index) = chain.spectrum();
        let blocks: Vec<Blocks> = (0..norms.pressure.len())
            .map(|k| chain.blocks(self.face, norms, k))
            .collect();
        Some(LocalContraction {
            spectral_radius,
            index,
            parts: blocks.iter().map(Blocks::part_norms).collect(),
            paper: with_paper.then(|| blocks.iter().map(Blocks::paper).collect()),
        })
    }

    fn chain(&self) -> Option<Chain> {
        let layout = self.dual.layout;
        let (m, n) = (layout.n_panes(), layout.n_multipliers());
        let operator = &self.contact.interface.slip;
        let slip = operator.slip(self.tangential);
        let (normal, _) = layout.split(self.multiplier);
        let state = CoulombState {
            slip_bound: normal
                .iter()
                .map(|l| self.law.slip_bound(l.max(0.0)))
                .collect(),
            friction: crate::contact::FrictionField::new(self.law, self.contact.surface, &slip),
        };
        let response = frozen_response(
            self.dual,
            self.local,
            &self.contact,
            &state,
            self.multiplier,
        )?;
        let z = |row: usize, column: usize| response[column * n + row];
        let slope = |pane: usize| self.law.slip_bound_slope(normal[pane].max(0.0));
        Some(Chain {
            inverse_by_slip: self.inverse_by_slip(&state, &slip),
            by_pressure: Mat::from_fn(n, m, |i, pane| slope(pane) * z(i, pane)),
            by_inverse: Mat::from_fn(n, 2 * m, |i, k| z(i, m + k)),
            slip: self.slip_by_multiplier(&operator.derivative(self.tangential)),
        })
    }

    /// ∂φ/∂λ, `[2 n_contact_nodes, 3 m]`.
    fn slip_by_multiplier(&self, derivative: &SlipOperatorDerivative) -> Mat<f64> {
        let compliance = self.compliance;
        let columns: Vec<Vec<[f64; 2]>> = (0..compliance.ncols())
            .map(|j| derivative.apply(|node| [0, 1].map(|k| -compliance[(2 * node + k, j)])))
            .collect();
        Mat::from_fn(compliance.nrows(), compliance.ncols(), |row, j| {
            columns[j][row / 2][row % 2]
        })
    }

    /// ∂𝓕_i⁻¹/∂φ: −w ∂F/∂φ / F² at the nodes of each pane.
    fn inverse_by_slip(&self, state: &CoulombState, slip: &[[f64; 2]]) -> Mat<f64> {
        let m = self.dual.layout.n_panes();
        let mut rows = Mat::zeros(2 * m, 2 * slip.len());
        if !self.law.depends_on_slip() {
            return rows;
        }
        for pane in 0..m {
            for (node, weight) in self.contact.surface.pane_weights(pane) {
                let derivative = self.law.derivative(node, slip[node]);
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
    fn blocks(&self, face: &Face, norms: &SpaceNorms, norm: usize) -> Blocks {
        let m = self.n_panes();
        let (pressure, factor) = &norms.pressure[norm];
        let slip_form = |z: &Mat<f64>| {
            let moved = alone(|| &self.slip * z);
            let weighed = weighed(face, &norms.mass, &moved);
            symmetric(alone(|| moved.transpose() * &weighed))
        };
        let pressure_form = |z: &Mat<f64>| {
            let normal = z.submatrix(0, 0, m, z.ncols()).to_owned();
            congruent(&normal, pressure)
        };
        let identity = Mat::<f64>::identity(m, m);
        let pressure_ball = root(&symmetric(factor.solve(&identity)));
        let slip_ball = root(&self.slip_ball(face, norms));
        let form = |z: &Mat<f64>, ball: &Mat<f64>| {
            let [slip, pressure] = [slip_form(z), pressure_form(z)];
            [congruent(ball, &slip), congruent(ball, &pressure)]
        };
        Blocks {
            by_slip: form(&self.by_inverse, &slip_ball),
            by_pressure: form(&self.by_pressure, &pressure_ball),
        }
    }

    /// D M⁻¹ Dᵀ: the image of the unit ball of Y^h × Y^h in 𝓕⁻¹.
    fn slip_ball(&self, face: &Face, norms: &SpaceNorms) -> Mat<f64> {
        let d = &self.inverse_by_slip;
        let free: Vec<usize> = (0..face.points.len())
            .filter(|&n| face.place[n].is_some())
            .collect();
        let mut ball = Mat::zeros(d.nrows(), d.nrows());
        let mut work = Workspace::default();
        for l in 0..2 {
            let part = Mat::from_fn(d.nrows(), free.len(), |row, j| d[(row, 2 * free[j] + l)]);
            let mut solved = Mat::zeros(free.len(), d.nrows());
            for row in 0..d.nrows() {
                let mut values: Vec<f64> = (0..free.len()).map(|j| part[(row, j)]).collect();
                norms.mass_factor.solve_in_place(&mut values, &mut work);
                values
                    .iter()
                    .enumerate()
                    .for_each(|(j, v)| solved[(j, row)] = *v);
            }
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

/// M_Γ of both components of columns of nodal pairs.
fn weighed(face: &Face, mass: &CscMatrix, columns: &Mat<f64>) -> Mat<f64> {
    let mut result = Mat::zeros(columns.nrows(), columns.ncols());
    for j in 0..columns.ncols() {
        for k in 0..2 {
            let values = face.to_free(|node| columns[(2 * node + k, j)]);
            let image = super::scatter::product(mass, &values);
            for (node, place) in face.place.iter().enumerate() {
                if let Some(place) = *place {
                    result[(2 * node + k, j)] = image[place];
                }
            }
        }
    }
    result
}

/// The squared norms of the slip and of the pressure that Ψ′ makes of unit vectors of slip and of pressure.
struct Blocks {
    by_slip: [Mat<f64>; 2],
    by_pressure: [Mat<f64>; 2],
}

impl Blocks {
    fn part_norms(&self) -> PartNorms {
        let norm = |form: &Mat<f64>| largest(form).max(0.0).sqrt();
        PartNorms {
            slip_by_slip: norm(&self.by_slip[0]),
            pressure_by_slip: norm(&self.by_slip[1]),
            slip_by_pressure: norm(&self.by_pressure[0]),
            pressure_by_pressure: norm(&self.by_pressure[1]),
        }
    }

    /// The norm on the sum: the unit ball of ‖φ‖ + ‖μ‖ is the convex hull of the two unit balls.
    fn paper(&self) -> f64 {
        sum_norm(&self.by_slip).max(sum_norm(&self.by_pressure))
    }
}

/// sup √(xᵀAx) + √(xᵀBx) over |x| = 1: the least λ_max(A/s + B/(1−s)) over 0 < s < 1, squared, since the pairs (xᵀAx, xᵀBx)
/// fill a convex set (L. Brickman, *Proc. Am. Math. Soc.* 12 (1961) 61).
fn sum_norm([first, second]: &[Mat<f64>; 2]) -> f64 {
    if first.nrows() == 0 {
        return 0.0;
    }
    let bound = |logit: f64| {
        let weights = [1.0 + (-logit).exp(), 1.0 + logit.exp()];
        let sum = Mat::from_fn(first.nrows(), first.nrows(), |i, j| {
            first[(i, j)] * weights[0] + second[(i, j)] * weights[1]
        });
        largest(&sum)
    };
    // At the best share s/(1 − s) = √(xᵀAx / xᵀBx): the logarithm of that is searched around its value for the largest of each.
    let size = |form: &Mat<f64>| largest(form).max(f64::MIN_POSITIVE).ln();
    let middle = 0.5 * (size(first) - size(second));
    least_by_golden_section(middle - REACH, middle + REACH, bound)
        .max(0.0)
        .sqrt()
}

/// The least value of a function with one valley.
fn least_by_golden_section(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let mut at = [high - golden * (high - low), low + golden * (high - low)];
    let mut values = at.map(&f);
    while high - low > VALLEY {
        if values[0] <= values[1] {
            high = at[1];
            (at[1], values[1]) = (at[0], values[0]);
            at[0] = high - golden * (high - low);
            values[0] = f(at[0]);
        } else {
            low = at[0];
            (at[0], values[0]) = (at[1], values[1]);
            at[1] = low + golden * (high - low);
            values[1] = f(at[1]);
        }
    }
    values[0].min(values[1])
}

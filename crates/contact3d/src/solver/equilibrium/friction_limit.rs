//! What friction can bear at most where supports and load settle the pressure.
//!
//! Where no motion q that is left to friction moves the face along its normal, λ_ν = T(h_ν − S_νt λ_t) for the solution T of frictionless
//! contact, and T does not expand: ‖T(a) − T(b)‖_S ≤ ‖a − b‖_S⁻¹ for S = S_νν, since λ_ν is the projection of S⁻¹a on a convex cone. With
//! |λ_t| ≤ F λ_ν a bound κ of ‖S_νt λ_t‖_S⁻¹ / ‖λ_ν‖_S follows, and ‖λ_ν − T(h_ν)‖_S ≤ κ / (1 − κ) ‖T(h_ν)‖_S where κ < 1. So
//! friction does no more work than c·T(h_ν) + ‖c‖_S⁻¹ κ / (1 − κ) ‖T(h_ν)‖_S in a motion, for the work c_i of a unit of pressure on pane i.
//! A load that works more in q has no equilibrium.

use std::sync::atomic::AtomicUsize;

use faer::Mat;

use super::motion_program::{MotionProgram, PaneTerm};
use crate::{
    contact::MultiplierLayout,
    dual::{Balance, ExplicitDual},
    linalg::{DenseCholesky, add_scaled, dot, largest_eigenvalue, norm},
    solver::{
        FeasibleSet,
        convex::{ConvexProgram, InteriorPoint, Motions},
    },
};

/// Share of a motion on the face that may be along its normal: rounding.
const NORMAL: f64 = 1e-10;

/// How far the interior point leaves the pressure undecided, and what that counts for in the bound.
const UNDECIDED: f64 = 1e-9;
const MARGIN: f64 = 1e-6;

/// S over the panes of a face with its weak supports, G D⁻¹Gᵀ, in units in which the diagonal of its normal part is one.
struct Face<'a> {
    dual: &'a ExplicitDual,
    balance: &'a Balance,
    layout: MultiplierLayout,
    /// 1/√S_ii of the normal part.
    unit: Vec<f64>,
    /// The factor of the normal part.
    factor: DenseCholesky,
}

/// A rigid motion, in terms of felt ones, in which the load works more than friction up to F₁, F₂ times the pressure of a pane can take.
pub(super) fn beyond_friction(
    dual: &ExplicitDual,
    balance: &Balance,
    areas: &[f64],
    coefficients: &[[f64; 2]],
) -> Option<Vec<f64>> {
    let face = Face::new(dual, balance)?;
    let layout = face.layout;
    let n_resisted = balance.coupling.n_resisted();
    let free = &balance.coupling.integrals[n_resisted..];
    let is_along = |g: &Vec<f64>| norm(&g[layout.normals()]) <= NORMAL * norm(g);
    if free.is_empty() || !free.iter().all(is_along) {
        return None;
    }
    let strayed = face.strayed(coefficients);
    if !(strayed < 1.0) {
        return None;
    }
    let pressure = face.frictionless_pressure()?;
    let terms = (0..layout.n_panes()).map(|i| match coefficients.get(i) {
        Some(f) => PaneTerm::Bounded(f.map(|f| f * pressure[i])),
        None => PaneTerm::Pressure,
    });
    let motion = MotionProgram::new(balance, areas, layout, terms.collect())?.unopposed()?;
    let moved = balance
        .coupling
        .integrals_of(&motion, layout.n_multipliers());
    let work = dot(&balance.resultant, &motion);
    let by_pressure: Vec<f64> = (0..layout.n_panes())
        .map(|i| match (coefficients.get(i), layout.tangential(i)) {
            (Some([a, b]), Some([j, k])) => (a * moved[j]).hypot(b * moved[k]),
            _ => 0.0,
        })
        .collect();
    let size = face.energy_norm(&pressure);
    let reach = face.dual_norm(&by_pressure) * size * (strayed / (1.0 - strayed) + MARGIN);
    (work > (1.0 + MARGIN) * dot(&by_pressure, &pressure) + reach).then_some(motion)
}

impl<'a> Face<'a> {
    fn new(dual: &'a ExplicitDual, balance: &'a Balance) -> Option<Self> {
        let layout = dual.layout;
        let m = layout.n_panes();
        let diagonal = |i: usize| supported(dual, balance, i, i);
        if (0..m).any(|i| !(diagonal(i) > 0.0)) {
            return None;
        }
        let unit: Vec<f64> = (0..m).map(|i| diagonal(i).sqrt().recip()).collect();
        let matrix = Mat::from_fn(m, m, |i, j| {
            unit[i] * supported(dual, balance, i, j) * unit[j]
        });
        Some(Self {
            factor: DenseCholesky::shifted(&matrix)?,
            dual,
            balance,
            layout,
            unit,
        })
    }

    /// S_νν⁻¹ v.
    fn solve(&self, v: &[f64]) -> Vec<f64> {
        let mut x: Vec<f64> = v.iter().zip(&self.unit).map(|(v, d)| v * d).collect();
        self.factor.solve(&mut x);
        x.iter_mut().zip(&self.unit).for_each(|(x, d)| *x *= d);
        x
    }

    /// S λ with what weak supports add.
    fn apply(&self, multiplier: &[f64]) -> Vec<f64> {
        let mut product = self.dual.apply(multiplier);
        for (g, support) in resisted(self.balance) {
            add_scaled(&mut product, dot(g, multiplier) / support, g);
        }
        product
    }

    /// κ: σ θ for the largest singular value σ of L⁻¹S_νt Φ, Φ = diag(F/√S_ii), and θ⁻² the least eigenvalue of S_νν of unit diagonal.
    fn strayed(&self, coefficients: &[[f64; 2]]) -> f64 {
        let (m, n) = (self.layout.n_panes(), self.layout.n_multipliers());
        let soft = largest_eigenvalue(m, |v| {
            let mut x = v.to_vec();
            self.factor.solve(&mut x);
            x
        });
        let scale: Vec<f64> = (m..n)
            .map(|j| {
                let pane = self.layout.pane_of(j);
                let f = coefficients.get(pane).map_or(0.0, |f| f[(j - m) % 2]);
                f * self.unit[pane]
            })
            .collect();
        let coupled = largest_eigenvalue(n - m, |v| {
            let mut multiplier = vec![0.0; m];
            multiplier.extend(v.iter().zip(&scale).map(|(v, s)| v * s));
            let mut pushed = self.solve(&self.apply(&multiplier)[..m]);
            pushed.resize(n, 0.0);
            let back = self.apply(&pushed);
            back[m..].iter().zip(&scale).map(|(v, s)| v * s).collect()
        });
        (coupled * soft).sqrt()
    }

    /// T(h_ν); `None` where rounding keeps it from being found.
    fn frictionless_pressure(&self) -> Option<Vec<f64>> {
        let m = self.layout.n_panes();
        let mut rhs = self.dual.rhs[..m].to_vec();
        for ((g, support), e) in resisted(self.balance).zip(&self.balance.resultant) {
            add_scaled(&mut rhs, e / support, &g[..m]);
        }
        let projections = AtomicUsize::new(0);
        let set = FeasibleSet::new(m, Vec::new(), &projections);
        let stiffness: Vec<f64> = self.unit.iter().map(|unit| unit * unit).collect();
        let bound = dot(&rhs, &self.solve(&rhs)).max(0.0).sqrt();
        let entry = |i: usize, j: usize| supported(self.dual, self.balance, i, j);
        let program = ConvexProgram::new(entry, &rhs, &set, &stiffness, bound, &Motions::default());
        match InteriorPoint::new(&program) {
            None => Some(vec![0.0; m]),
            Some(mut inside) => inside.run(UNDECIDED).then(|| inside.unknowns(m)),
        }
    }

    /// √(λ·S_νν λ).
    fn energy_norm(&self, pressure: &[f64]) -> f64 {
        let mut multiplier = pressure.to_vec();
        multiplier.resize(self.layout.n_multipliers(), 0.0);
        dot(&multiplier, &self.apply(&multiplier)).max(0.0).sqrt()
    }

    /// √(c·S_νν⁻¹c).
    fn dual_norm(&self, by_pressure: &[f64]) -> f64 {
        dot(by_pressure, &self.solve(by_pressure)).max(0.0).sqrt()
    }
}

/// An entry of S + G D⁻¹Gᵀ.
fn supported(dual: &ExplicitDual, balance: &Balance, i: usize, j: usize) -> f64 {
    let added = resisted(balance).map(|(g, support)| g[i] * g[j] / support);
    dual.column(j)[i] + added.sum::<f64>()
}

/// G and D of each motion that supports resist.
fn resisted(balance: &Balance) -> impl Iterator<Item = (&Vec<f64>, f64)> {
    let coupling = &balance.coupling;
    let motions = coupling.integrals.iter().zip(&coupling.support);
    let motions = motions.take(coupling.n_resisted());
    motions.map(|(g, support)| (g, *support))
}

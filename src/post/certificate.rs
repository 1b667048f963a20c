use super::{PaneState, Solved, zones::scaled_norm};
use crate::{contact::FrictionField, solver::FeasibleSet};

/// How well λ and u satisfy the discrete contact problem with Coulomb friction and F(u); every
/// figure is dimensionless and vanishes for the exact discrete solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certificate {
    /// ‖A u + Bᵀλ − l‖ / ‖l‖.
    pub equilibrium: f64,
    /// Largest mean penetration (u_ν − d)₊ of a pane over the largest displacement component.
    pub penetration: f64,
    /// Largest adhesion (−λ_ν)₊ over the largest |λ|.
    pub adhesion: f64,
    /// Σ |λ_ν (d − u_ν)| |Rⁱ| / (lᵀu).
    pub complementarity: f64,
    /// Largest excess (‖𝓕⁻¹λ_t‖ − λ_ν)₊ over the largest λ_ν, with 𝓕 at the solution.
    pub friction_bound: f64,
    /// Missing frictional work Σ |Rⁱ| |λ_ν ‖𝓕 u_t‖ − λ_t·u_t| / (lᵀu): zero exactly when every
    /// pane slides in the direction that the orthotropic law prescribes.
    pub slip_direction: f64,
    /// ‖λ − P(λ − ᾱ r)‖ / ‖λ‖ with the admissible set of the solution itself, g = λ_ν, F = F(u).
    pub fixed_point: f64,
}

impl Certificate {
    pub(super) fn new(solved: &Solved<'_>, friction: &FrictionField, panes: &[PaneState]) -> Self {
        let m = solved.system.coupling.n_panes;
        let area = &solved.mesh.contact.pane_area;
        let normal = &solved.solution.multiplier[..m];
        let pressure = largest(normal.iter().copied());
        let work = solved
            .system
            .load
            .iter()
            .zip(&solved.solution.displacement)
            .map(|(l, u)| l * u)
            .sum::<f64>();
        let product: f64 = (0..m)
            .map(|i| (normal[i] * panes[i].gap).abs() * area[i])
            .sum();
        let missing: f64 = (0..m)
            .map(|i| {
                let pane = &panes[i];
                let [s, f, t] = [pane.slip, pane.friction, pane.tangential_stress];
                let most = normal[i] * (f[0] * s[0]).hypot(f[1] * s[1]);
                area[i] * (most + t[0] * s[0] + t[1] * s[1]).abs()
            })
            .sum();
        let excess = (0..m).map(|i| {
            let t = panes[i].tangential_stress;
            (scaled_norm(t, friction.pane_inverse[i]) - normal[i]).max(0.0)
        });
        Self {
            equilibrium: equilibrium(solved),
            penetration: ratio(
                largest(panes.iter().map(|p| (-p.gap).max(0.0))),
                largest(solved.solution.displacement.iter().copied()),
            ),
            adhesion: ratio(
                largest(normal.iter().map(|l| (-l).max(0.0))),
                largest(solved.solution.multiplier.iter().copied()),
            ),
            complementarity: ratio(product, work.abs()),
            friction_bound: ratio(largest(excess), pressure),
            slip_direction: ratio(missing, work.abs()),
            fixed_point: natural_residual(solved, friction, panes),
        }
    }

    /// The figures with their names, in the order of the file.
    #[must_use]
    pub fn figures(&self) -> [(&'static str, f64); 7] {
        [
            ("equilibrium", self.equilibrium),
            ("penetration", self.penetration),
            ("adhesion", self.adhesion),
            ("complementarity", self.complementarity),
            ("friction_bound", self.friction_bound),
            ("slip_direction", self.slip_direction),
            ("fixed_point", self.fixed_point),
        ]
    }

    /// The largest figure; NaN if any is.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.figures().into_iter().fold(0.0, |worst, (_, value)| {
            if value.is_nan() || value > worst {
                value
            } else {
                worst
            }
        })
    }
}

fn equilibrium(solved: &Solved<'_>) -> f64 {
    let mut residual = solved
        .system
        .coupling
        .nodal_forces(&solved.solution.multiplier);
    let mut stiffness_u = vec![0.0; residual.len()];
    solved
        .system
        .stiffness
        .mul(&solved.solution.displacement, &mut stiffness_u);
    for (i, r) in residual.iter_mut().enumerate() {
        *r += stiffness_u[i] - solved.system.load[i];
    }
    ratio(norm(&residual), norm(&solved.system.load))
}

fn natural_residual(solved: &Solved<'_>, friction: &FrictionField, panes: &[PaneState]) -> f64 {
    let m = panes.len();
    let slip_bound: Vec<f64> = solved.solution.multiplier[..m]
        .iter()
        .map(|l| l.max(0.0))
        .collect();
    let set = FeasibleSet::new(&slip_bound, friction);
    let area = &solved.mesh.contact.pane_area;
    // The gradient r = S λ − h is −(B u) plus the integrated gap.
    let mut step = solved.solution.multiplier.to_vec();
    for (i, pane) in panes.iter().enumerate() {
        step[i] -= solved.solution.steplength * area[i] * pane.gap;
        step[m + 2 * i] += solved.solution.steplength * area[i] * pane.slip[0];
        step[m + 2 * i + 1] += solved.solution.steplength * area[i] * pane.slip[1];
    }
    set.project(&mut step);
    let difference: Vec<f64> = step
        .iter()
        .zip(&solved.solution.multiplier)
        .map(|(a, b)| a - b)
        .collect();
    ratio(norm(&difference), norm(&solved.solution.multiplier))
}

/// The quotient, and 0 for 0/0.
fn ratio(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// max |v|.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, v| most.max(v.abs()))
}

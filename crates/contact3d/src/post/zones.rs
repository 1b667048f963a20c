//! Open, sticking and slipping panes, and their contact quantities.

use super::{ContactReport, Solved, SolvedContact};
use crate::{
    contact::{CoulombLaw, Ellipse, FrictionField},
    linalg::add_scaled,
    mesh::Mesh,
    solver::{ContactSide, Zone},
};

/// The share of the normal force on panes beside open ones from which contact is narrow: all of two panes across, 0.8 of the three across a
/// ball, 0.6 of the three across a strip.
const NARROW: f64 = 0.75;

/// Contact quantities of one pane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaneState {
    /// Open, stick or slip.
    pub zone: Zone,
    /// Normal contact stress σ_ν = −λ_ν in Pa.
    pub normal_stress: f64,
    /// Mean gap d − u_ν in m.
    pub gap: f64,
    /// The tangential quantities; `None` without friction.
    pub friction: Option<PaneFriction>,
}

/// Tangential quantities of one pane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaneFriction {
    /// Tangential contact stress σ_t = −λ_t in Pa.
    pub stress: [f64; 2],
    /// Mean slip (u_t1, u_t2) in m; in a load history that of its step.
    pub slip: [f64; 2],
    /// 1 − ‖𝓕⁻¹λ_t‖/g for the ellipse of the last inner problem: 0 on its boundary, 1 at its
    /// centre; 1 on open panes where g follows the pressure.
    pub margin: f64,
    /// Semi-axes in Pa of the ellipse at the solution itself: g F₁(u), g F₂(u) with the slip bound g of
    /// λ_ν for Coulomb's law.
    pub semi_axes: [f64; 2],
    /// What Coulomb's law makes of the pressure; `None` with Tresca's law.
    pub coulomb: Option<PaneCoulomb>,
}

/// Coulomb's law on one pane at the solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaneCoulomb {
    /// (F₁, F₂) of the pane.
    pub coefficients: [f64; 2],
    /// ‖𝓕⁻¹σ_t‖ in Pa, at most the slip bound.
    pub scaled_stress: f64,
    /// The slip bound g in Pa under the pressure −σ_ν.
    pub slip_bound: f64,
}

/// Share of a bound by which a stress may leave it and is still at rest: histories end with panes at their bound to 1e-14, whose motion of
/// 1e-21 m is rounding.
const ZONE_ROUNDING: f64 = 1e-9;

/// Evaluates every pane.
///
/// A pane slips when the trial stress λ_t + ρ |Rⁱ| u_t leaves its ellipse,
/// ‖𝓕⁻¹(λ_t + ρ |Rⁱ| u_t)‖ > g, with its local stiffness ρ, `[n_multipliers]` in Pa/m³, by more than
/// [rounding](ZONE_ROUNDING). A method may leave a sliding pane inside its ellipse by an error of the size of its tolerance,
/// but its slip carries the trial stress outside.
#[must_use]
pub(super) fn pane_states(
    solved: &Solved<'_>,
    contact: &SolvedContact<'_>,
    friction: Option<(&CoulombLaw, &FrictionField)>,
    stiffness: &[f64],
) -> Vec<PaneState> {
    let layout = contact.coupling.layout;
    let solution = solved.solution;
    let surface = contact.state.surface;
    let mut integral = contact.coupling.integrate(&solution.displacement);
    let frame = &contact.state.interface.frame;
    let dofs = &solved.system.dofs;
    let held = contact.coupling.held_integrals(surface, frame, dofs);
    add_scaled(&mut integral, 1.0, &held);
    let laws = contact.state.laws();
    let set = laws.feasible_set(solution.friction.as_ref().map(|it| &it.coulomb));
    let gap = contact.state.interface.gap.as_deref();
    let previous = contact.state.interface.previous.as_ref();
    let origin = |pane: usize, k: usize| previous.map_or(0.0, |it| it.pane_tangential[pane][k]);
    (0..layout.n_panes())
        .map(|i| {
            let area = surface.pane_area[i];
            let normal = solution.multiplier[i];
            let gap = gap.map_or(0.0, |d| surface.pane_mean(i, d)) - integral[i] / area;
            let closing_pressure = stiffness[layout.normal(i)] * area * gap;
            let pressed = normal > 0.0 && normal > ZONE_ROUNDING * closing_pressure;
            let pair = |v: &[f64]| layout.pair(v, i);
            let tangential = set.ellipses.get(i).map(|ellipse| {
                let stress = pair(&solution.multiplier);
                let total = pair(&integral).map(|v| v / area);
                let slip = [0, 1].map(|k| total[k] - origin(i, k));
                let step = pair(stiffness).map(|rho| rho * area);
                let trial = [0, 1].map(|c| stress[c] + step[c] * slip[c]);
                let sticks = level(ellipse, trial) <= 1.0 + ZONE_ROUNDING;
                let coulomb = friction.map(|(law, field)| (law, field.pane_inverse[i]));
                let state = PaneFriction {
                    stress: stress.map(|t| 0.0 - t),
                    slip,
                    margin: if pressed || coulomb.is_none() {
                        1.0 - level(ellipse, stress)
                    } else {
                        1.0
                    },
                    semi_axes: match coulomb {
                        Some((law, inverse)) => {
                            let slip_bound = law.slip_bound(i, normal.max(0.0));
                            inverse.map(|f| slip_bound / f)
                        }
                        None => ellipse.semi_axes,
                    },
                    coulomb: coulomb.map(|(law, inverse)| PaneCoulomb {
                        coefficients: inverse.map(f64::recip),
                        scaled_stress: scaled_norm(stress, inverse),
                        slip_bound: law.slip_bound(i, normal),
                    }),
                };
                (state, sticks)
            });
            PaneState {
                zone: match (pressed, tangential) {
                    (false, _) => Zone::Open,
                    (true, Some((_, true))) => Zone::Stick,
                    (true, _) => Zone::Slip,
                },
                normal_stress: 0.0 - normal,
                gap,
                friction: tangential.map(|(state, _)| state),
            }
        })
        .collect()
}

/// ‖(t₁/a, t₂/b)‖, and 1 for a point on a vanishing ellipse.
fn level(ellipse: &Ellipse, point: [f64; 2]) -> f64 {
    match (ellipse.semi_axes == [0.0; 2], point == [0.0; 2]) {
        (true, true) => 1.0,
        (true, false) => f64::INFINITY,
        _ => ellipse.level(point),
    }
}

/// ‖diag(inverse) v‖.
pub(super) fn scaled_norm(v: [f64; 2], inverse: [f64; 2]) -> f64 {
    (v[0] * inverse[0]).hypot(v[1] * inverse[1])
}

impl ContactReport {
    /// The share of the normal force on panes that lie beside an open one, where it is so large that no mesh of such panes tells how the pressure
    /// falls towards the edge of contact; `None` where panes tell.
    #[must_use]
    pub fn narrow_share(&self, mesh: &Mesh, side: ContactSide<'_>) -> Option<f64> {
        let surface = side.surface;
        let force = |pane: usize| -self.panes[pane].normal_stress * surface.pane_area[pane];
        let panes = 0..self.panes.len();
        let beside = surface.panes_beside(mesh);
        let is_open = |pane: &usize| self.panes[*pane].zone == Zone::Open;
        let is_at_edge = |pane: &usize| beside[*pane].iter().any(is_open);
        let at_edge: f64 = panes.clone().filter(is_at_edge).map(force).sum();
        let share = at_edge / panes.map(force).sum::<f64>();
        (share > NARROW).then_some(share)
    }
}

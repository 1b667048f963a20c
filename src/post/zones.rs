use super::Solved;
use crate::contact::FrictionField;

/// What a pane of the contact face does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Zone {
    /// No contact stress.
    Open = 0,
    /// In contact, the trial stress inside its ellipse: no slip.
    Stick = 1,
    /// In contact, the trial stress outside its ellipse: the pane slides.
    Slip = 2,
}

/// Contact quantities of one pane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaneState {
    /// Open, stick or slip.
    pub zone: Zone,
    /// 1 − ‖𝓕⁻¹λ_t‖/g for the ellipse of the last inner problem: 0 on its boundary, 1 at its
    /// centre; 1 on open panes.
    pub margin: f64,
    /// Normal contact stress σ_ν = −λ_ν in Pa.
    pub normal_stress: f64,
    /// Tangential contact stress σ_t = −λ_t in Pa.
    pub tangential_stress: [f64; 2],
    /// ‖𝓕⁻¹σ_t‖ in Pa, at most −σ_ν, for the friction at the solution.
    pub scaled_tangential_stress: f64,
    /// Mean slip (u_t1, u_t2) in m.
    pub slip: [f64; 2],
    /// Mean gap d − u_ν in m.
    pub gap: f64,
    /// (F₁, F₂) of the pane at the solution.
    pub friction: [f64; 2],
}

/// Evaluates every pane.
///
/// A pane slips when the trial stress λ_t + ᾱ |Rⁱ| u_t of a projected gradient step leaves its
/// ellipse, ‖𝓕⁻¹(λ_t + ᾱ |Rⁱ| u_t)‖ > g. Unlike the margin alone this needs no tolerance: conjugate
/// gradients may leave a sliding pane inside its ellipse by an error of the size of the inner
/// tolerance, but its slip carries the trial stress outside.
#[must_use]
pub fn pane_states(solved: &Solved<'_>, friction: &FrictionField) -> Vec<PaneState> {
    let m = solved.system.coupling.n_panes;
    let integral = solved
        .system
        .coupling
        .integrate(&solved.solution.displacement);
    (0..m)
        .map(|i| {
            let area = solved.mesh.contact.pane_area[i];
            let normal = solved.solution.multiplier[i];
            let tangential = [
                solved.solution.multiplier[m + 2 * i],
                solved.solution.multiplier[m + 2 * i + 1],
            ];
            let slip = [integral[m + 2 * i] / area, integral[m + 2 * i + 1] / area];
            let inverse = solved.solution.friction.pane_inverse[i];
            let bound = solved.solution.slip_bound[i];
            let step = solved.solution.steplength * area;
            let trial = [0, 1].map(|c| tangential[c] + step * slip[c]);
            let zone = match (normal > 0.0, scaled_norm(trial, inverse) > bound) {
                (false, _) => Zone::Open,
                (true, false) => Zone::Stick,
                (true, true) => Zone::Slip,
            };
            let margin = match zone {
                Zone::Open => 1.0,
                _ if bound == 0.0 => 0.0,
                _ => 1.0 - scaled_norm(tangential, inverse) / bound,
            };
            PaneState {
                zone,
                margin,
                normal_stress: 0.0 - normal,
                tangential_stress: tangential.map(|t| 0.0 - t),
                scaled_tangential_stress: scaled_norm(tangential, friction.pane_inverse[i]),
                slip,
                gap: solved.scene.contact.gap - integral[i] / area,
                friction: friction.pane(i),
            }
        })
        .collect()
}

/// ‖diag(inverse) v‖.
pub(super) fn scaled_norm(v: [f64; 2], inverse: [f64; 2]) -> f64 {
    (v[0] * inverse[0]).hypot(v[1] * inverse[1])
}

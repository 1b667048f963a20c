use super::Solved;
use crate::contact::FrictionField;

/// What a pane of the contact face does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Zone {
    /// No contact stress.
    Open = 0,
    /// In contact, the tangential stress inside its ellipse.
    Stick = 1,
    /// In contact, the tangential stress on the boundary of its ellipse.
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

/// The tangential stress reaches the boundary of its ellipse when the margin is below this: far
/// above the rounding of a projection (1e-15), far below any margin that an inner tolerance of
/// practical size leaves on a sticking pane.
const ON_BOUNDARY: f64 = 1e-9;

/// Evaluates every pane.
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
            let used = scaled_norm(tangential, solved.solution.friction.pane_inverse[i]);
            let margin = if normal > 0.0 && solved.solution.slip_bound[i] > 0.0 {
                1.0 - used / solved.solution.slip_bound[i]
            } else {
                1.0
            };
            PaneState {
                zone: match (normal > 0.0, margin > ON_BOUNDARY) {
                    (false, _) => Zone::Open,
                    (true, true) => Zone::Stick,
                    (true, false) => Zone::Slip,
                },
                margin,
                normal_stress: 0.0 - normal,
                tangential_stress: tangential.map(|t| 0.0 - t),
                scaled_tangential_stress: scaled_norm(tangential, friction.pane_inverse[i]),
                slip: [integral[m + 2 * i] / area, integral[m + 2 * i + 1] / area],
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

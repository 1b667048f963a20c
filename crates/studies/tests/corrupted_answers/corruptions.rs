//! The answers of a case, changed by a known amount.
//!
//! A multiplier is changed twice: with the displacement left as it was, which equilibrium must
//! show, ‖Bᵀδ‖ / ‖l‖ for a change δ; and with the displacement that belongs to it, u = A⁻¹(l −
//! Bᵀλ), which satisfies equilibrium and which only the conditions of contact can show. Those are
//! measured by λ − P(λ − ρ r) with the stiffness ρ_i = (S⁻¹)_ii. On a pressed pane that is ρ_i S_ii
//! δ ≥ δ in the normal component; a tangential pair has one ρ, half the trace of its block of S⁻¹,
//! so that ρ times the smaller eigenvalue of its block of S is ½ at least, and the larger of two
//! components is 1/√2 of their length: δ/3 remains, whichever way the projection on the ellipse
//! contracts.

use contact3d::{post::Zone, solver::Solution};

use crate::case::{Case, norm};

/// The relative size of the small changes.
pub(crate) const SMALL: f64 = 1e-6;

/// Rounding of the amounts themselves, and of terms of second order.
const ROUNDED: f64 = 0.99;

/// A wrong answer with the least that the certificate must show.
pub(crate) struct Corruption {
    pub(crate) what: String,
    pub(crate) solution: Solution,
    pub(crate) expected: f64,
}

/// All that the zones of the case allow.
pub(crate) fn all(case: &Case) -> Vec<Corruption> {
    let mut corruptions = Vec::new();
    corruptions.extend(moved_pressure(case));
    corruptions.extend(pressed_open_pane(case));
    corruptions.extend(pulled_open_pane(case));
    corruptions.extend(displaced_nodes(case));
    corruptions.extend(slipping_force_on_a_sticking_pane(case));
    corruptions.extend(sticking_force_on_a_slipping_pane(case));
    corruptions.extend(rotated_slip_direction(case));
    corruptions
}

/// λ_ν of the pane that bears most, 1e-6 too large.
fn moved_pressure(case: &Case) -> Vec<Corruption> {
    let pane = case.most_pressed();
    let change = SMALL * case.solution.multiplier[pane];
    both(case, "a pressure moved", &[(pane, change)], SMALL)
}

/// An open pane under a millionth of the largest pressure: its gap stays open and P(λ − ρ r) is 0,
/// so all of it shows.
fn pressed_open_pane(case: &Case) -> Vec<Corruption> {
    let change = SMALL * case.pressure();
    let pane = case.pane(Zone::Open);
    pane.map_or_else(Vec::new, |pane| {
        both(case, "an open pane pressed", &[(pane, change)], SMALL)
    })
}

/// An open pane under a millionth of the largest pressure as a pull: adhesion, of just this size.
fn pulled_open_pane(case: &Case) -> Vec<Corruption> {
    let change = -SMALL * case.pressure();
    let pane = case.pane(Zone::Open);
    let corruptions = pane.map_or_else(Vec::new, |pane| {
        both(case, "an open pane pulled", &[(pane, change)], SMALL)
    });
    corruptions.into_iter().skip(1).collect()
}

/// One component at one node displaced by a millionth of the largest displacement: at a contact
/// node and at the node numbered last. What it leaves is a column of A, ‖A e‖ δ / ‖l‖.
fn displaced_nodes(case: &Case) -> Vec<Corruption> {
    let primal = &case.problem.system.assembly.primal;
    let largest = case
        .solution
        .displacement
        .iter()
        .fold(0.0, |most: f64, u| most.max(u.abs()));
    let on_the_face = case.contact().coupling.transposed.indices[0];
    let last = primal.load.len() - 1;
    let displaced = |dof: usize| {
        let change = SMALL * largest;
        let mut solution = case.solution.clone();
        solution.displacement[dof] += change;
        let column = primal.stiffness.indptr[dof]..primal.stiffness.indptr[dof + 1];
        let forces = norm(&primal.stiffness.data[column]) * change;
        Corruption {
            what: format!("degree of freedom {dof} displaced"),
            solution,
            expected: ROUNDED * forces / norm(&primal.load),
        }
    };
    vec![displaced(on_the_face), displaced(last)]
}

/// λ_t of a sticking pane moved out to its ellipse, in its own direction or along t₁.
fn slipping_force_on_a_sticking_pane(case: &Case) -> Vec<Corruption> {
    let Some(pane) = case.pane(Zone::Stick) else {
        return Vec::new();
    };
    let (stress, [a, b]) = friction_of(case, pane);
    let level = (stress[0] / a).hypot(stress[1] / b);
    let change = stress.map(|t| t * (1.0 / level - 1.0));
    tangential(case, "a sticking pane given a slipping force", pane, change)
}

/// λ_t of a slipping pane halved, so that it lies deep inside its ellipse.
fn sticking_force_on_a_slipping_pane(case: &Case) -> Vec<Corruption> {
    let Some(pane) = case.pane(Zone::Slip).filter(|_| case.shear() > 0.0) else {
        return Vec::new();
    };
    let (stress, _) = friction_of(case, pane);
    let change = stress.map(|t| -0.5 * t);
    tangential(case, "a slipping pane given a sticking force", pane, change)
}

/// λ_t of a slipping pane moved along its ellipse (a cos θ, b sin θ) by 1e-6 in θ: friction is
/// neither too large nor too small, only its direction is wrong.
fn rotated_slip_direction(case: &Case) -> Vec<Corruption> {
    let Some(pane) = case.pane(Zone::Slip).filter(|_| case.shear() > 0.0) else {
        return Vec::new();
    };
    let (stress, [a, b]) = friction_of(case, pane);
    let change = [-SMALL * stress[1] * a / b, SMALL * stress[0] * b / a];
    tangential(case, "the direction of slip rotated", pane, change)
}

/// λ_t and the semi-axes of the ellipse at the solution, in Pa.
fn friction_of(case: &Case, pane: usize) -> ([f64; 2], [f64; 2]) {
    let friction = case.report.panes[pane].friction.expect("friction");
    (friction.stress.map(|t| -t), friction.semi_axes)
}

fn tangential(case: &Case, what: &str, pane: usize, change: [f64; 2]) -> Vec<Corruption> {
    let at = case.n_panes() + 2 * pane;
    let size = change[0].hypot(change[1]) / case.shear();
    let changes = [(at, change[0]), (at + 1, change[1])];
    both(case, what, &changes, size / 3.0)
}

/// λ + δ with the displacement of λ, and with its own; `residual` is the least that the conditions
/// of contact must show of the second.
fn both(case: &Case, what: &str, changes: &[(usize, f64)], residual: f64) -> Vec<Corruption> {
    let load = &case.problem.system.assembly.primal.load;
    let imbalance = norm(&forces(case, changes)) / norm(load);
    vec![
        Corruption {
            what: format!("{what}, the displacement left"),
            solution: changed(case, changes),
            expected: ROUNDED * imbalance,
        },
        Corruption {
            what: format!("{what}, with its displacement"),
            solution: with_its_displacement(case, changes),
            expected: ROUNDED * residual,
        },
    ]
}

/// λ + δ with the displacement A⁻¹(l − Bᵀ(λ + δ)).
pub(crate) fn with_its_displacement(case: &Case, changes: &[(usize, f64)]) -> Solution {
    let assembly = &case.problem.system.assembly;
    let moved = assembly.solve(&forces(case, changes));
    let mut solution = changed(case, changes);
    for (u, moved) in solution.displacement.iter_mut().zip(&moved) {
        *u -= moved;
    }
    solution
}

/// λ + δ with the displacement of λ.
fn changed(case: &Case, changes: &[(usize, f64)]) -> Solution {
    let mut solution = case.solution.clone();
    for &(j, delta) in changes {
        solution.multiplier[j] += delta;
    }
    solution
}

/// Bᵀδ.
fn forces(case: &Case, changes: &[(usize, f64)]) -> Vec<f64> {
    let mut change = vec![0.0; case.solution.multiplier.len()];
    for &(j, delta) in changes {
        change[j] = delta;
    }
    case.contact().coupling.nodal_forces(&change)
}

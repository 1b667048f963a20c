//! The proximal point method on the rigid motions of a body that only contact holds, or beside it weak springs.
//!
//! Where panes open, contact may leave a rigid motion free within an interval: the matrix of Newton's method in (λ, α) is singular at
//! the solution, and its α runs away. With a force −k (α − α₀) in the balance of forces,
//!
//!   Gᵀλ + D α + k (α − α₀) = e,
//!
//! no matrix is singular. Each pass solves this problem and takes its α for the next α₀, so that the force vanishes by itself and the
//! balance becomes exact at a finite k. The first k is the stiffness of the bonded face, λ_max(GᵀS⁻¹G) with columns of G of length
//! one; smaller ones need fewer passes. For convex problems the method converges from any α₀ (R. T. Rockafellar, *SIAM J. Control
//! Optim.* 14 (1976) 877); with Coulomb's law this is measured, not proven. Where no equilibrium exists, α runs away pass by pass.

use nalgebra::DMatrix;

use super::{NewtonSolution, driver::NewtonDriver};
use crate::{
    dual::{ExplicitDual, LocalStiffness},
    linalg::{dot, norm},
    solver::{NewtonStep, tolerances::ZONES_TOLERANCE},
};

/// Most passes: solutions take a median of four.
const PROXIMAL_MAX_PASSES: usize = 14;

/// Ratio of k in the second pass to the first one, of each later k to the one before, and of the least of all to the first: the second pass
/// starts near the solution and converges with far less; k ≥ 1e-9 leaves pivots above rounding.
const FIRST_REDUCTION: f64 = 1e-2;
const LATER_REDUCTION: f64 = 1e-1;
const LEAST_PROXIMAL_STIFFNESS: f64 = 1e-9;

/// Growth of k after a pass without a solution: two such passes take back what one later reduction gave.
const PROXIMAL_GROWTH: f64 = 4.0;

/// Ratio of k in refinement to the first one: stiff enough for matrices without zero pivots.
const REFINEMENT_STIFFNESS: f64 = 1e-3;

/// Runs the method; solutions of its passes that do not solve the problem without k are none.
pub(in crate::solver) fn proximal_point(
    driver: &NewtonDriver<'_>,
    observe: &mut dyn FnMut(usize, &NewtonStep),
) -> NewtonSolution {
    let stiffness = bonded_stiffness(driver.dual, driver.local);
    let mut found = NewtonSolution::failed(driver.dual);
    let mut last: Option<Vec<f64>> = None;
    let mut k = 1.0;
    for pass in 0..PROXIMAL_MAX_PASSES {
        let centre = last.as_ref().map_or_else(
            || vec![0.0; stiffness.len()],
            |unknowns| driver.dual.motion(unknowns).to_vec(),
        );
        let terms: Vec<f64> = stiffness.iter().map(|s| k * s).collect();
        let dual = driver.dual.with_proximal_term(&terms, &centre);
        let constrained = NewtonDriver {
            dual: &dual,
            ..*driver
        };
        let bonded = || driver.local.bonded_start(&dual);
        let start = last.clone().unwrap_or_else(bonded);
        let done = found.history.len();
        let next = constrained.from(start, &mut |i, step| observe(done + i, step));
        let is_solved = next.stop.is_solution();
        found = found.merged_with(next);
        if !is_solved {
            k *= PROXIMAL_GROWTH;
            continue;
        }
        found.residual = driver.residual(&found.unknowns);
        if found.residual <= ZONES_TOLERANCE {
            return found;
        }
        last = Some(found.unknowns.clone());
        let reduction = match pass {
            0 => FIRST_REDUCTION,
            _ => LATER_REDUCTION,
        };
        k = (k * reduction).max(LEAST_PROXIMAL_STIFFNESS);
    }
    // The last pass still needs the force −k (α − α₀), so it is no solution.
    NewtonSolution {
        history: found.history,
        evaluations: found.evaluations,
        ..NewtonSolution::failed(driver.dual)
    }
}

/// The problem about an iterate, with the proximal term about its own motion.
pub(in crate::solver) fn about_own_motion(
    dual: &ExplicitDual,
    local: &LocalStiffness,
) -> ExplicitDual {
    let stiffness = bonded_stiffness(dual, local);
    let terms: Vec<f64> = stiffness.iter().map(|s| REFINEMENT_STIFFNESS * s).collect();
    dual.with_proximal_term(&terms, &vec![0.0; terms.len()])
}

/// λ_max(ĜᵀS⁻¹Ĝ) ‖G_p‖² of each motion in N/m, with columns Ĝ_p = G_p/‖G_p‖.
fn bonded_stiffness(dual: &ExplicitDual, local: &LocalStiffness) -> Vec<f64> {
    let Some(equilibrium) = &dual.rigid else {
        return Vec::new();
    };
    let integrals = &equilibrium.coupling.integrals;
    let sizes: Vec<f64> = integrals.iter().map(|g| norm(g)).collect();
    let bonded: Vec<Vec<f64>> = integrals.iter().map(|g| local.bonded(g)).collect();
    let n = sizes.len();
    let product = |p: usize, q: usize| match sizes[p] * sizes[q] {
        0.0 => 0.0,
        size => dot(&integrals[p], &bonded[q]) / size,
    };
    let largest = DMatrix::from_fn(n, n, product).symmetric_eigenvalues();
    let largest = largest.iter().fold(0.0, |most: f64, k| most.max(*k));
    sizes.iter().map(|size| largest * size * size).collect()
}

//! Frictional contact problems that are given by a Delassus matrix alone: u = W r + q with Coulomb's law between u and r.
//!
//! They come from other programs, of rigid bodies too, so W may be sparse and only positive semidefinite: where bodies
//! rest on more contacts than hold them, forces are not unique. `problem` is the problem and its error, `scaled` the
//! same in the order and units of the solvers, `gauss_seidel` one contact after the other, `proximal` Newton's method on dense or sparse matrices, `descent` the same from easier problems, `frozen` successive
//! approximations with GPCG, `separation` proofs that there is no solution; `frozen_law` makes such a problem of a solved one of a body.

mod descent;
mod frozen_law;
mod gauss_seidel;
mod problem;
mod proximal;
mod scaled;
mod separation;
#[cfg(test)]
mod tests;

pub use frozen_law::{FrozenGlobal, FrozenScaling, frozen_global, frozen_local};
pub use problem::{DelassusError, DelassusProblem};

pub use separation::{Obstruction, Separation};

use scaled::{MatrixForm, Scaled};
use separation::separation;

/// Contacts up to which `auto` takes Newton's method where its matrices are dense.
pub const MOST_DENSE_CONTACTS: usize = 2000;

/// How to solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DelassusMethod {
    /// Gauss–Seidel while it promises to end soon, then Newton's method, then GPCG where that fails; without Newton's method for some
    /// thousand contacts that all move each other.
    #[default]
    Auto,
    /// Newton's method, on sparse matrices where W has a sparse factor.
    Newton,
    /// Successive approximations of the slip bounds, with GPCG on the matrix as it is.
    Gpcg,
    /// Nonlinear Gauss–Seidel, contact by contact.
    Nsgs,
}

/// What is asked of a solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DelassusSettings {
    /// How.
    pub method: DelassusMethod,
    /// Largest [`DelassusProblem::error`], and largest error of the problem scaled to a unit diagonal.
    pub tolerance: f64,
}

impl Default for DelassusSettings {
    fn default() -> Self {
        Self {
            method: DelassusMethod::Auto,
            tolerance: 1e-10,
        }
    }
}

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DelassusStatus {
    /// Both errors are within the tolerance.
    Converged,
    /// They are not, and nothing is left to try.
    NotConverged,
    /// They are not, and [`Separation`] proves that no forces exist.
    NoSolution,
    /// A value was not finite.
    NumericalError,
}

/// Which algorithm gave the forces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DelassusSolver {
    /// Newton's method.
    Newton,
    /// Successive approximations with GPCG.
    Gpcg,
    /// Nonlinear Gauss–Seidel.
    Nsgs,
}

/// Forces, and how good they are.
#[derive(Debug, Clone, PartialEq)]
pub struct DelassusSolution {
    /// How the solve ended.
    pub status: DelassusStatus,
    /// Which algorithm gave the forces.
    pub solver: DelassusSolver,
    /// r, components N, T1, T2 contact after contact, `[3 n]`.
    pub force: Vec<f64>,
    /// u = W r + q, `[3 n]`.
    pub velocity: Vec<f64>,
    /// [`DelassusProblem::error`] of the forces.
    pub error: f64,
    /// The residual of [`DelassusProblem::error`], or what the last digit of a force moves if that is more, over ‖q‖, of the problem
    /// scaled to a unit diagonal: it does not depend on units, and forces without bound do not make it small.
    pub scaled_error: f64,
    /// Why a problem that did not converge has no solution, or none without slip; `None` where no reason was found.
    pub separation: Option<Separation>,
    /// Steps of Newton's method.
    pub newton_steps: usize,
    /// Outer steps: proximal ones of Newton's method, successive approximations, or sweeps.
    pub outer_steps: usize,
    /// Products with W; those of dense ones in Newton's method count as well.
    pub applications: usize,
}

/// One way to a solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Attempt {
    /// Nonlinear Gauss–Seidel.
    GaussSeidel,
    /// Newton's method on the problem itself, or by proximal steps where W is singular.
    Newton,
    /// Newton's method from easier problems.
    Descent,
    /// Successive approximations with GPCG.
    Gpcg,
}

/// Solves a problem; one that does not converge is a result with a status.
///
/// A proof that there is no solution is looked for once Newton's method has failed, where it is tried at all.
#[must_use]
pub fn solve_delassus(problem: &DelassusProblem, settings: &DelassusSettings) -> DelassusSolution {
    use DelassusMethod::{Auto, Gpcg, Newton, Nsgs};
    let scaled = Scaled::new(problem);
    let has_form = matches!(settings.method, Auto | Newton);
    let form = if has_form && problem.is_sparse() {
        MatrixForm::Sparse
    } else {
        MatrixForm::Dense
    };
    let is_small = problem.n_contacts() <= MOST_DENSE_CONTACTS || form == MatrixForm::Sparse;
    let ways: &[Attempt] = match settings.method {
        Newton => &[Attempt::Newton, Attempt::Descent],
        Auto if is_small => &[
            Attempt::GaussSeidel,
            Attempt::Newton,
            Attempt::Descent,
            Attempt::Gpcg,
        ],
        Auto => &[Attempt::GaussSeidel, Attempt::Gpcg],
        Gpcg => &[Attempt::Gpcg],
        Nsgs => &[Attempt::GaussSeidel],
    };
    let (mut newton_steps, mut outer_steps, mut applications) = (0, 0, 0);
    let mut attempt = |way: Attempt| {
        let found = match way {
            Attempt::GaussSeidel => {
                gauss_seidel::solve(&scaled, form, settings.tolerance, settings.method == Nsgs)
            }
            Attempt::Newton => proximal::solve(&scaled, form, settings.tolerance),
            Attempt::Descent => descent::solve(&scaled, form, settings.tolerance),
            Attempt::Gpcg => frozen_law::solve(&scaled, settings.tolerance),
        };
        newton_steps += found.newton_steps;
        outer_steps += found.outer_steps;
        applications += found.applications;
        let solver = match way {
            Attempt::Newton | Attempt::Descent => DelassusSolver::Newton,
            Attempt::Gpcg => DelassusSolver::Gpcg,
            Attempt::GaussSeidel => DelassusSolver::Nsgs,
        };
        judged(problem, &scaled, settings, solver, &found.multiplier)
    };
    let proves = ways.contains(&Attempt::Newton);
    let prove = |obstruction| proves.then(|| separation(&scaled, obstruction)).flatten();
    let mut best = attempt(ways[0]);
    for (before, way) in ways.iter().zip(&ways[1..]) {
        if best.status != DelassusStatus::Converged && *before == Attempt::Newton {
            best.separation = prove(Obstruction::Penetration);
        }
        if best.status == DelassusStatus::Converged || best.separation.is_some() {
            break;
        }
        let next = attempt(*way);
        if next.is_better_than(&best) {
            best = next;
        }
    }
    match (best.status, &best.separation) {
        (DelassusStatus::Converged, _) => {}
        (_, Some(_)) => best.status = DelassusStatus::NoSolution,
        (_, None) => best.separation = prove(Obstruction::Sticking),
    }
    DelassusSolution {
        newton_steps,
        outer_steps,
        applications,
        ..best
    }
}

impl DelassusSolution {
    /// The larger of the two errors.
    #[must_use]
    pub fn worst_error(&self) -> f64 {
        self.error.max(self.scaled_error)
    }

    fn is_better_than(&self, other: &Self) -> bool {
        let is_number = |solution: &Self| solution.status != DelassusStatus::NumericalError;
        is_number(self) && (!is_number(other) || self.worst_error() < other.worst_error())
    }
}

/// What a solver came to.
struct Candidate {
    /// In the order and units of [`Scaled`].
    multiplier: Vec<f64>,
    newton_steps: usize,
    outer_steps: usize,
    applications: usize,
}

impl Candidate {
    /// Nothing done.
    fn zero(scaled: &Scaled<'_>) -> Self {
        Self {
            multiplier: vec![0.0; scaled.rhs.len()],
            newton_steps: 0,
            outer_steps: 0,
            applications: 0,
        }
    }
}

fn judged(
    problem: &DelassusProblem,
    scaled: &Scaled<'_>,
    settings: &DelassusSettings,
    solver: DelassusSolver,
    multiplier: &[f64],
) -> DelassusSolution {
    let force = scaled.forces(multiplier);
    let velocity = problem.velocity(&force);
    let error = problem.error_with(&force, &velocity);
    let scaled_error = scaled.scaled_error(multiplier);
    let status = if !(error.is_finite() && scaled_error.is_finite()) {
        DelassusStatus::NumericalError
    } else if error <= settings.tolerance && scaled_error <= settings.tolerance {
        DelassusStatus::Converged
    } else {
        DelassusStatus::NotConverged
    };
    DelassusSolution {
        status,
        solver,
        force,
        velocity,
        error,
        scaled_error,
        separation: None,
        newton_steps: 0,
        outer_steps: 0,
        applications: 0,
    }
}

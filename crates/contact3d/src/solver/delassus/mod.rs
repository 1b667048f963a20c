//! Frictional contact problems that are given by a Delassus matrix alone: u = W r + q with Coulomb's law between u and r.
//!
//! They come from other programs, of rigid bodies too, so W may be sparse and only positive semidefinite: where bodies
//! rest on more contacts than hold them, forces are not unique. `problem` is the problem and its error, `scaled` the
//! same in the order and units of the solvers, `proximal` Newton's method on dense or sparse matrices, `frozen` successive approximations with GPCG; `frozen_law` makes such a problem of a solved one of a body.

#[cfg(test)]
mod form_tests;
mod frozen;
mod frozen_law;
mod problem;
mod proximal;
mod scaled;
#[cfg(test)]
mod tests;

pub use frozen_law::{FrozenGlobal, FrozenScaling, frozen_global, frozen_local};
pub use problem::{DelassusError, DelassusProblem};

use scaled::{Form, Scaled};

/// Contacts up to which `auto` takes Newton's method where its matrices are dense.
pub const MOST_DENSE_CONTACTS: usize = 2000;

/// How to solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DelassusMethod {
    /// Newton's method, then GPCG where that fails; GPCG alone for some thousand contacts that all move each other.
    #[default]
    Auto,
    /// Newton's method, on sparse matrices where W has a sparse factor.
    Newton,
    /// Successive approximations of the slip bounds, with GPCG on the matrix as it is.
    Gpcg,
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
    /// ‖r − P(r − û)‖ / ‖q‖ of the problem scaled to a unit diagonal, which does not depend on units.
    pub scaled_error: f64,
    /// Steps of Newton's method.
    pub newton_steps: usize,
    /// Outer steps: proximal ones of Newton's method, or successive approximations.
    pub outer_steps: usize,
    /// Products with W; those of dense ones in Newton's method count as well.
    pub applications: usize,
}

/// Solves a problem; one that does not converge is a result with a status.
#[must_use]
pub fn solve_delassus(problem: &DelassusProblem, settings: &DelassusSettings) -> DelassusSolution {
    use DelassusMethod::{Auto, Gpcg, Newton};
    let scaled = Scaled::new(problem);
    let form = match settings.method != Gpcg && problem.is_sparse() {
        true => Form::Sparse,
        false => Form::Dense,
    };
    let is_small = problem.n_contacts() <= MOST_DENSE_CONTACTS || form == Form::Sparse;
    let solvers: &[DelassusSolver] = match settings.method {
        Newton => &[DelassusSolver::Newton],
        Gpcg => &[DelassusSolver::Gpcg],
        Auto if is_small => &[DelassusSolver::Newton, DelassusSolver::Gpcg],
        Auto => &[DelassusSolver::Gpcg],
    };
    let mut best: Option<DelassusSolution> = None;
    let (mut newton_steps, mut outer_steps, mut applications) = (0, 0, 0);
    for solver in solvers {
        let found = match solver {
            DelassusSolver::Newton => proximal::solve(&scaled, form, settings.tolerance),
            DelassusSolver::Gpcg => frozen::solve(&scaled, settings.tolerance),
        };
        newton_steps += found.newton_steps;
        outer_steps += found.outer_steps;
        applications += found.applications;
        let next = judged(problem, &scaled, settings, *solver, &found.multiplier);
        let worst = |solution: &DelassusSolution| solution.error.max(solution.scaled_error);
        // NaN is no progress.
        if best.as_ref().is_none_or(|best| worst(&next) < worst(best)) {
            best = Some(next);
        }
        if best
            .as_ref()
            .is_some_and(|best| best.status == DelassusStatus::Converged)
        {
            break;
        }
    }
    DelassusSolution {
        newton_steps,
        outer_steps,
        applications,
        ..best.expect("there is always a solver")
    }
}

/// What a solver came to.
struct Found {
    /// In the order and units of [`Scaled`].
    multiplier: Vec<f64>,
    newton_steps: usize,
    outer_steps: usize,
    applications: usize,
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
        newton_steps: 0,
        outer_steps: 0,
        applications: 0,
    }
}

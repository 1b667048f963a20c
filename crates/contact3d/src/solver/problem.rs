//! A problem to solve: where a solve begins, and what its observer sees.

use thiserror::Error;

use super::{ContactBody, NewtonStep, OuterStep, PaneLaws, Solution};
use crate::{dual::ContactSystem, scene::SolveSettings};

/// A contact problem, and how to solve it.
pub(super) struct DiscreteProblem<'a> {
    /// S and h, and the balance of a body that floats.
    pub(super) dual: &'a ContactSystem,
    pub(super) laws: &'a PaneLaws,
    /// Where exact residuals come from.
    pub(super) body: ContactBody<'a>,
    pub(super) settings: &'a SolveSettings,
    pub(super) start: Start<'a>,
}

impl DiscreteProblem<'_> {
    /// The unknowns of an answer: its multipliers, and its rigid motions where the body floats.
    pub(super) fn unknowns(&self, solution: &Solution) -> Vec<f64> {
        let mut unknowns = solution.multiplier.clone();
        unknowns.extend(&solution.rigid_motion);
        unknowns.resize(self.dual.n_unknowns(), 0.0);
        unknowns
    }
}

/// What an observer of a solve sees.
#[derive(Debug, Clone, Copy)]
pub enum Progress<'a> {
    /// Step k of successive approximations.
    Outer(usize, &'a OuterStep),
    /// Successive approximations between two steps.
    Between(&'a OuterState),
    /// Step k of Newton's method.
    Newton(usize, &'a NewtonStep),
}

/// Where a solve begins; λ = 0 by default. What does not fit the number of multipliers is left out.
#[derive(Debug, Clone, Copy, Default)]
pub struct Start<'a> {
    /// The multipliers of a similar problem, `[n_multipliers]`, in Pa.
    pub multiplier: Option<&'a [f64]>,
    /// Successive approximations go on from here.
    pub checkpoint: Option<&'a OuterState>,
}

/// Successive approximations between two steps: all that the next step depends on, so that a solve
/// that goes on from here gives the same bits.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OuterState {
    /// λ, `[n_multipliers]`, in Pa.
    pub multiplier: Vec<f64>,
    /// φ at the contact nodes in m; `None` unless friction follows the slip.
    pub slip: Option<Vec<[f64; 2]>>,
    /// Tolerance of the last inner problem.
    pub tolerance: f64,
    /// Steplength ᾱ, in Pa/m³.
    pub steplength: f64,
    /// The steps done.
    pub history: Vec<OuterStep>,
    /// Evaluations of the friction law so far.
    pub law_evaluations: usize,
    /// Projections on an ellipse so far.
    pub projections: usize,
}

impl Start<'_> {
    /// What of this start fits.
    pub(super) fn fitting(self, n_multipliers: usize) -> Self {
        Self {
            multiplier: self.multiplier.filter(|m| m.len() == n_multipliers),
            checkpoint: self
                .checkpoint
                .filter(|state| state.multiplier.len() == n_multipliers),
        }
    }
}

/// A method that needs what the assembled problem does not hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error(
    "{0} needs the explicit dual operator, but /assemble holds the implicit one; \
     set assemble.dual_operator = \"explicit\" (`assemble --dual-operator explicit`), or solve.method = \"auto\""
)]
pub struct NeedsExplicit(pub(super) &'static str);

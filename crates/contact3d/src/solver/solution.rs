//! What a solve returns: status, solution, and the history of its steps.

use std::ops::AddAssign;

use super::{CoulombState, StartStrategy};
use crate::scene::SolveSettings;

units::worded! {
    /// What a solve came to: the error of its solution decides, not how its method stopped.
    #[derive(Default)]
    pub enum Status {
        /// The accuracy ε was reached.
        Converged = "converged",
        /// The outer loop ran out of steps.
        MaxOuterSteps = "max_outer_steps",
        /// An inner problem ran out of applications of S, or of steps towards equilibrium.
        MaxOperatorApplications = "max_operator_applications",
        /// A value was not finite, or a coefficient of friction not positive at the slips reached.
        NumericalError = "numerical_error",
        /// Refinement ended above ε: its error falls no further, or rounding forbids ε.
        MachinePrecision = "machine_precision",
        /// Newton's method found no solution from any start, or none of an inner problem.
        MaxNewtonSteps = "max_newton_steps",
        /// Successive approximations return to where they were: they will never converge.
        Cycling = "cycling",
        /// The stopping rule of the method is met, and λ is near the solution, but further from it
        /// than about ε: the accuracy reached is known.
        ReducedAccuracy = "reduced_accuracy",
        /// The stopping rule of the method is met, but λ is no solution; also of what nobody has assessed yet.
        #[default]
        Inaccurate = "inaccurate",
        /// No contact forces that the laws admit hold a body that floats; the mechanism proves it.
        NoEquilibrium = "no_equilibrium",
    }
}

/// Why a method stopped, by its own rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// Its residual, or the change of its last step, is within the tolerance.
    Converged,
    /// Rounding forbids the tolerance; what is reached is the best there is.
    RoundingLimit,
    /// The steps of Newton's method ran out, or the residual fell no further and nothing was left to try.
    MaxSteps,
    /// The outer loop ran out of steps.
    MaxOuterSteps,
    /// An inner problem ran out of applications of S, or of steps of the method of multipliers.
    MaxOperatorApplications,
    /// Successive approximations return to where they were.
    Cycling,
    /// A value was not finite.
    NumericalError,
}

impl StopReason {
    /// Whether the method found what it looked for, as well as rounding allows.
    #[must_use]
    pub fn is_solution(self) -> bool {
        matches!(self, Self::Converged | Self::RoundingLimit)
    }
}

/// What a method found before the error of its solution is measured.
#[derive(Debug, Clone)]
pub struct MethodResult {
    /// Why it stopped.
    pub stop: StopReason,
    /// What its stopping rule measures: the last change of successive approximations, or the residual of a minimisation.
    pub measure: f64,
    /// What it found; it claims nothing yet.
    pub solution: Solution,
}

impl Status {
    /// Whether there is a solution, as accurate as was asked or not.
    ///
    /// A solution that only met the stopping rule of its method is one: the rule is what the method promises, and the
    /// error, at most 5 per cent, is said.
    #[must_use]
    pub fn is_solved(self) -> bool {
        matches!(
            self,
            Self::Converged | Self::ReducedAccuracy | Self::MachinePrecision
        )
    }

    /// Whether the solve is a success: the one definition, which exit codes and counts of sweeps share. An ε that settings name is to be
    /// reached; a default one is no more than the best that rounding allows.
    #[must_use]
    pub fn is_success(self, settings: &SolveSettings) -> bool {
        self.is_solved() && (self != Self::MachinePrecision || settings.epsilon.is_none())
    }
}

units::worded! {
    /// Which algorithm gave the solution.
    #[derive(Default)]
    pub enum SolvedBy {
        /// Successive approximations.
        FixedPoint = "fixed_point",
        /// Semismooth Newton.
        Newton = "newton",
        /// One minimisation, for frictionless contact and given slip bounds.
        Minimisation = "minimisation",
        /// One solve with the factor, for a body without contact.
        #[default]
        Direct = "direct",
    }
}

/// The discrete solution and how it was reached.
#[derive(Debug, Clone)]
pub struct Solution {
    /// What the solve came to, as `assessment.rs` decides.
    pub status: Status,
    /// Relative error of λ, measured by one more solution from it with refined residuals: weighted by
    /// areas, the larger of that of λ_ν and of that of λ_t, relative to max(‖λ_t‖, ‖F λ_ν‖), or to the load
    /// where forces vanish beside it. The last change err of successive approximations, or the residual of a minimisation, that did not end.
    pub accuracy: f64,
    /// λ: m normal stresses λ_ν, then m pairs λ_t where there is friction, `[n_multipliers]`, in Pa.
    pub multiplier: Vec<f64>,
    /// u over the free degrees of freedom, `[n_free]`, in m; zero without equilibrium.
    pub displacement: Vec<f64>,
    /// The rigid-body motions of a body that only contact holds, or weak springs; `None` where supports hold it.
    pub rigid: Option<RigidMotions>,
    /// The state of friction; `None` unless Coulomb's law holds.
    pub friction: Option<FrictionState>,
    /// How the solution was reached.
    pub trace: Trace,
}

/// What a solve finds of rigid-body motions.
#[derive(Debug, Clone, Default)]
pub struct RigidMotions {
    /// α in m, one for each mode of the body; zero without equilibrium.
    pub motion: Vec<f64>,
    /// The motions that neither contact nor supports resist, each of largest component one, `[n_null][n_nodes]`; the
    /// solution has none of them, and the load does not work in them where there is an equilibrium.
    pub null_space: Vec<Vec<[f64; 3]>>,
    /// With [`Status::NoEquilibrium`] a motion of largest component one, `[n_nodes]`, in which the load does more work than contact
    /// can oppose.
    pub mechanism: Option<Vec<[f64; 3]>>,
}

impl RigidMotions {
    /// α alone.
    pub(super) fn of(motion: &[f64]) -> Self {
        Self {
            motion: motion.to_vec(),
            ..Self::default()
        }
    }
}

/// Friction by Coulomb's law at a solution.
#[derive(Debug, Clone, Default)]
pub struct FrictionState {
    /// φ = (|u_t1|, |u_t2|) of the displacement at the contact nodes, in m; `None` unless the
    /// coefficients of friction follow the slip.
    pub slip: Option<Vec<[f64; 2]>>,
    /// The slip bound and the friction of the last inner problem.
    pub coulomb: CoulombState,
    /// ‖Ψ(λ) − λ‖ / ‖λ‖ for the paper's mapping Ψ, where it was evaluated.
    pub mapping_change: Option<f64>,
    /// How Ψ behaves at λ; `None` unless S is dense, λ is a solution and no contact springs gave it.
    pub local_mapping: Option<LocalMapping>,
}

/// The linearisation of the mapping Ψ of HKL, whose fixed points are the solutions, at one of them.
///
/// On the way to the solution some pane may change its zone: then Ψ has a kink there, and this is what holds on one side of it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LocalMapping {
    /// ρ(Ψ'): successive approximations converge to the solution from nearby where it is below 1, and at that rate; infinite where
    /// the problem with frozen friction is singular.
    pub spectral_radius: f64,
    /// The sign of det R' = det R_λ det(1 − Ψ') for the natural map R, with frozen friction R_λ; 0 where it vanishes. The signs over
    /// all solutions add up to 1, so where it is −1 there are at least two other solutions.
    pub determinant_sign: i8,
    /// The least |1 − μ| over the eigenvalues μ of Ψ', from 0, where det R' = 0, to 1: small changes of the data move the solution in
    /// proportion to its inverse, and where a real μ is that near, a fold is, in which this solution and another one meet. Ends of pieces,
    /// where panes change their zones, may be folds that no eigenvalue announces.
    pub fold_distance: f64,
}

/// A fold is near where the distance is below this: small changes of the data move the solution at least ten times as far as with frozen
/// friction.
pub(super) const NEAR_FOLD: f64 = 0.1;

impl LocalMapping {
    /// Whether det R' = 0 is near, and so perhaps another solution.
    #[must_use]
    pub fn is_near_fold(&self) -> bool {
        self.fold_distance < NEAR_FOLD
    }

    /// Whether successive approximations converge to the solution from nearby.
    #[must_use]
    pub fn is_attracting(&self) -> bool {
        self.spectral_radius < 1.0
    }
}

/// How a solution was reached, step by step.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// Which algorithm gave the solution.
    pub solved_by: SolvedBy,
    /// The start strategy that led to the solution, or came nearest to one; `None` where S stayed implicit, or the method was given.
    pub strategy: Option<StartStrategy>,
    /// Steplength ᾱ of projected gradient steps, in Pa/m³; 0 without contact.
    pub steplength: f64,
    /// Stiffness of each pane while the others do not move, `[n_multipliers]`, in Pa/m³, that
    /// residuals are measured by; empty without contact.
    pub local_stiffness: Vec<f64>,
    /// One record per step of successive approximations, or for a minimisation.
    pub history: Vec<OuterStep>,
    /// One record per step of Newton's method.
    pub newton: Vec<NewtonStep>,
    /// Applications of A⁻¹, or of the dense S in its place (n_A).
    pub applications: usize,
    /// Evaluations of the friction law at a node.
    pub law_evaluations: usize,
}

impl Solution {
    /// Whether there is anything to measure: a displacement, good or bad, and not a body at rest where a solve found none.
    #[must_use]
    pub fn has_computed_solution(&self) -> bool {
        self.status.is_solved() || self.displacement.iter().any(|u| *u != 0.0)
    }

    /// This solution or an earlier one, whichever is more accurate, with the counts of both.
    pub(super) fn or_nearer(self, earlier: Self) -> Self {
        match self.accuracy <= earlier.accuracy {
            true => self.after(earlier.trace),
            false => earlier.after(self.trace),
        }
    }

    /// The solution with what the same solve tried before it.
    pub(crate) fn after(self, tried: Trace) -> Self {
        Self {
            trace: Trace {
                history: [tried.history, self.trace.history].concat(),
                newton: [tried.newton, self.trace.newton].concat(),
                applications: tried.applications + self.trace.applications,
                ..self.trace
            },
            ..self
        }
    }
}

/// Steps of each kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StepCounts {
    /// Conjugate gradient steps inside the set.
    pub conjugate_gradient: usize,
    /// Steps to the boundary followed by a projected step along the free gradient.
    pub expansion: usize,
    /// Projected gradient steps that release active blocks.
    pub proportioning: usize,
}

impl AddAssign for StepCounts {
    fn add_assign(&mut self, other: Self) {
        self.conjugate_gradient += other.conjugate_gradient;
        self.expansion += other.expansion;
        self.proportioning += other.proportioning;
    }
}

/// One step k of Algorithm 4.1.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct OuterStep {
    /// err⁽ᵏ⁾ = ‖λ⁽ᵏ⁺¹⁾ − λ⁽ᵏ⁾‖ / ‖λ⁽ᵏ⁺¹⁾‖.
    pub change: f64,
    /// Inner tolerance ε_λ⁽ᵏ⁾ relative to ‖h‖; for Newton's method relative to ‖λ‖.
    pub inner_tolerance: f64,
    /// Final ‖g̃‖ of the inner problem relative to ‖h‖; for Newton's method its measured error.
    pub inner_residual: f64,
    /// Steps of KPRGP or [`super::Gpcg`]; none for Newton's method.
    pub steps: StepCounts,
    /// Applications of A⁻¹ in this step; the first step includes those that estimate ‖S‖.
    pub applications: usize,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// One step of Newton's method.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NewtonStep {
    /// ‖R‖ / ‖λ‖ after the step.
    pub residual: f64,
    /// Length s ≤ 1 in x ← x + s d for Newton's step d.
    pub step_length: f64,
    /// Halvings tried.
    pub halvings: usize,
    /// Panes that changed between open, stick and slip.
    pub zone_changes: usize,
    /// Unknowns of the dense system.
    pub free_unknowns: usize,
    /// Whether a safeguard replaced Newton's step.
    pub safeguard: bool,
    /// Wall-clock seconds.
    pub seconds: f64,
}

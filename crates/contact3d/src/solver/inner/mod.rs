//! The inner solvers: what minimises over a frozen admissible set.

mod active_face;
mod gpcg;
mod kprgp;

pub use gpcg::Gpcg;
pub use kprgp::{InnerOutcome, Kprgp};

use super::{
    FeasibleSet, NeedsExplicit, NewtonStep, StepCounts, StopReason,
    conditions::Bound,
    newton::{NewtonDriver, NewtonSettings},
    tolerances::rounding_of_products,
};
use crate::{
    dual::{BalancedOperator, BodyOperator, DualOperator, ExplicitDual, LocalStiffness},
    linalg::{larger, largest_eigenvalue, norm, ratio},
    scene::InnerSolver,
};

/// Most steps of the method of multipliers: each removes a sixth of the imbalance at least, and sixteen digits take 202.
const EQUILIBRIUM_MAX_STEPS: usize = 200;

/// What an inner minimisation may leave, as a share of the imbalance before it: imbalance and residual fall together.
const IMBALANCE_REDUCTION: f64 = 0.1;

/// What solves the problems with a frozen admissible set.
#[derive(Debug, Clone, Copy)]
pub enum Inner<'a> {
    /// KPRGP, as in the paper.
    Kprgp,
    /// GPCG, which moves along the ellipses' boundaries too, until the natural map measured by
    /// local stiffness, `[n_multipliers]` in Pa/m³, is small as well.
    Gpcg(&'a [f64]),
    /// Newton's method on the dense dual problem, which reaches rounding in a few steps.
    Newton(&'a ExplicitDual, &'a LocalStiffness),
}

/// What an inner solver did.
pub(in crate::solver) struct InnerSummary {
    /// Why it stopped where the tolerance was not reached; `None` where it was.
    pub(in crate::solver) failure: Option<StopReason>,
    /// Final residual, relative as the tolerance is.
    pub(in crate::solver) residual: f64,
    pub(in crate::solver) steps: StepCounts,
    /// Whether rounding forbids a smaller residual.
    pub(in crate::solver) at_rounding: bool,
    /// Applications of S that the operator did not count.
    pub(in crate::solver) applications: usize,
    /// Steps of Newton's method.
    pub(in crate::solver) newton: Vec<NewtonStep>,
}

impl<'a> Inner<'a> {
    /// The inner solver that settings name, with what it needs of the problem.
    pub(in crate::solver) fn chosen(
        solver: InnerSolver,
        explicit: Option<(&'a ExplicitDual, &'a LocalStiffness)>,
        stiffness: &'a [f64],
    ) -> Result<Self, NeedsExplicit> {
        match (solver, explicit) {
            (InnerSolver::Kprgp, _) => Ok(Self::Kprgp),
            (InnerSolver::Gpcg, _) => Ok(Self::Gpcg(stiffness)),
            (InnerSolver::Newton, Some((dual, local))) => Ok(Self::Newton(dual, local)),
            (InnerSolver::Newton, None) => Err(NeedsExplicit("inner solver newton")),
        }
    }

    /// Whether the solver counts steps, so that none means that it did nothing; KPRGP then stops as the paper's does.
    pub(in crate::solver) fn was_idle(self, steps: StepCounts) -> bool {
        match self {
            Self::Gpcg(_) => steps == StepCounts::default(),
            Self::Kprgp | Self::Newton(..) => false,
        }
    }

    /// Improves a multiplier on a frozen admissible set to a tolerance relative to ‖h‖ for KPRGP
    /// and GPCG, and to ‖λ‖ for Newton's method.
    pub(in crate::solver) fn minimise(
        self,
        operator: &mut BodyOperator<'_, '_>,
        kprgp: &Kprgp,
        set: &FeasibleSet,
        multiplier: &mut Vec<f64>,
        tolerance: f64,
    ) -> InnerSummary {
        match (self, operator) {
            (Self::Newton(dual, local), operator) => {
                newton_inside(dual, local, operator, set, multiplier, tolerance)
            }
            (_, BodyOperator::Constrained(operator)) => {
                self.minimise_at(*operator, kprgp, set, multiplier, tolerance)
            }
            (_, BodyOperator::Floating(operator)) => {
                self.minimise_balanced(operator, kprgp, set, multiplier, tolerance)
            }
        }
    }

    /// One minimisation of a body where it is, by KPRGP or GPCG.
    fn minimise_at(
        self,
        operator: &mut dyn DualOperator,
        kprgp: &Kprgp,
        set: &FeasibleSet,
        multiplier: &mut [f64],
        tolerance: f64,
    ) -> InnerSummary {
        let rhs_norm = norm(operator.rhs());
        set.project(multiplier);
        // The rounding n ε_M (‖S‖ ‖λ‖ + ‖h‖) of r = S λ − h with ‖S‖ < 2/ᾱ.
        let size = 2.0 / kprgp.steplength * norm(multiplier) + rhs_norm;
        let rounding = rounding_of_products(operator.dimension()) * size;
        let asked = tolerance * rhs_norm;
        let reachable = asked.max(rounding);
        let InnerOutcome {
            converged,
            reduced_gradient,
            steps,
        } = match self {
            Self::Gpcg(stiffness) => {
                let gpcg = Gpcg {
                    steplength: kprgp.steplength,
                    max_applications: kprgp.max_applications,
                };
                let accuracy = LocalAccuracy {
                    stiffness,
                    tolerance: LOCAL_SLACK * tolerance,
                    rounding,
                };
                accuracy.minimise(&gpcg, operator, set, multiplier, reachable)
            }
            Self::Kprgp | Self::Newton(..) => kprgp.minimise(operator, set, multiplier, reachable),
        };
        let relative = reduced_gradient / rhs_norm;
        InnerSummary {
            failure: (!converged).then_some(StopReason::MaxOperatorApplications),
            residual: if rhs_norm > 0.0 { relative } else { 0.0 },
            steps,
            at_rounding: asked < rounding,
            applications: 0,
            newton: Vec::new(),
        }
    }

    /// Minimises ½ λᵀSλ − λᵀh under Gᵀλ = e by the method of multipliers (SMALSE-M: Z. Dostál, *Optimal Quadratic Programming
    /// Algorithms*, Springer 2009, ch. 8, with a constant penalty).
    ///
    /// What is minimised each time is the augmented Lagrangian of [`crate::dual::BalancedOperator`], as accurately as the balance
    /// is met.
    fn minimise_balanced(
        self,
        operator: &mut BalancedOperator<'_>,
        kprgp: &Kprgp,
        set: &FeasibleSet,
        multiplier: &mut [f64],
        tolerance: f64,
    ) -> InnerSummary {
        let attainable = rounding_of_products(operator.dimension());
        let first_application = operator.applications();
        // The first step shall find the zones, no more.
        let mut imbalance = 1e-2_f64;
        let mut total: Option<InnerSummary> = None;
        for _ in 0..EQUILIBRIUM_MAX_STEPS {
            let used = operator.applications() - first_application;
            let remaining = Kprgp {
                max_applications: kprgp.max_applications.saturating_sub(used),
                ..*kprgp
            };
            // A residual within the tolerance leaves an imbalance of the same size, give or take a factor.
            let asked = IMBALANCE_REDUCTION * imbalance.max(tolerance);
            let mut summary = self.minimise_at(operator, &remaining, set, multiplier, asked);
            if let Some(before) = &total {
                summary.steps += before.steps;
            }
            let next = operator.rigid.relative_equilibrium_residual(multiplier);
            summary.residual = larger(summary.residual, next);
            let done = next <= tolerance.max(attainable) && asked <= tolerance;
            if done || summary.failure.is_some() || !next.is_finite() {
                return summary;
            }
            operator.rebalance(multiplier);
            imbalance = next;
            total = Some(summary);
        }
        let mut summary = total.expect("one step at least");
        summary.failure = Some(StopReason::MaxOperatorApplications);
        summary
    }
}

/// One minimisation by Newton's method, which has the motions of a body that floats among its unknowns.
fn newton_inside(
    dual: &ExplicitDual,
    local: &LocalStiffness,
    operator: &mut BodyOperator<'_, '_>,
    set: &FeasibleSet,
    multiplier: &mut Vec<f64>,
    tolerance: f64,
) -> InnerSummary {
    let settings = NewtonSettings {
        tolerance: tolerance.max(dual.rounding()),
        ..NewtonSettings::default()
    };
    let mut start = multiplier.clone();
    if let BodyOperator::Floating(operator) = operator {
        start.extend(operator.motion(multiplier));
    }
    let driver = NewtonDriver::new(dual, local, Bound::Given(set), Some(&start));
    let outcome = driver.minimise(set, &settings);
    let summary = InnerSummary {
        failure: (!outcome.stop.is_solution()).then_some(StopReason::MaxSteps),
        residual: outcome.residual,
        steps: StepCounts::default(),
        at_rounding: outcome.stop == StopReason::RoundingLimit
            || outcome.residual <= dual.rounding(),
        applications: outcome.evaluations,
        newton: outcome.history,
    };
    *multiplier = dual.multipliers(&outcome.unknowns).to_vec();
    if let BodyOperator::Floating(operator) = operator {
        operator.set_motion(multiplier, dual.motion(&outcome.unknowns));
    }
    summary
}

/// How much larger than the inner tolerance the residual by local stiffness may be: with the
/// paper's r_tol, no larger than ε.
const LOCAL_SLACK: f64 = 10.0;

/// Most and least decrease of the tolerance from one run of GPCG to the next: less than half is not worth a run, which searches its face
/// anew, and four digits at once are as many as one estimate can be trusted for.
const TOLERANCE_REDUCTION: [f64; 2] = [1e-4, 0.5];

/// When a minimiser is accurate on the face itself, whatever its rigid motion.
struct LocalAccuracy<'a> {
    /// ρ, `[n_multipliers]`, in Pa/m³.
    stiffness: &'a [f64],
    /// ‖λ − P(λ − ρ r)‖ ≤ tolerance ‖λ‖.
    tolerance: f64,
    /// No tolerance below this rounding of r in m³ is asked for.
    rounding: f64,
}

impl LocalAccuracy<'_> {
    /// Runs GPCG with smaller and smaller tolerances of the reduced gradient, in m³.
    fn minimise(
        &self,
        gpcg: &Gpcg,
        operator: &mut dyn DualOperator,
        set: &FeasibleSet,
        multiplier: &mut [f64],
        mut tolerance: f64,
    ) -> InnerOutcome {
        let first_application = operator.applications();
        let mut steps = StepCounts::default();
        loop {
            let left = gpcg
                .max_applications
                .saturating_sub(operator.applications() - first_application);
            let gpcg = Gpcg {
                max_applications: left,
                ..*gpcg
            };
            let outcome = gpcg.minimise(operator, set, multiplier, tolerance);
            steps += outcome.steps;
            let residual = self.residual(operator, set, multiplier);
            if !outcome.converged || tolerance <= self.rounding || residual <= self.tolerance {
                return InnerOutcome { steps, ..outcome };
            }
            let [least, most] = TOLERANCE_REDUCTION;
            let factor = (0.5 * self.tolerance / residual).clamp(least, most);
            tolerance = (tolerance * factor).max(self.rounding);
        }
    }

    /// ‖λ − P(λ − ρ r)‖ / ‖λ‖, and 0 for 0/0.
    fn residual(
        &self,
        operator: &mut dyn DualOperator,
        set: &FeasibleSet,
        multiplier: &[f64],
    ) -> f64 {
        let gradient = operator.gradient(multiplier);
        let step = set.projected_step(multiplier, &gradient, |j| self.stiffness[j]);
        ratio(norm(&step), norm(multiplier))
    }
}

/// The steplength ᾱ = 1.9/‖S‖ of projected gradient steps in Pa/m³, with ‖S‖ within some per cent (KPRGP asks for ᾱ in (0, 2/‖S‖)); 1 for
/// S = 0, where any will do.
#[must_use]
pub fn projected_gradient_steplength(operator: &mut dyn DualOperator) -> f64 {
    match largest_eigenvalue(operator.dimension(), |v| operator.apply(v)) {
        0.0 => 1.0,
        largest => 1.9 / largest,
    }
}

use std::time::Instant;

use super::{
    ContactState, FeasibleSet, Gpcg, InnerOutcome, Kprgp, NewtonSettings, NewtonStatus, OuterStep,
    Solution, SolvedBy, Status, StepCounts, minimise_frozen, norm::projected_gradient_steplength,
    vector::norm,
};
use crate::{
    contact::{FrictionField, nodal_slip},
    dual::{Assembly, DualOperator, ExplicitDual},
    scene::{PrecisionControl, SolveSettings},
};

/// The inner tolerances of HKL Remark 4.1.
///
/// Two additions to the paper: control (b) never asks for more than r_tol · ε, and the outer loop
/// ends only when the inner residual has come down to that as well. Without them an inner problem
/// whose warm start already meets a loose tolerance takes no step, and the change of zero would
/// pass for convergence.
struct Precision<'a> {
    settings: &'a SolveSettings,
    tolerance: f64,
}

impl<'a> Precision<'a> {
    fn new(settings: &'a SolveSettings) -> Self {
        Self {
            settings,
            tolerance: settings.r_tol / settings.c_fact,
        }
    }

    /// The inner accuracy r_tol · ε that an answer of accuracy ε needs.
    fn floor(&self) -> f64 {
        self.settings.r_tol * self.settings.epsilon()
    }

    /// ε_λ⁽ᵏ⁾ from err⁽ᵏ⁻¹⁾.
    fn next(&mut self, last_change: f64) -> f64 {
        let s = self.settings;
        self.tolerance = match s.precision {
            PrecisionControl::Fixed => self.floor(),
            PrecisionControl::Adaptive => (s.r_tol * last_change)
                .min(s.c_fact * self.tolerance)
                .max(self.floor()),
        };
        self.tolerance
    }
}

/// What solves the problems with frozen slip bound and friction.
#[derive(Debug, Clone, Copy)]
pub enum Inner<'a> {
    /// KPRGP, as in the paper.
    Kprgp,
    /// GPCG, which moves along the ellipses' boundaries too.
    Gpcg,
    /// Newton's method on the dense dual problem, which reaches rounding in a few steps.
    Newton(&'a ExplicitDual),
}

/// The method of successive approximations (HKL Algorithm 4.1) with a chosen inner solver.
///
/// `observe` is called after every outer step with its number and record. An operator that knows
/// the contact face's displacement spares the solve over the body in all steps but the last.
pub fn successive_approximations(
    inner: Inner<'_>,
    operator: &mut dyn DualOperator,
    assembly: &Assembly,
    contact: &ContactState<'_>,
    settings: &SolveSettings,
    mut observe: impl FnMut(usize, &OuterStep),
) -> Solution {
    let m = contact.surface.n_panes();
    let mut started = Instant::now();
    let mut actions_before = operator.actions();
    let steplength = projected_gradient_steplength(operator);
    let kprgp = Kprgp {
        steplength,
        gamma: settings.gamma,
        max_actions: settings.max_inner_actions,
    };
    let mut precision = Precision::new(settings);
    let mut change = 1.0;
    let no_slip = vec![[0.0; 2]; contact.surface.nodes.len()];
    let mut solution = Solution {
        status: Status::MaxOuterSteps,
        multiplier: vec![0.0; 3 * m],
        displacement: Vec::new(),
        friction: FrictionField::new(contact.law, contact.surface, &no_slip),
        slip: no_slip,
        slip_bound: vec![0.0; m],
        steplength,
        solved_by: SolvedBy::FixedPoint,
        accuracy: 1.0,
        mapping_change: None,
        history: Vec::new(),
        newton: Vec::new(),
        actions: 0,
    };
    for k in 0..settings.max_outer_steps {
        if k > 0 {
            solution.slip_bound = solution.multiplier[..m].to_vec();
            solution.friction = FrictionField::new(contact.law, contact.surface, &solution.slip);
        }
        let set = FeasibleSet::new(&solution.slip_bound, &solution.friction);
        let tolerance = precision.next(change);
        let mut next = solution.multiplier.clone();
        let outcome = inner.minimise(operator, &kprgp, &set, &mut next, tolerance);
        change = relative_change(&next, &solution.multiplier);
        solution.multiplier = next;
        solution.accuracy = change;
        let accurate = outcome.at_rounding || outcome.residual <= precision.floor();
        let end = stop(&outcome, accurate && change <= settings.epsilon(), change);
        let last = end.is_some() || k + 1 == settings.max_outer_steps;
        solution.update_slip(operator, assembly, contact, last);
        solution.history.push(OuterStep {
            change,
            inner_tolerance: tolerance,
            inner_residual: outcome.residual,
            steps: outcome.steps,
            actions: operator.actions() - actions_before + outcome.actions,
            seconds: started.elapsed().as_secs_f64(),
        });
        solution.actions += solution.history[k].actions;
        actions_before = operator.actions();
        started = Instant::now();
        observe(k, &solution.history[k]);
        if let Some(status) = end {
            solution.status = status;
            break;
        }
    }
    solution
}

impl Solution {
    /// φ of the multiplier, and u where it is needed: for φ itself, or in the last step.
    fn update_slip(
        &mut self,
        operator: &mut dyn DualOperator,
        assembly: &Assembly,
        contact: &ContactState<'_>,
        last: bool,
    ) {
        let known = operator.tangential_displacement(&self.multiplier);
        if last || known.is_none() {
            self.displacement = operator.to_primal(&self.multiplier);
        }
        self.slip = match known {
            Some(displacement) => displacement.iter().map(|u| u.map(f64::abs)).collect(),
            None => nodal_slip(
                contact.surface,
                contact.frame,
                &assembly.primal.dofs,
                &self.displacement,
            ),
        };
    }
}

/// What an inner solver did.
struct InnerSummary {
    converged: bool,
    /// Final residual, relative as the tolerance is.
    residual: f64,
    steps: StepCounts,
    /// Whether rounding forbids a smaller residual.
    at_rounding: bool,
    /// Actions of S that the operator did not count.
    actions: usize,
}

impl Inner<'_> {
    /// Improves a multiplier on a frozen admissible set to a relative tolerance.
    fn minimise(
        self,
        operator: &mut dyn DualOperator,
        kprgp: &Kprgp,
        set: &FeasibleSet,
        multiplier: &mut Vec<f64>,
        tolerance: f64,
    ) -> InnerSummary {
        match self {
            Self::Kprgp | Self::Gpcg => {
                let rhs_norm = norm(operator.rhs());
                set.project(multiplier);
                let target = tolerance * rhs_norm;
                let InnerOutcome {
                    converged,
                    reduced_gradient,
                    steps,
                } = match self {
                    Self::Gpcg => Gpcg {
                        steplength: kprgp.steplength,
                        max_actions: kprgp.max_actions,
                    }
                    .minimise(operator, set, multiplier, target),
                    _ => kprgp.minimise(operator, set, multiplier, target),
                };
                let relative = reduced_gradient / rhs_norm;
                InnerSummary {
                    converged,
                    residual: if rhs_norm > 0.0 { relative } else { 0.0 },
                    steps,
                    at_rounding: false,
                    actions: 0,
                }
            }
            Self::Newton(dual) => {
                let settings = NewtonSettings {
                    tolerance: tolerance.max(dual.rounding()),
                    ..NewtonSettings::default()
                };
                let outcome = minimise_frozen(dual, set, multiplier, &settings);
                *multiplier = outcome.multiplier;
                InnerSummary {
                    converged: matches!(
                        outcome.status,
                        NewtonStatus::Converged | NewtonStatus::RoundingLimit
                    ),
                    residual: outcome.residual,
                    steps: StepCounts::default(),
                    at_rounding: outcome.status == NewtonStatus::RoundingLimit
                        || outcome.residual <= dual.rounding(),
                    actions: outcome.evaluations,
                }
            }
        }
    }
}

/// ‖λ' − λ‖ / ‖λ'‖, and 0 when both vanish.
fn relative_change(next: &[f64], last: &[f64]) -> f64 {
    let difference: Vec<f64> = next.iter().zip(last).map(|(a, b)| a - b).collect();
    match (norm(&difference), norm(next)) {
        (0.0, _) => 0.0,
        (difference, size) => difference / size,
    }
}

fn stop(outcome: &InnerSummary, settled: bool, change: f64) -> Option<Status> {
    if !change.is_finite() || !outcome.residual.is_finite() {
        Some(Status::NumericalError)
    } else if !outcome.converged {
        Some(Status::MaxInnerActions)
    } else if settled {
        Some(Status::Converged)
    } else {
        None
    }
}

use thiserror::Error;

use super::{
    ContactState, Inner, NewtonSettings, NewtonSolution, NewtonStatus, NewtonStep, OuterStep,
    Solution, SolvedBy, Status, evaluate_mapping, newton, norm::projected_gradient_steplength,
    successive_approximations,
};
use crate::{
    dual::{DualOperator, DualSystem, ExplicitDual, ExplicitOperator, ImplicitOperator},
    scene::{InnerSolver, Method, SolveSettings},
};

/// What an observer of a solve sees.
#[derive(Debug, Clone, Copy)]
pub enum Progress<'a> {
    /// Step k of successive approximations.
    Outer(usize, &'a OuterStep),
    /// Step k of Newton's method.
    Newton(usize, &'a NewtonStep),
}

/// A method that needs what the assembled problem does not hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error(
    "{0} needs the explicit dual operator, but /assemble holds the implicit one; \
     run `assemble --dual-operator explicit`, or choose --method fixed-point --inner kprgp"
)]
pub struct NeedsExplicit(&'static str);

/// Newton's answer is accepted when the paper's mapping Ψ moves it by no more than this: half the
/// digits of a double, far above its rounding and far below any other fixed point.
const CERTIFIED: f64 = 1e-8;

/// Solves the discrete contact problem as the settings say.
///
/// # Errors
/// [`NeedsExplicit`] when Newton's method is asked for and S is not dense.
pub fn solve(
    system: &DualSystem,
    contact: &ContactState<'_>,
    settings: &SolveSettings,
    observe: &mut dyn FnMut(Progress<'_>),
) -> Result<Solution, NeedsExplicit> {
    let explicit = system.explicit.as_ref();
    match (settings.method, explicit) {
        (Method::Newton, None) => Err(NeedsExplicit("method newton")),
        (Method::Newton, Some(dual)) => {
            let found = run_newton(dual, contact, settings, observe);
            Ok(certified(system, dual, contact, settings, found))
        }
        (Method::Auto, Some(dual)) => {
            let found = run_newton(dual, contact, settings, observe);
            let steps = found.history.clone();
            let solution = certified(system, dual, contact, settings, found);
            if matches!(solution.status, Status::Converged | Status::RoundingLimit) {
                return Ok(solution);
            }
            let mut solution = fixed_point(Inner::Newton(dual), system, contact, settings, observe);
            solution.newton = steps;
            Ok(solution)
        }
        (Method::Auto, None) => Ok(fixed_point(
            Inner::Kprgp,
            system,
            contact,
            settings,
            observe,
        )),
        (Method::FixedPoint, _) => {
            let inner = match (settings.inner, explicit) {
                (InnerSolver::Kprgp, _) => Inner::Kprgp,
                (InnerSolver::Gpcg, _) => Inner::Gpcg,
                (InnerSolver::Newton, Some(dual)) => Inner::Newton(dual),
                (InnerSolver::Newton, None) => return Err(NeedsExplicit("inner solver newton")),
            };
            Ok(fixed_point(inner, system, contact, settings, observe))
        }
    }
}

fn fixed_point(
    inner: Inner<'_>,
    system: &DualSystem,
    contact: &ContactState<'_>,
    settings: &SolveSettings,
    observe: &mut dyn FnMut(Progress<'_>),
) -> Solution {
    let assembly = &system.assembly;
    let mut implicit;
    let mut dense;
    let operator: &mut dyn DualOperator = match &system.explicit {
        Some(dual) => {
            dense = ExplicitOperator::new(dual, assembly);
            &mut dense
        }
        None => {
            implicit = ImplicitOperator::new(assembly);
            &mut implicit
        }
    };
    successive_approximations(inner, operator, assembly, contact, settings, |k, step| {
        observe(Progress::Outer(k, step));
    })
}

fn run_newton(
    dual: &ExplicitDual,
    contact: &ContactState<'_>,
    settings: &SolveSettings,
    observe: &mut dyn FnMut(Progress<'_>),
) -> NewtonSolution {
    let newton_settings = NewtonSettings {
        tolerance: settings.epsilon(),
        ..NewtonSettings::default()
    };
    newton(dual, contact, None, &newton_settings, |k, step| {
        observe(Progress::Newton(k, step))
    })
}

/// Completes Newton's answer with u, ᾱ and one evaluation of Ψ.
fn certified(
    system: &DualSystem,
    dual: &ExplicitDual,
    contact: &ContactState<'_>,
    settings: &SolveSettings,
    found: NewtonSolution,
) -> Solution {
    let mut operator = ExplicitOperator::new(dual, &system.assembly);
    let steplength = projected_gradient_steplength(&mut operator);
    let image = evaluate_mapping(dual, contact, &found.multiplier);
    let agrees = image.relative_change <= CERTIFIED.max(settings.epsilon());
    let status = match found.status {
        NewtonStatus::NumericalError => Status::NumericalError,
        NewtonStatus::Converged if agrees => Status::Converged,
        NewtonStatus::RoundingLimit if agrees => Status::RoundingLimit,
        _ => Status::MaxNewtonSteps,
    };
    let displacement = operator.to_primal(&found.multiplier);
    let m = contact.surface.n_panes();
    Solution {
        status,
        solved_by: SolvedBy::Newton,
        accuracy: found.residual,
        mapping_change: Some(image.relative_change),
        displacement,
        slip: found.slip,
        slip_bound: found.multiplier[..m].iter().map(|l| l.max(0.0)).collect(),
        friction: found.friction,
        steplength,
        history: Vec::new(),
        newton: found.history,
        actions: found.evaluations + image.evaluations + operator.actions(),
        multiplier: found.multiplier,
    }
}

use std::sync::atomic::Ordering;

use thiserror::Error;

use super::{
    ContactState, CoulombState, Inner, Linearisation, NewtonSettings, NewtonSolution, NewtonStatus,
    NewtonStep, OuterState, OuterStep, Solution, SolvedBy, Start, Status,
    continuation::{continuation, is_solution},
    coulomb_state, evaluate_mapping,
    mapping::slip_of,
    minimisation::minimise,
    newton,
    norm::projected_gradient_steplength,
    polish::Polished,
    successive_approximations,
};
use crate::{
    contact::CoulombLaw,
    dual::{
        Assembly, ContactSystem, DualOperator, DualSystem, ExplicitDual, ExplicitOperator,
        ImplicitOperator,
    },
    linalg::Workspace,
    scene::{InnerSolver, Method, SolveSettings},
};

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

/// Where ‖R'⁻¹‖ is so large that rounding alone moves λ by more, by no more than this times it.
const ROUNDINGS: f64 = 16.0;

/// Solves the discrete problem as the settings say from a start, by no more than its effects ask for: one solve
/// without contact, one minimisation without friction or with a given slip bound.
///
/// # Errors
/// [`NeedsExplicit`] when Newton's method is asked for and S is not dense.
pub fn solve(
    system: &DualSystem,
    contact: Option<&ContactState<'_>>,
    settings: &SolveSettings,
    start: Start<'_>,
    observe: &mut dyn FnMut(Progress<'_>),
) -> Result<Solution, NeedsExplicit> {
    let (Some(contact), Some(dual)) = (contact, &system.contact) else {
        return Ok(Solution {
            displacement: system
                .assembly
                .solve_refined(&system.assembly.primal.load, &mut Workspace::default()),
            actions: 1,
            ..Solution::default()
        });
    };
    let problem = Problem {
        assembly: &system.assembly,
        dual,
        contact,
        settings,
        start: start.fitting(dual.dual_rhs.len()),
    };
    let mut solution = match contact.interface.coulomb() {
        None => problem.minimise(observe)?,
        Some(law) => problem.coulomb(law, observe)?,
    };
    let mut states = solution.coulomb.iter();
    if !states.all(|state| state.is_admissible(contact.surface)) {
        solution.status = Status::NumericalError;
    }
    solution.law_evaluations = contact.interface.law_evaluations();
    solution.projections = contact.interface.projections.load(Ordering::Relaxed);
    Ok(solution)
}

/// A body in contact, and how to solve it.
pub(super) struct Problem<'a> {
    pub(super) assembly: &'a Assembly,
    pub(super) dual: &'a ContactSystem,
    pub(super) contact: &'a ContactState<'a>,
    pub(super) settings: &'a SolveSettings,
    start: Start<'a>,
}

impl Problem<'_> {
    /// Frictionless contact and Tresca's law.
    fn minimise(&self, observe: &mut dyn FnMut(Progress<'_>)) -> Result<Solution, NeedsExplicit> {
        let inner = match (self.settings.method, self.dual.explicit.as_ref()) {
            (Method::FixedPoint, _) => self.inner()?,
            (Method::Newton, None) => return Err(NeedsExplicit("method newton")),
            (Method::Auto, None) => Inner::Gpcg,
            (Method::Auto | Method::Newton, Some(dual)) => Inner::Newton(dual),
        };
        Ok(self.with_operator(|operator| {
            let first = self.start.multiplier;
            minimise(
                inner,
                operator,
                self.contact,
                self.settings,
                first,
                |k, step| {
                    observe(Progress::Outer(k, step));
                },
            )
        }))
    }

    /// Coulomb's law.
    fn coulomb(
        &self,
        law: &CoulombLaw,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Result<Solution, NeedsExplicit> {
        match (self.settings.method, self.dual.explicit.as_ref()) {
            (Method::Newton, None) => Err(NeedsExplicit("method newton")),
            (Method::Newton, Some(dual)) => {
                let found = self.run_newton(dual, law, observe);
                Ok(self.certified(dual, law, found))
            }
            (Method::Auto, Some(dual)) => {
                let found = self.run_newton(dual, law, observe);
                let steps = found.history.clone();
                let solution = self.certified(dual, law, found);
                if solution.status.is_solved() {
                    return Ok(solution);
                }
                let solution = self.fixed_point(Inner::Newton(dual), law, observe);
                Ok(self.completed(dual, law, solution, steps))
            }
            (Method::Auto, None) => Ok(self.fixed_point(Inner::Gpcg, law, observe)),
            (Method::FixedPoint, _) => Ok(self.fixed_point(self.inner()?, law, observe)),
        }
    }

    /// The inner solver of the settings.
    fn inner(&self) -> Result<Inner<'_>, NeedsExplicit> {
        match (self.settings.inner, self.dual.explicit.as_ref()) {
            (InnerSolver::Kprgp, _) => Ok(Inner::Kprgp),
            (InnerSolver::Gpcg, _) => Ok(Inner::Gpcg),
            (InnerSolver::Newton, Some(dual)) => Ok(Inner::Newton(dual)),
            (InnerSolver::Newton, None) => Err(NeedsExplicit("inner solver newton")),
        }
    }

    fn with_operator(&self, run: impl FnOnce(&mut dyn DualOperator) -> Solution) -> Solution {
        let mut solution = match &self.dual.explicit {
            Some(dual) => run(&mut ExplicitOperator::new(dual, self.assembly, self.dual)),
            None => run(&mut ImplicitOperator::new(self.assembly, self.dual)),
        };
        solution.displacement = self
            .dual
            .refined_displacement(self.assembly, &solution.multiplier);
        solution
    }

    fn fixed_point(
        &self,
        inner: Inner<'_>,
        law: &CoulombLaw,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Solution {
        self.with_operator(|operator| {
            successive_approximations(
                inner,
                operator,
                self.assembly,
                self.contact,
                law,
                self.settings,
                self.start,
                observe,
            )
        })
    }

    fn run_newton(
        &self,
        dual: &ExplicitDual,
        law: &CoulombLaw,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> NewtonSolution {
        let settings = NewtonSettings {
            tolerance: self.settings.epsilon(),
            ..NewtonSettings::default()
        };
        let start = self.start.multiplier;
        let mut observe = |k: usize, step: &NewtonStep| observe(Progress::Newton(k, step));
        let plain = newton(dual, self.contact, law, start, &settings, &mut observe);
        if is_solution(&plain) || plain.status == NewtonStatus::NumericalError {
            return plain;
        }
        let done = plain.history.len();
        let mut found = continuation(dual, self.contact, law, &settings, done, observe);
        found.history = [plain.history, found.history].concat();
        found.evaluations += plain.evaluations;
        found
    }

    /// Takes the answer of successive approximations, after Newton's method failed in `steps`, to the
    /// accuracy of Newton's method, which needs no more than a start in the right zones.
    fn completed(
        &self,
        dual: &ExplicitDual,
        law: &CoulombLaw,
        mut solution: Solution,
        mut steps: Vec<NewtonStep>,
    ) -> Solution {
        if solution.status == Status::Converged {
            let settings = NewtonSettings {
                tolerance: self.settings.epsilon(),
                ..NewtonSettings::default()
            };
            let start = Some(solution.multiplier.as_slice());
            let found = newton(dual, self.contact, law, start, &settings, |_, _| {});
            let last = self.certified(dual, law, found);
            steps.extend(&last.newton);
            if last.status == Status::Converged {
                solution = Solution {
                    solved_by: SolvedBy::FixedPoint,
                    actions: solution.actions + last.actions,
                    history: solution.history,
                    ..last
                };
            }
        }
        solution.newton = steps;
        solution
    }

    /// Completes Newton's answer with u, ᾱ and one evaluation of Ψ.
    fn certified(&self, dual: &ExplicitDual, law: &CoulombLaw, found: NewtonSolution) -> Solution {
        let epsilon = self.settings.epsilon();
        let answer = if is_solution(&found) {
            self.polished(dual, law, found)
        } else {
            self.unpolished(dual, law, found)
        };
        let Polished {
            found,
            dual,
            displacement,
            ..
        } = answer;
        let dual = &dual;
        let mut operator = ExplicitOperator::new(dual, self.assembly, self.dual);
        let steplength = projected_gradient_steplength(&mut operator);
        let image = evaluate_mapping(dual, self.contact, law, &found.multiplier);
        let attainable = dual.rounding();
        let agrees = image.relative_change <= CERTIFIED.max(epsilon) || {
            let linear = Linearisation::new(dual, self.contact, &found.multiplier);
            image.relative_change <= ROUNDINGS * attainable * linear.sensitivity
        };
        let status = match found.status {
            NewtonStatus::NumericalError => Status::NumericalError,
            NewtonStatus::Converged if agrees && epsilon >= attainable => Status::Converged,
            NewtonStatus::Converged | NewtonStatus::RoundingLimit if agrees => {
                Status::RoundingLimit
            }
            _ => Status::MaxNewtonSteps,
        };
        let state: CoulombState = coulomb_state(dual, self.contact, law, &found.multiplier);
        Solution {
            status,
            solved_by: SolvedBy::Newton,
            accuracy: match status {
                Status::RoundingLimit => found.residual.max(attainable),
                _ => found.residual,
            },
            mapping_change: Some(image.relative_change),
            displacement,
            slip: law
                .depends_on_slip()
                .then(|| slip_of(dual, &found.multiplier)),
            coulomb: Some(state),
            steplength,
            newton: found.history,
            // One for u.
            actions: found.evaluations + image.evaluations + operator.actions() + 1,
            multiplier: found.multiplier,
            ..Solution::default()
        }
    }
}

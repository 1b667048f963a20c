//! Chooses how a discrete problem is solved, as its settings say.

use std::sync::atomic::Ordering;

use super::{
    ContactState, Inner, LocalMapping, NeedsExplicit, OuterStep, Progress, Solution, Start, Status,
    conditions::Bound, equilibrium::{neutral_motions, unstopped_motion}, minimisation::minimise,
    problem::DiscreteProblem, successive_approximations, unanswered::has_run_away,
};
use crate::{
    contact::CoulombLaw,
    dual::{
        BalancedOperator, ContactSystem, DualOperator, DualSystem, ExplicitOperator,
        ImplicitOperator, LocalStiffness, OperatorForm, drag, pane_stiffness,
    },
    linalg::{Precision, Workspace},
    scene::{Method, SolveSettings},
};

/// Most times that a method is run again with a smaller ε.
const MOST_TIGHTENINGS: usize = 4;

/// An answer from S in single precision is corrected until its error is this many times what rounding in double makes of S λ.
const ROUNDINGS: f64 = 16.0;

/// Solves the discrete problem as the settings say from a start, by no more than its model features ask for: one solve
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
                .solve_refined(
                    &system.assembly.primal.load,
                    None,
                    f64::EPSILON,
                    &mut Workspace::default(),
                )
                .value,
            applications: 1,
            ..Solution::default()
        });
    };
    let (surface, interface) = (contact.surface, contact.interface);
    let balanced = dual.balanced(&system.assembly, surface, interface);
    let dual = balanced.as_ref().unwrap_or(dual);
    let neutral = dual.balance.as_ref();
    let neutral = neutral.map(|it| neutral_motions(&system.assembly, it));
    let neutral = neutral.unwrap_or_default();
    if let Some(balance) = &dual.balance
        && let Some(motion) = unstopped_motion(&system.assembly, balance, contact)
    {
        return Ok(Solution {
            unstopped_motion: Some(motion),
            neutral_motions: neutral,
            ..Solution::without_answer(
                Status::NoEquilibrium,
                dual,
                &system.assembly.primal,
                contact,
            )
        });
    }
    let problem = DiscreteProblem {
        assembly: &system.assembly,
        dual,
        contact,
        settings,
        start: start.fitting(dual.layout().n_multipliers()),
    };
    let mut solution = match contact.interface.coulomb() {
        None => problem.minimise(observe)?,
        Some(law) => problem.coulomb(law, observe)?,
    };
    solution.neutral_motions = neutral;
    let mut states = solution.coulomb.iter();
    if !states.all(|state| state.is_admissible(contact.surface)) {
        solution.status = Status::NumericalError;
    }
    if let Some(balance) = &dual.balance {
        solution.rigid_motion = balance.coupling.in_modes(&solution.rigid_motion);
        if !solution.status.is_solved() && has_run_away(&solution, surface) {
            let primal = &system.assembly.primal;
            return Ok(Solution {
                history: solution.history,
                newton: solution.newton,
                solved_by: solution.solved_by,
                applications: solution.applications,
                neutral_motions: solution.neutral_motions,
                ..Solution::without_answer(solution.status, dual, primal, contact)
            });
        }
    }
    solution.law_evaluations = contact.interface.law_evaluations();
    solution.projections = contact.interface.projections.load(Ordering::Relaxed);
    // The mapping of a body that floats is not one of multipliers alone.
    if let (Some(law), Some(explicit), None) =
        (contact.interface.coulomb(), dual.explicit(), &dual.balance)
        && solution.status.is_solved()
    {
        solution.local_mapping = LocalMapping::new(explicit, contact, law, &solution.multiplier);
    }
    Ok(solution)
}

/// The solution of a body that floats, with its rigid motions.
fn moved(
    mut operator: impl DualOperator,
    run: impl FnOnce(&mut dyn DualOperator) -> Solution,
) -> Solution {
    let solution = run(&mut operator);
    let rigid_motion = operator.motion(&solution.multiplier);
    Solution {
        rigid_motion,
        ..solution
    }
}

impl DiscreteProblem<'_> {
    /// Frictionless contact and Tresca's law.
    fn minimise(&self, observe: &mut dyn FnMut(Progress<'_>)) -> Result<Solution, NeedsExplicit> {
        let set = self.contact.feasible_set(None);
        let bound = Bound::Frozen(&set);
        match (self.settings.method, self.dual.explicit()) {
            (Method::Newton, None) => Err(NeedsExplicit("method newton")),
            (Method::Auto | Method::Newton, Some(dual)) => {
                let local = LocalStiffness::new(dual);
                Ok(self.newton(dual, &local, bound, observe))
            }
            (Method::Auto, None) => Ok(
                self.until_accurate(bound, |problem, inner| problem.minimise_by(inner, observe))
            ),
            (Method::FixedPoint, _) => {
                self.with_inner(bound, |problem, inner| problem.minimise_by(inner, observe))
            }
        }
    }

    /// Coulomb's law.
    fn coulomb(
        &self,
        law: &CoulombLaw,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Result<Solution, NeedsExplicit> {
        let bound = Bound::Coulomb(self.contact, law);
        match (self.settings.method, self.dual.explicit()) {
            (Method::Newton, None) => Err(NeedsExplicit("method newton")),
            (Method::Newton, Some(dual)) => {
                let local = LocalStiffness::new(dual);
                Ok(self.newton(dual, &local, bound, observe))
            }
            (Method::Auto, Some(dual)) => {
                let local = LocalStiffness::new(dual);
                let solution = self.newton(dual, &local, bound, observe);
                if solution.status.is_solved() {
                    return Ok(solution);
                }
                let steps = solution.newton;
                let inner = Inner::Newton(dual, &local);
                let solution = self.fixed_point(inner, law, observe);
                Ok(self.completed(dual, &local, bound, solution, steps))
            }
            (Method::Auto, None) => Ok(self.until_accurate(bound, |problem, inner| {
                problem.fixed_point(inner, law, observe)
            })),
            (Method::FixedPoint, _) => self.with_inner(bound, |problem, inner| {
                problem.fixed_point(inner, law, observe)
            }),
        }
    }

    /// Local stiffness where S is not dense.
    fn pane_stiffness(&self) -> Vec<f64> {
        let mut stiffness = pane_stiffness(&self.assembly.primal, &self.dual.coupling);
        drag(&mut stiffness, self.dual.layout(), self.dual.dual_rhs());
        stiffness
    }

    /// Runs a method with the inner solver of the settings and judges its answer.
    fn with_inner(
        &self,
        bound: Bound<'_>,
        mut run: impl FnMut(&DiscreteProblem<'_>, Inner<'_>) -> Solution,
    ) -> Result<Solution, NeedsExplicit> {
        let Some(dual) = self.dual.explicit() else {
            let stiffness = self.pane_stiffness();
            let inner = Inner::chosen(self.settings.inner, None, &stiffness)?;
            let solution = run(self, inner);
            return Ok(self.judged(None, bound, stiffness, solution));
        };
        let local = LocalStiffness::new(dual);
        let judge = |solution| {
            self.judged(
                Some((dual, &local)),
                bound,
                local.stiffness.clone(),
                solution,
            )
        };
        let explicit = Some((dual, &local));
        let inner = Inner::chosen(self.settings.inner, explicit, &local.stiffness)?;
        let mut solution = judge(run(self, inner));
        if self.assembly.factor.precision() == Precision::Double {
            return Ok(solution);
        }
        for _ in 0..MOST_TIGHTENINGS {
            let is_good = match solution.status {
                Status::Stopped | Status::Inaccurate => false,
                Status::RoundingLimit => solution.accuracy <= ROUNDINGS * dual.rounding(),
                _ => true,
            };
            if is_good {
                break;
            }
            let multiplier = &solution.multiplier;
            let unknowns = self.unknowns(&solution);
            let exact = self.exact(dual, &local, &unknowns, None, f64::EPSILON);
            let corrected = ContactSystem {
                coupling: self.dual.coupling.clone(),
                form: OperatorForm::Explicit(exact.dual.without_anchor()),
                balance: self.dual.balance.clone(),
            };
            let problem = DiscreteProblem {
                dual: &corrected,
                start: Start {
                    multiplier: Some(multiplier),
                    checkpoint: None,
                },
                ..*self
            };
            let explicit = corrected.explicit().map(|dual| (dual, &local));
            let inner = Inner::chosen(self.settings.inner, explicit, &local.stiffness)?;
            let next = judge(run(&problem, inner));
            let falls = next.accuracy <= 0.5 * solution.accuracy;
            solution = solution.followed_by(next);
            if !falls {
                break;
            }
        }
        Ok(solution)
    }

    /// Runs a method with GPCG inside on the implicit operator, again with a smaller ε from where it
    /// stopped while its answer is further from the solution than asked.
    fn until_accurate(
        &self,
        bound: Bound<'_>,
        mut run: impl FnMut(&DiscreteProblem<'_>, Inner<'_>) -> Solution,
    ) -> Solution {
        let stiffness = self.pane_stiffness();
        let judge = |solution| self.judged(None, bound, stiffness.clone(), solution);
        let inner = Inner::Gpcg(&stiffness);
        let mut solution = judge(run(self, inner));
        let mut settings = self.settings.clone();
        for _ in 0..MOST_TIGHTENINGS {
            if !matches!(solution.status, Status::Stopped | Status::Inaccurate) {
                break;
            }
            let excess = solution.accuracy / self.settings.epsilon();
            settings.epsilon = Some(settings.epsilon() / excess.max(10.0));
            let start = Start {
                multiplier: Some(&solution.multiplier),
                checkpoint: None,
            };
            let tighter = DiscreteProblem {
                settings: &settings,
                start,
                ..*self
            };
            let next = judge(run(&tighter, inner));
            solution = solution.followed_by(next);
        }
        solution
    }

    fn with_operator(&self, run: impl FnOnce(&mut dyn DualOperator) -> Solution) -> Solution {
        let explicit = self.dual.explicit();
        let explicit = explicit.map(|dual| ExplicitOperator::new(dual, self.assembly, self.dual));
        let implicit = || ImplicitOperator::new(self.assembly, self.dual);
        let mut solution = match (explicit, &self.dual.balance) {
            (Some(mut operator), None) => run(&mut operator),
            (None, None) => run(&mut implicit()),
            (Some(operator), Some(balance)) => moved(BalancedOperator::new(operator, balance), run),
            (None, Some(balance)) => moved(BalancedOperator::new(implicit(), balance), run),
        };
        let unknowns = self.unknowns(&solution);
        let refined = self
            .dual
            .refined_displacement(self.assembly, &unknowns, None, f64::EPSILON);
        solution.displacement = refined.value;
        solution
    }

    fn minimise_by(&self, inner: Inner<'_>, observe: &mut dyn FnMut(Progress<'_>)) -> Solution {
        self.with_operator(|operator| {
            let first = self.start.multiplier;
            let observe = |k: usize, step: &OuterStep| observe(Progress::Outer(k, step));
            minimise(inner, operator, self.contact, self.settings, first, observe)
        })
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
}

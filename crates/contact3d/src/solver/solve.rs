//! Chooses how a discrete problem is solved, as its settings say.

use super::{
    ContactBody, ContactState, Inner, LocalMapping, NeedsExplicit, OuterStep, Progress, Solution,
    Start, Status, SuccessiveApproximations,
    conditions::Bound,
    equilibrium::{dragged_motion, neutral_motions, unstopped_motion},
    minimisation::minimise,
    problem::DiscreteProblem,
    solution::has_run_away,
};
use crate::{
    dual::{
        BalancedOperator, BodyOperator, ContactOperator, ContactSystem, DualSystem, ExplicitDual,
        LocalStiffness, OperatorForm, PrimalOperator, drag, pane_stiffness,
    },
    linalg::{Precision, Work, Workspace},
    scene::{Method, SolveSettings},
};

/// Most times that a method is run again with a smaller ε.
const MOST_TIGHTENINGS: usize = 4;

/// An answer from S in single precision is corrected until its error is this many times what rounding in double makes of S λ.
const ROUNDINGS: f64 = 16.0;

/// Applications of an implicit S for each multiplier after which S is formed: forming takes no more than one.
const APPLICATIONS_WORTH: usize = 50;

/// Matrices of the size of S that Newton's and the interior point method hold at a time, and numbers that always fit.
const DENSE_COPIES: usize = 4;
const SMALL_FACTOR: usize = 32_000_000;

/// Solves the discrete problem as the settings say from a start, by no more than its model features ask for: one solve
/// without contact, one minimisation without friction or with a given slip bound. The answer lacks its `local_mapping`.
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
    let body = ContactBody {
        assembly: &system.assembly,
        face: *contact,
    };
    let laws = contact.laws();
    let balanced = dual.balanced(&system.assembly, contact.surface, contact.interface);
    let dual = balanced.as_ref().unwrap_or(dual);
    let problem = DiscreteProblem {
        dual,
        laws: &laws,
        body,
        settings,
        start: start.fitting(dual.layout().n_multipliers()),
    };
    problem.solve(observe)
}

/// The mapping Ψ at an answer; `None` without Coulomb's law, without the dense operator, and for a body that floats, whose mapping is
/// not one of multipliers alone.
pub(crate) fn local_mapping(
    system: &DualSystem,
    contact: &ContactState<'_>,
    solution: &Solution,
) -> Option<LocalMapping> {
    let dual = system.contact.as_ref()?;
    let balanced = dual.balanced(&system.assembly, contact.surface, contact.interface);
    if dual.balance.is_some() || balanced.is_some() {
        return None;
    }
    let laws = contact.laws();
    LocalMapping::new(
        dual.explicit()?,
        &laws,
        laws.coulomb()?,
        &solution.multiplier,
    )
}

impl DiscreteProblem<'_> {
    fn solve(&self, observe: &mut dyn FnMut(Progress<'_>)) -> Result<Solution, NeedsExplicit> {
        let (dual, laws) = (self.dual, self.laws);
        let assembly = self.body.assembly;
        if let Some(balance) = &dual.balance
            && let Some(motion) = unstopped_motion(assembly, balance, laws)
                .or_else(|| dragged_motion(assembly, dual.explicit()?, laws))
        {
            return Ok(Solution {
                unstopped_motion: Some(motion),
                ..Solution::without_answer(Status::NoEquilibrium, self)
            });
        }
        let solution = self.by_method(observe)?;
        Ok(self.finished(solution))
    }

    /// A solution with its whole rigid motion, and what belongs to it.
    fn finished(&self, mut solution: Solution) -> Solution {
        let (dual, laws) = (self.dual, self.laws);
        let assembly = self.body.assembly;
        let mut states = solution.coulomb.iter();
        if !states.all(|state| state.is_admissible(laws)) {
            solution.status = Status::NumericalError;
        }
        if let Some(balance) = &dual.balance {
            solution.rigid_motion =
                balance.add_reference(&solution.rigid_motion, &mut solution.displacement);
            if !solution.status.is_solved() && has_run_away(&solution, laws) {
                return Solution {
                    history: solution.history,
                    newton: solution.newton,
                    solved_by: solution.solved_by,
                    applications: solution.applications,
                    ..Solution::without_answer(solution.status, self)
                };
            }
            solution.neutral_motions = neutral_motions(assembly, balance);
            // Coefficients that follow the slip of nodes may feel what panes do not.
            if solution.slip.is_none() {
                let (u, motion) = (&mut solution.displacement, &mut solution.rigid_motion);
                balance.coupling.remove_neutral(u, motion);
            }
        }
        solution.law_evaluations = laws.law_evaluations();
        solution.projections = laws.projections();
        solution
    }

    /// By the method of the settings.
    fn by_method(&self, observe: &mut dyn FnMut(Progress<'_>)) -> Result<Solution, NeedsExplicit> {
        let law = self.laws.coulomb();
        let set = self.laws.feasible_set(None);
        let bound = Bound::of(self.laws, &set);
        match (self.settings.method, self.dual.explicit(), law) {
            (Method::Newton, None, _) => Err(NeedsExplicit("method newton")),
            (Method::Newton, Some(dual), _) | (Method::Auto, Some(dual), None) => {
                let local = LocalStiffness::new(dual);
                Ok(self.newton(dual, &local, bound, observe))
            }
            (Method::Auto, Some(dual), Some(_)) => Ok(self.coulomb_on_dense(dual, bound, observe)),
            (Method::Auto, None, None) => Ok(self.minimise_implicit(bound, observe)),
            (Method::Auto, None, Some(law)) => {
                let by_newton = self.matrix_free(law, &self.pane_stiffness(), observe);
                Ok(by_newton.unwrap_or_else(|| {
                    self.until_accurate(bound, |problem, inner| problem.by_inner(inner, observe))
                }))
            }
            (Method::FixedPoint, ..) => {
                self.with_inner(bound, |problem, inner| problem.by_inner(inner, observe))
            }
        }
    }

    /// Coulomb's law by Newton's method, and where that fails by successive approximations.
    fn coulomb_on_dense(
        &self,
        dual: &ExplicitDual,
        bound: Bound<'_>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Solution {
        let local = LocalStiffness::new(dual);
        let solution = self.newton(dual, &local, bound, observe);
        if solution.status.is_solved() {
            return solution;
        }
        let steps = solution.newton.clone();
        let next = self.by_inner(Inner::Newton(dual, &local), observe);
        let next = self.completed(dual, &local, bound, next, steps);
        // Successive approximations may leave the range of numbers where Newton's method only finds nothing.
        let is_worse = next.status == Status::NumericalError;
        if is_worse { solution } else { next }
    }

    /// A convex problem on an implicit S: by GPCG, and where that takes far longer than to form S, or finds no answer, on a dense
    /// one if it fits beside the factor.
    fn minimise_implicit(
        &self,
        bound: Bound<'_>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Solution {
        let n = self.dual.layout().n_multipliers();
        let in_factor = self.body.assembly.factor.structure().value_count();
        let fits = DENSE_COPIES * n * n <= in_factor.max(SMALL_FACTOR);
        let mut settings = self.settings.clone();
        if fits {
            let worth = APPLICATIONS_WORTH * n;
            settings.max_inner_actions = settings.max_inner_actions.min(worth);
        }
        let limited = DiscreteProblem {
            settings: &settings,
            ..*self
        };
        let run = |problem: &DiscreteProblem<'_>, inner: Inner<'_>| {
            problem.by_inner(inner, &mut *observe)
        };
        let solution = limited.until_accurate(bound, run);
        if solution.status.is_solved() || !fits {
            return solution;
        }
        let (coupling, rhs) = (&self.dual.coupling, self.dual.dual_rhs().to_vec());
        let (assembly, face) = (self.body.assembly, self.body.face);
        let face = (face.surface, face.interface);
        // No law of a convex problem follows the slip, so nothing asks for that of A⁻¹l.
        let mut dual = ExplicitDual::new(assembly, coupling, rhs, &[], face, &Work::default());
        dual.balance.clone_from(&self.dual.balance);
        let local = LocalStiffness::new(&dual);
        solution.followed_by(self.newton(&dual, &local, bound, observe))
    }

    /// Local stiffness where S is not dense.
    fn pane_stiffness(&self) -> Vec<f64> {
        let mut stiffness = pane_stiffness(&self.body.assembly.primal, &self.dual.coupling);
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
        let explicit = Some((dual, &local));
        let judge = |solution| self.judged(explicit, bound, local.stiffness.clone(), solution);
        let inner = Inner::chosen(self.settings.inner, explicit, &local.stiffness)?;
        let mut solution = judge(run(self, inner));
        if self.body.precision() == Precision::Double {
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

    fn with_operator(&self, run: impl FnOnce(&mut BodyOperator<'_, '_>) -> Solution) -> Solution {
        let assembly = self.body.assembly;
        let mut operator: Box<dyn PrimalOperator + '_> = match self.dual.explicit() {
            Some(dual) => Box::new(ContactOperator::explicit(dual, assembly, self.dual)),
            None => Box::new(ContactOperator::implicit(assembly, self.dual)),
        };
        let mut solution = match &self.dual.balance {
            None => run(&mut BodyOperator::Held(&mut *operator)),
            Some(balance) => {
                let mut operator = BalancedOperator::new(operator, balance);
                let solution = run(&mut BodyOperator::Floating(&mut operator));
                Solution {
                    rigid_motion: operator.motion(&solution.multiplier),
                    ..solution
                }
            }
        };
        let unknowns = self.unknowns(&solution);
        let solved = self.dual.refined(assembly, &unknowns, None, f64::EPSILON);
        solution.displacement = solved.value;
        let (_, motion) = self.dual.parts(&unknowns);
        self.dual.add_motion(motion, &mut solution.displacement);
        solution
    }

    /// One minimisation, or one after the other for Coulomb's law, with an inner solver.
    fn by_inner(&self, inner: Inner<'_>, observe: &mut dyn FnMut(Progress<'_>)) -> Solution {
        self.with_operator(|operator| {
            let Some(law) = self.laws.coulomb() else {
                let first = self.start.multiplier;
                let observe = |k: usize, step: &OuterStep| observe(Progress::Outer(k, step));
                return minimise(inner, operator, self.laws, self.settings, first, observe);
            };
            let method = SuccessiveApproximations {
                inner,
                body: &self.body,
                laws: self.laws,
                law,
                settings: self.settings,
            };
            method.solve(operator, self.start, observe)
        })
    }
}

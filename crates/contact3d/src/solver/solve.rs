//! The solve of a contact problem, step by step.
//!
//! 1. *Equilibrium.* Where only contact holds the body, or beside it weak springs, a rigid-body motion that no admissible contact forces resist proves that there
//!    is no solution ([`super::equilibrium`]).
//! 2. *Operator and method.* With a dense S Newton's method has the matrix of its derivative. Without, it multiplies with S through the
//!    factor ([`super::newton_krylov`]), or a gradient method does ([`super::gradient_methods`]).
//! 3. *Strategies.* Starts of Newton's method are tried in order ([`super::strategy`]) until one leads to a solution.
//! 4. *Refinement.* Displacements and gaps are solved in twice the working precision, and Newton's method goes on with these refined
//!    residuals. The distance that is left is the error of λ ([`super::accuracy`]).
//! 5. *Assessment.* The error decides the status ([`super::assessment`]).
//!
//! | `solve.method` | S | law | steps 3 and 4 | error of a solution |
//! |---|---|---|---|---|
//! | `auto`, `newton` | dense | any | strategies, each refined in twice the working precision | ≤ 10⁻³ |
//! | `auto` | implicit | Coulomb's | Newton–Krylov where supports hold the body | ≤ 10⁻³ |
//! | | | | else, or where that finds nothing: Algorithm 4.1 with GPCG, repeated with smaller ε | ≤ 5 % |
//! | `auto` | implicit | convex | one minimisation by GPCG, repeated with smaller ε | ≤ 5 % |
//! | | | | else, where S fits: it is formed, and strategies | ≤ 10⁻³ |
//! | `fixed-point` | any | any | Algorithm 4.1 or one minimisation; repeated where a dense S has single precision | ≤ 5 % |
//!
//! Loops from the outside in: meshes of an error asked for (`adaptation`), increments of a history and their passes (`problem/run.rs`;
//! with an implicit S each may begin on coarser meshes, `problem/nested.rs`), strategies (here), and in each of these the steps of its
//! method, the rounds of refinement, and iterations for linear systems and minimisations.
//!
//! Methods that stop by a rule of their own keep a solution that is less accurate, and say so ([`Status::ReducedAccuracy`]). Newton's
//! method, as `solve.method` or as the inner solver, needs a dense S ([`NeedsExplicit`]).

use std::{cell::OnceCell, time::Instant};

use super::{
    FrictionState, Inner, LocalMapping, MappingValue, MethodResult, NeedsExplicit, OuterStep,
    PaneLaws, Progress, RigidMotions, Solution, SolvedBy, Start, StartStrategy, Status, StopReason,
    SuccessiveApproximations, Trace,
    accuracy::Refined,
    assessment::{Assessment, is_far},
    conditions::Bound,
    coulomb_state,
    equilibrium::{mechanism, null_space_motions, sliding_mechanism},
    evaluate_mapping,
    inner::projected_gradient_steplength,
    minimisation::minimise,
    newton::{NewtonDriver, NewtonSolution},
    pane_laws::slip_of,
    problem::{ContactBody, ContactProblem, ContactSide, ContactSolve},
    tolerances::REFINEMENT_TARGET,
};
use crate::{
    contact::{CoulombLaw, slips},
    dual::{
        BalancedOperator, BodyOperator, ContactOperator, DualOperator, DualSystem, ExplicitDual,
        LocalStiffness, PrimalOperator,
    },
    scene::{Method, SolveSettings},
};

/// u = A⁻¹l.
pub(crate) fn without_contact(system: &DualSystem) -> Solution {
    let assembly = &system.assembly;
    let load = &assembly.primal.load;
    let displacement = assembly.solve_refined(load, None, f64::EPSILON).value;
    let trace = Trace {
        applications: 1,
        ..Trace::default()
    };
    Assessment::of_direct().solution(Vec::new(), displacement, trace)
}

impl ContactProblem<'_> {
    /// Solves the problem as the settings say from a start; counts of evaluations of laws go on from an earlier solve. The solution
    /// lacks its `local_mapping`.
    ///
    /// # Errors
    /// [`NeedsExplicit`] when Newton's method is asked for, as the method or as the inner solver, and S is not dense.
    pub fn solve(
        &self,
        settings: &SolveSettings,
        start: Start<'_>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Result<Solution, NeedsExplicit> {
        let n = self.dual.layout().n_multipliers();
        let solve = ContactSolve {
            dual: &self.dual,
            laws: &self.laws,
            body: self.body,
            system: self.system,
            settings,
            start: Start {
                multiplier: start.multiplier.filter(|it| it.len() == n),
                checkpoint: start.checkpoint.filter(|it| it.multiplier.len() == n),
            },
        };
        solve.run(observe)
    }

    /// Adds how the mapping Ψ behaves at a solution: with Coulomb's law and a dense operator, and where supports hold the body, for else
    /// the mapping is not one of multipliers alone. Not where contact springs gave the solution: there S without them is too inexact.
    pub(crate) fn linearise(&self, solution: &mut Solution) {
        if solution.trace.strategy == Some(StartStrategy::ContactSprings) {
            return;
        }
        let dual = &self.dual;
        let parts = (dual.explicit(), self.laws.coulomb(), &mut solution.friction);
        if let (Some(explicit), Some(law), Some(friction)) = parts
            && dual.rigid().is_none()
        {
            let multiplier = &solution.multiplier;
            friction.local_mapping = LocalMapping::new(explicit, &self.laws, law, multiplier);
        }
    }
}

impl ContactSolve<'_> {
    fn run(&self, observe: &mut dyn FnMut(Progress<'_>)) -> Result<Solution, NeedsExplicit> {
        if let Some(mechanism) = self.mechanism() {
            let mut solution = self.at_rest(Assessment::of_mechanism(), Trace::default());
            solution.rigid.get_or_insert_default().mechanism = Some(mechanism);
            return Ok(solution);
        }
        let ContactSide { surface, interface } = self.body.face;
        let primal = &self.body.assembly.primal;
        if self.dual.is_unloaded(primal, surface, interface) {
            return Ok(self.at_rest(Assessment::of_direct(), Trace::default()));
        }
        let set = self.laws.feasible_set(None);
        let bound = Bound::of(self.laws, &set);
        Ok(self.finalize(self.by_method(bound, observe)?))
    }

    /// By the method of the table above.
    fn by_method(
        &self,
        bound: Bound<'_>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Result<Solution, NeedsExplicit> {
        Ok(match (self.settings.method, self.dual.explicit(), bound) {
            (Method::FixedPoint, ..) => self.by_given_method(bound, observe)?,
            (Method::Newton | Method::Auto, Some(dual), _) => {
                self.by_strategies(dual, bound, observe)
            }
            (Method::Newton, None, _) => return Err(NeedsExplicit("method newton")),
            (Method::Auto, None, Bound::Coulomb(_, law)) => {
                let found = self.by_newton_krylov(law, observe);
                found.unwrap_or_else(|tried| {
                    let solution = self.by_gradients(bound, usize::MAX, observe);
                    solution.after(tried)
                })
            }
            (Method::Auto, None, Bound::Given(_)) => {
                let limit = self.products_before_dense();
                let solution = self.by_gradients(bound, limit.unwrap_or(usize::MAX), observe);
                if limit.is_none() || solution.status.is_solved() {
                    return Ok(solution);
                }
                let dense = self.by_strategies(&self.dense(), bound, observe);
                dense.after(solution.trace)
            }
        })
    }

    /// A rigid-body motion that proves that there is no equilibrium.
    fn mechanism(&self) -> Option<Vec<[f64; 3]>> {
        let equilibrium = self.dual.rigid()?;
        let assembly = self.body.assembly;
        mechanism(assembly, equilibrium, self.laws)
            .or_else(|| sliding_mechanism(assembly, self.dual.explicit()?, self.laws))
    }

    /// The first refined solution to which a strategy leads; without one, what came nearest.
    fn by_strategies(
        &self,
        dual: &ExplicitDual,
        bound: Bound<'_>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Solution {
        let started = Instant::now();
        let local = LocalStiffness::new(dual);
        let driver = NewtonDriver::new(dual, &local, bound, self.start.multiplier);
        let augmented = OnceCell::new();
        let mut trace = Trace::default();
        let mut nearest: Option<Attempt<'_>> = None;
        let mut approximations: Option<MethodResult> = None;
        for strategy in driver.strategies(self.settings.method) {
            // The first solution ends it, but contact springs follow one that misses ε.
            let accepted = match strategy {
                StartStrategy::ContactSprings => self.settings.epsilon().max(dual.rounding()),
                _ => REFINEMENT_TARGET,
            };
            if nearest
                .as_ref()
                .is_some_and(|it| it.refined.error <= accepted)
            {
                continue;
            }
            let (solve, driver) = match strategy {
                StartStrategy::ContactSprings => {
                    let system = augmented.get_or_init(|| self.augmented()).as_ref();
                    match system.and_then(|it| self.with_contact_springs(driver, it)) {
                        Some(with) => with,
                        None => continue,
                    }
                }
                _ => (*self, driver),
            };
            let found = match strategy {
                StartStrategy::SuccessiveApproximations => {
                    let outer = self.by_inner(Inner::Newton(dual, &local), observe);
                    self.found_by_approximations(dual, approximations.insert(outer))
                }
                _ => {
                    let observe = |k: usize, step: &_| observe(Progress::Newton(k, step));
                    driver.run(strategy, trace.newton.len(), observe)
                }
            };
            let refined = solve.refined_if_found(&driver, strategy, &found);
            let steps = found.history.iter().chain(&refined.history);
            trace.newton.extend(steps);
            trace.applications += found.evaluations + refined.applications;
            let next = Attempt {
                residual: match refined.error.is_finite() {
                    true => 0.0,
                    false => driver.residual(&found.unknowns),
                },
                solve,
                driver,
                strategy,
                refined,
            };
            if nearest.as_ref().is_none_or(|it| next.is_nearer_than(it)) {
                nearest = Some(next);
            }
        }
        let nearest = nearest.expect("some strategy always applies");
        let mut solution = nearest.assessed(approximations, started);
        solution.trace.applications += trace.applications;
        solution.trace.newton = trace.newton;
        solution
    }

    /// The problem with contact springs and its local stiffness, where gaps lose their digits in S.
    fn augmented(&self) -> Option<(DualSystem, LocalStiffness)> {
        let ContactSide { surface, interface } = self.body.face;
        let system = self.system.with_contact_springs((surface, interface))?;
        let local = LocalStiffness::new(system.contact.as_ref()?.explicit()?);
        Some((system, local))
    }

    /// The same solve of this problem.
    fn with_contact_springs<'a>(
        &'a self,
        driver: NewtonDriver<'a>,
        (system, local): &'a (DualSystem, LocalStiffness),
    ) -> Option<(ContactSolve<'a>, NewtonDriver<'a>)> {
        let dual = system.contact.as_ref()?;
        let body = ContactBody {
            assembly: &system.assembly,
            ..self.body
        };
        let driver = NewtonDriver {
            dual: dual.explicit()?,
            local,
            ..driver
        };
        Some((
            ContactSolve {
                dual,
                body,
                ..*self
            },
            driver,
        ))
    }

    /// Successive approximations as a start of Newton's method, which needs no more than one in the right zones.
    fn found_by_approximations(&self, dual: &ExplicitDual, outer: &MethodResult) -> NewtonSolution {
        NewtonSolution {
            // Whatever their rule says: a cycle may turn about a solution.
            stop: match outer.stop {
                StopReason::NumericalError => StopReason::NumericalError,
                _ => StopReason::Converged,
            },
            unknowns: self.unknowns(&outer.solution),
            evaluations: outer.solution.trace.applications,
            ..NewtonSolution::failed(dual)
        }
    }

    /// What a strategy found, refined and measured; where it found nothing, its best iterate with an infinite error.
    fn refined_if_found(
        &self,
        driver: &NewtonDriver<'_>,
        strategy: StartStrategy,
        found: &NewtonSolution,
    ) -> Refined {
        let mut refined = match found.stop.is_solution() {
            true => self.refined(driver, strategy, &found.unknowns, self.tolerance()),
            false => self.about(driver, &found.unknowns, None, f64::EPSILON),
        };
        let most = f64::EPSILON.sqrt().recip();
        if self.dual.rigid().is_some() && is_far(&refined.displacement, self.laws, most) {
            refined.error = f64::INFINITY;
        }
        refined
    }

    /// What is asked of a refined solution.
    fn tolerance(&self) -> f64 {
        self.settings.epsilon().min(REFINEMENT_TARGET)
    }

    /// A body that nothing loads, or that floats and for which no contact forces were found: it rests, without any.
    fn at_rest(&self, assessment: Assessment, trace: Trace) -> Solution {
        let (laws, primal) = (self.laws, &self.body.assembly.primal);
        let displacement = vec![0.0; primal.dofs.n_free];
        let tangential = || self.body.tangential(&displacement);
        let slip = || slips(laws.previous.as_ref(), &tangential());
        let friction = laws.coulomb().map(|law| FrictionState {
            coulomb: laws
                .without_pressure(law, &law.depends_on_slip().then(slip).unwrap_or_default()),
            ..FrictionState::default()
        });
        let floating = primal.rigid_modes.as_ref();
        let motion = floating.map(|body| RigidMotions::of(&vec![0.0; body.n_modes()]));
        let multiplier = vec![0.0; laws.layout.n_multipliers()];
        Solution {
            rigid: motion,
            friction,
            ..assessment.solution(multiplier, displacement, trace)
        }
    }

    /// The solution in the frame of the scene: demoted where a number is out of range, with its rigid motion about zero and without the
    /// null space of contact.
    fn finalize(&self, mut solution: Solution) -> Solution {
        let (dual, laws) = (self.dual, self.laws);
        let assembly = self.body.assembly;
        let mut numbers = solution.multiplier.iter().chain(&solution.displacement);
        let mut friction = solution.friction.iter();
        let is_in_range =
            numbers.all(|v| v.is_finite()) && friction.all(|it| it.coulomb.is_admissible(laws));
        if !is_in_range {
            solution.assess(solution.assessment().out_of_range());
        }
        solution.trace.law_evaluations = laws.law_evaluations();
        if let Some(equilibrium) = dual.rigid() {
            let rigid = solution.rigid.get_or_insert_default();
            rigid.motion = equilibrium.add_reference(&rigid.motion, &mut solution.displacement);
            // Where no strategy led to a solution, the place of the last iterate means nothing.
            let has_found_nothing =
                solution.status == Status::MaxNewtonSteps && solution.trace.strategy.is_some();
            let is_nowhere = has_found_nothing || is_far(&solution.displacement, laws, 1.0);
            if !solution.status.is_solved() && is_nowhere {
                return self.at_rest(Assessment::unknown(solution.status), solution.trace);
            }
            rigid.null_space = null_space_motions(assembly, equilibrium);
            // A motion that moves no pane may still change the slip of nodes, and coefficients with it.
            let follows_slip = |friction: &FrictionState| friction.slip.is_some();
            if !solution.friction.as_ref().is_some_and(follows_slip) {
                let coupling = &equilibrium.coupling;
                coupling.remove_null_space(&mut solution.displacement, &mut rigid.motion);
            }
        }
        solution
    }

    /// One minimisation, or one after the other for Coulomb's law (Algorithm 4.1, [`super::fixed_point`]), with an inner solver
    /// ([`super::inner`]).
    pub(super) fn by_inner(
        &self,
        inner: Inner<'_>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> MethodResult {
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

    /// Runs a method on the operator that the assembly holds, balanced where contact holds the body, and solves for u to rounding.
    fn with_operator(
        &self,
        run: impl FnOnce(&mut BodyOperator<'_, '_>) -> MethodResult,
    ) -> MethodResult {
        let assembly = self.body.assembly;
        let mut operator: Box<dyn PrimalOperator + '_> = match self.dual.explicit() {
            Some(dual) => Box::new(ContactOperator::explicit(dual, assembly, self.dual)),
            None => Box::new(ContactOperator::implicit(assembly, self.dual)),
        };
        let mut found = match self.dual.rigid() {
            None => run(&mut BodyOperator::Constrained(&mut *operator)),
            Some(equilibrium) => {
                let mut operator = BalancedOperator::new(operator, equilibrium);
                let mut found = run(&mut BodyOperator::Floating(&mut operator));
                let motion = operator.motion(&found.solution.multiplier);
                found.solution.rigid = Some(RigidMotions::of(&motion));
                found
            }
        };
        let unknowns = self.unknowns(&found.solution);
        found.solution.displacement = self.state_at(&unknowns, None, f64::EPSILON).displacement;
        found
    }
}

/// The state of friction at what came nearest to a solution, with its image under Ψ.
fn friction_at(
    refined: &Refined,
    laws: &PaneLaws,
    law: &CoulombLaw,
    image: &MappingValue,
) -> FrictionState {
    let slip = || slip_of(&refined.dual, laws, &refined.unknowns);
    FrictionState {
        slip: law.depends_on_slip().then(slip),
        coulomb: coulomb_state(&refined.dual, laws, law, &refined.unknowns),
        mapping_change: Some(image.relative_change).filter(|change| change.is_finite()),
        local_mapping: None,
    }
}

/// What one strategy led to.
struct Attempt<'a> {
    solve: ContactSolve<'a>,
    driver: NewtonDriver<'a>,
    strategy: StartStrategy,
    /// ‖R‖ / ‖λ‖ before the refinement, by local stiffness whatever the strategy measured by; 0 where an error is known.
    residual: f64,
    refined: Refined,
}

impl Attempt<'_> {
    /// Whether it comes nearer to a solution than another one; where neither has an error, by the residual. NaN is no progress.
    fn is_nearer_than(&self, other: &Self) -> bool {
        self.refined.error < other.refined.error
            || !other.refined.error.is_finite() && self.residual < other.residual
    }

    /// The solution with its status, ᾱ, and the state of friction.
    fn assessed(self, approximations: Option<MethodResult>, started: Instant) -> Solution {
        let Self {
            solve,
            driver,
            strategy,
            refined,
            ..
        } = self;
        let NewtonDriver {
            dual, local, bound, ..
        } = driver;
        let stop = approximations.as_ref().map(|outer| outer.stop);
        let epsilon = solve.settings.epsilon();
        let assessment = match refined.is_solution() {
            true => Assessment::of_refined(refined.error, epsilon, dual.rounding()),
            false => Assessment::of_unsolved(refined.error, stop),
        };
        let mut operator = ContactOperator::explicit(dual, solve.body.assembly, solve.dual);
        let steplength = projected_gradient_steplength(&mut operator);
        let applications = operator.applications();
        let history = approximations.map_or_else(Vec::new, |outer| outer.solution.trace.history);
        let mut trace = Trace {
            strategy: Some(strategy),
            steplength,
            local_stiffness: local.stiffness.clone(),
            history,
            applications,
            ..Trace::default()
        };
        let friction = match bound {
            Bound::Given(_) => {
                trace.solved_by = SolvedBy::Minimisation;
                trace.history.push(OuterStep {
                    inner_tolerance: solve.tolerance(),
                    inner_residual: refined.error.min(1.0),
                    applications,
                    seconds: started.elapsed().as_secs_f64(),
                    ..OuterStep::default()
                });
                None
            }
            Bound::Coulomb(laws, law) => {
                trace.solved_by = match strategy {
                    StartStrategy::SuccessiveApproximations => SolvedBy::FixedPoint,
                    _ => SolvedBy::Newton,
                };
                let image = evaluate_mapping(&refined.dual, local, laws, law, &refined.unknowns);
                trace.applications += image.evaluations;
                Some(friction_at(&refined, laws, law, &image))
            }
        };
        let motion = dual.rigid.is_some().then(|| dual.motion(&refined.unknowns));
        let about = NewtonDriver {
            dual: &refined.dual,
            ..driver
        };
        let multiplier = about.map().stresses(&refined.unknowns);
        Solution {
            rigid: motion.map(RigidMotions::of),
            friction,
            ..assessment.solution(multiplier, refined.displacement, trace)
        }
    }
}

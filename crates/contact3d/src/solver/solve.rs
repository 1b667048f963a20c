//! The solve of a contact problem, step by step.
//!
//! 1. *Equilibrium.* Where contact alone holds the body, a rigid-body motion that no admissible contact forces resist proves that there
//!    is no solution ([`super::equilibrium`]).
//! 2. *Operator.* With a dense S Newton's method has the matrix of its derivative. Without, it multiplies with S through the factor, or
//!    a gradient method does ([`super::by_products`]).
//! 3. *Strategies.* Starts of Newton's method are tried in order ([`super::strategy`]) until one leads to a solution.
//! 4. *Refinement.* Displacements and gaps are solved in twice the working precision, and Newton's method goes on with these refined
//!    residuals. The distance that is left is the error of λ ([`super::accuracy`]).
//! 5. *Assessment.* The error decides the status ([`super::assessment`]).
//!
//! Algorithm 4.1 of the paper (`solve.method = "fixed_point"`) takes the place of 3 and 4, and its error is measured alike.

use std::time::Instant;

use super::{
    FrictionState, Inner, MethodResult, NeedsExplicit, OuterStep, Progress, RigidMotions, Solution,
    SolvedBy, Status, StopReason, SuccessiveApproximations, Trace,
    accuracy::Refined,
    assessment::{Assessment, REFINEMENT_TARGET, is_far},
    conditions::Bound,
    coulomb_state,
    equilibrium::{mechanism, null_space_motions, sliding_mechanism},
    evaluate_mapping,
    inner::projected_gradient_steplength,
    minimisation::minimise,
    newton::NewtonSolution,
    pane_laws::slip_of,
    problem::ContactSolve,
    strategy::{NewtonDriver, StartStrategy},
};
use crate::{
    dual::{
        BalancedOperator, BodyOperator, ContactOperator, DualOperator, DualSystem, ExplicitDual,
        LocalStiffness, PrimalOperator,
    },
    scene::Method,
};

/// u = A⁻¹l.
pub(crate) fn without_contact(system: &DualSystem) -> Solution {
    let assembly = &system.assembly;
    let load = &assembly.primal.load;
    Solution {
        displacement: assembly.solve_refined(load, None, f64::EPSILON).value,
        trace: Trace {
            applications: 1,
            ..Trace::default()
        },
        ..Solution::default()
    }
}

impl ContactSolve<'_> {
    pub(super) fn run(
        &self,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Result<Solution, NeedsExplicit> {
        if let Some(mechanism) = self.mechanism() {
            let mut solution = Solution::unsolved(self).assessed(Assessment::of_mechanism());
            solution.rigid.get_or_insert_default().mechanism = Some(mechanism);
            return Ok(solution);
        }
        let set = self.laws.feasible_set(None);
        let bound = Bound::of(self.laws, &set);
        let solution = match (self.settings.method, self.dual.explicit()) {
            (Method::FixedPoint, _) => self.by_given_method(bound, observe)?,
            (Method::Newton, None) => return Err(NeedsExplicit("method newton")),
            (Method::Auto, None) => self.by_products(bound, observe),
            (Method::Newton | Method::Auto, Some(dual)) => self.by_strategies(dual, bound, observe),
        };
        Ok(self.finalize(solution))
    }

    /// A rigid-body motion that proves that there is no equilibrium.
    fn mechanism(&self) -> Option<Vec<[f64; 3]>> {
        let balance = self.dual.rigid()?;
        let assembly = self.body.assembly;
        mechanism(assembly, balance, self.laws)
            .or_else(|| sliding_mechanism(assembly, self.dual.explicit()?, self.laws))
    }

    /// The first refined solution to which a strategy leads; without one, what came nearest.
    pub(super) fn by_strategies(
        &self,
        dual: &ExplicitDual,
        bound: Bound<'_>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Solution {
        let started = Instant::now();
        let local = LocalStiffness::new(dual);
        let driver = NewtonDriver {
            dual,
            bound,
            local: &local,
            start: self.start.multiplier,
        };
        let mut trace = Trace::default();
        let mut best: Option<(StartStrategy, Refined)> = None;
        let mut least = f64::INFINITY;
        let mut fixed_point: Option<MethodResult> = None;
        for strategy in driver.strategies() {
            let found = if strategy == StartStrategy::SuccessiveApproximations {
                if self.settings.method == Method::Newton {
                    break;
                }
                let outer = self.by_inner(Inner::Newton(dual, &local), observe);
                let found = self.found_by_approximations(&outer);
                fixed_point = Some(outer);
                found
            } else {
                let observe = |k: usize, step: &_| observe(Progress::Newton(k, step));
                driver.run(strategy, trace.newton.len(), observe)
            };
            let mut next = if found.stop.is_solution() {
                self.refined(&driver, strategy, &found.multiplier, self.tolerance())
            } else {
                self.about(&driver, &found.multiplier, None, f64::EPSILON)
            };
            trace
                .newton
                .extend(found.history.iter().chain(&next.history));
            trace.applications += found.evaluations + next.applications;
            let most = f64::EPSILON.sqrt().recip();
            if self.dual.rigid().is_some() && is_far(&next.displacement, self.laws, most) {
                next.error = f64::INFINITY;
            }
            // NaN is no progress. Where nothing led to a solution, what came closest is where another try may begin.
            let is_nearer = |(_, best): &(_, Refined)| {
                next.error < best.error || best.error.is_infinite() && found.residual < least
            };
            let is_solution = next.is_solution();
            if best.as_ref().is_none_or(is_nearer) {
                least = found.residual;
                best = Some((strategy, next));
            }
            if is_solution {
                break;
            }
        }
        let (strategy, best) = best.expect("some strategy always applies");
        let mut solution = self.assessed(&driver, strategy, best, fixed_point, started);
        solution.trace.applications += trace.applications;
        solution.trace.newton = trace.newton;
        solution
    }

    /// Successive approximations as a start of Newton's method, which needs no more than one in the right zones.
    fn found_by_approximations(&self, outer: &MethodResult) -> NewtonSolution {
        NewtonSolution {
            // Whatever their rule says: a cycle may turn about a solution.
            stop: match outer.stop {
                StopReason::NumericalError => StopReason::NumericalError,
                _ => StopReason::Converged,
            },
            multiplier: self.unknowns(&outer.solution),
            residual: outer.measure,
            history: Vec::new(),
            evaluations: outer.solution.trace.applications,
        }
    }

    /// What is asked of a refined solution.
    fn tolerance(&self) -> f64 {
        self.settings.epsilon().min(REFINEMENT_TARGET)
    }

    /// A refined solution with its status, ᾱ, and one evaluation of Ψ.
    fn assessed(
        &self,
        driver: &NewtonDriver<'_>,
        strategy: StartStrategy,
        found: Refined,
        fixed_point: Option<MethodResult>,
        started: Instant,
    ) -> Solution {
        let NewtonDriver {
            dual, local, bound, ..
        } = *driver;
        let mut numbers = found.multiplier.iter().chain(&found.displacement);
        let assessment = match &fixed_point {
            _ if !numbers.all(|v| v.is_finite()) => {
                Assessment::of_no_solution(found.error).out_of_range()
            }
            // Successive approximations may leave the range of numbers where Newton's method only finds nothing.
            Some(outer) if !found.is_solution() && outer.stop != StopReason::NumericalError => {
                Assessment::of_lost_fixed_point(outer, found.error)
            }
            _ if !found.is_solution() => Assessment::of_no_solution(found.error),
            _ => Assessment::of_refined(found.error, self.settings.epsilon(), dual.rounding()),
        };
        let mut operator = ContactOperator::explicit(dual, self.body.assembly, self.dual);
        let mut trace = Trace {
            steplength: projected_gradient_steplength(&mut operator),
            strategy: Some(strategy),
            local_stiffness: local.stiffness.clone(),
            applications: operator.applications(),
            ..Trace::default()
        };
        let friction = match bound {
            Bound::Frozen(_) => {
                trace.solved_by = SolvedBy::Minimisation;
                trace.history = vec![OuterStep {
                    inner_tolerance: self.tolerance(),
                    inner_residual: found.error.min(1.0),
                    applications: trace.applications,
                    seconds: started.elapsed().as_secs_f64(),
                    ..OuterStep::default()
                }];
                None
            }
            Bound::Coulomb(laws, law) => {
                let image = evaluate_mapping(&found.dual, local, laws, law, &found.multiplier);
                trace.solved_by = match strategy {
                    StartStrategy::SuccessiveApproximations => SolvedBy::FixedPoint,
                    _ => SolvedBy::Newton,
                };
                trace.applications += image.evaluations;
                let slip = || slip_of(&found.dual, laws, &found.multiplier);
                Some(FrictionState {
                    slip: law.depends_on_slip().then(slip),
                    coulomb: coulomb_state(&found.dual, laws, law, &found.multiplier),
                    mapping_change: Some(image.relative_change),
                    local_mapping: None,
                })
            }
        };
        if let Some(outer) = fixed_point {
            trace.history = outer.solution.trace.history;
        }
        let motion = dual.rigid.is_some().then(|| dual.motion(&found.multiplier));
        Solution {
            multiplier: dual.multipliers(&found.multiplier).to_vec(),
            displacement: found.displacement,
            rigid: motion.map(RigidMotions::of),
            friction,
            trace,
            ..Solution::default()
        }
        .assessed(assessment)
    }

    /// A solution with its whole rigid motion, and what belongs to it.
    fn finalize(&self, mut solution: Solution) -> Solution {
        let (dual, laws) = (self.dual, self.laws);
        let assembly = self.body.assembly;
        let mut friction = solution.friction.iter();
        if !friction.all(|it| it.coulomb.is_admissible(laws)) {
            let assessment = solution.assessment().out_of_range();
            solution = solution.assessed(assessment);
        }
        solution.trace.law_evaluations = laws.law_evaluations();
        if let Some(balance) = dual.rigid() {
            let rigid = solution.rigid.get_or_insert_default();
            rigid.motion = balance.add_reference(&rigid.motion, &mut solution.displacement);
            // Where no strategy led to a solution, the place of the last iterate means nothing.
            let is_nowhere = solution.status == Status::MaxNewtonSteps
                || is_far(&solution.displacement, laws, 1.0);
            if !solution.status.is_solved() && is_nowhere {
                let assessment = Assessment {
                    accuracy: 1.0,
                    ..solution.assessment()
                };
                return Solution {
                    trace: solution.trace,
                    ..Solution::unsolved(self).assessed(assessment)
                };
            }
            rigid.null_space = null_space_motions(assembly, balance);
            // Coefficients that follow the slip of nodes may feel what panes do not.
            let follows_slip = |friction: &FrictionState| friction.slip.is_some();
            if !solution.friction.as_ref().is_some_and(follows_slip) {
                let coupling = &balance.coupling;
                coupling.remove_null_space(&mut solution.displacement, &mut rigid.motion);
            }
        }
        solution
    }

    /// One minimisation, or one after the other for Coulomb's law (Algorithm 4.1), with an inner solver.
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
            Some(balance) => {
                let mut operator = BalancedOperator::new(operator, balance);
                let mut found = run(&mut BodyOperator::Floating(&mut operator));
                let motion = operator.motion(&found.solution.multiplier);
                found.solution.rigid = Some(RigidMotions::of(&motion));
                found
            }
        };
        let unknowns = self.unknowns(&found.solution);
        let solved = self.dual.refined(assembly, &unknowns, None, f64::EPSILON);
        found.solution.displacement = solved.value;
        let (_, motion) = self.dual.parts(&unknowns);
        self.dual
            .add_motion(motion, &mut found.solution.displacement);
        found
    }
}

//! Newton's method on the whole problem, and the answer that comes of it.

use std::time::Instant;

use super::{
    NewtonStep, OuterStep, Progress, Solution, SolvedBy, Status, StepCounts,
    accuracy::polish::{COARSEST, Polished},
    conditions::Bound,
    coulomb_state, evaluate_mapping,
    inner::projected_gradient_steplength,
    newton::search::Search,
    pane_laws::slip_of,
    problem::DiscreteProblem,
};
use crate::dual::{ContactOperator, DualOperator, ExplicitDual, LocalStiffness};

impl DiscreteProblem<'_> {
    /// Newton's method on the whole problem, by one way after the other until the polished answer
    /// is a solution.
    pub(super) fn newton(
        &self,
        dual: &ExplicitDual,
        local: &LocalStiffness,
        bound: Bound<'_>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Solution {
        let started = Instant::now();
        let search = Search {
            dual,
            bound,
            local,
            start: self.start.multiplier,
        };
        let mut history: Vec<NewtonStep> = Vec::new();
        let mut applications = 0;
        let mut best: Option<Polished> = None;
        let mut least = f64::INFINITY;
        for way in search.ways() {
            let observe = |k: usize, step: &NewtonStep| observe(Progress::Newton(k, step));
            let found = search.go(way, history.len(), observe);
            history.extend(&found.history);
            applications += found.evaluations;
            let next = if found.is_solution() {
                self.polished(dual, local, bound, &found.multiplier, self.tolerance())
            } else {
                self.exact(dual, local, &found.multiplier, None, f64::EPSILON)
            };
            history.extend(&next.history);
            applications += next.applications;
            // NaN is no progress. Where no way led to a solution, the one that came closest is where another try may begin.
            let is_nearer = |best: &Polished| {
                next.error < best.error || best.error.is_infinite() && found.residual < least
            };
            if best.as_ref().is_none_or(is_nearer) {
                least = found.residual;
                best = Some(next);
            }
            if best.as_ref().is_some_and(Polished::is_solution) {
                break;
            }
        }
        let best = best.expect("there is always a way");
        let solution = self.answer(dual, local, bound, best, started);
        Solution {
            newton: history,
            applications: applications + solution.applications,
            ..solution
        }
    }

    /// What is asked of a polished answer.
    fn tolerance(&self) -> f64 {
        self.settings.epsilon().min(COARSEST)
    }

    /// Judges a polished answer, and completes it with ᾱ and one evaluation of Ψ.
    fn answer(
        &self,
        dual: &ExplicitDual,
        local: &LocalStiffness,
        bound: Bound<'_>,
        answer: Polished,
        started: Instant,
    ) -> Solution {
        let attainable = dual.rounding();
        let epsilon = self.settings.epsilon();
        let status = if !answer.is_finite() {
            Status::NumericalError
        } else if !answer.is_solution() {
            Status::MaxNewtonSteps
        } else if answer.error <= epsilon && epsilon >= attainable {
            Status::Converged
        } else {
            Status::RoundingLimit
        };
        let mut operator = ContactOperator::explicit(dual, self.body.assembly, self.dual);
        let steplength = projected_gradient_steplength(&mut operator);
        let mut solution = Solution {
            status,
            accuracy: match status {
                Status::RoundingLimit => answer.error.max(attainable),
                // An answer without a digit is off by its own size.
                _ => answer.error.min(1.0),
            },
            steplength,
            local_stiffness: local.stiffness.clone(),
            applications: operator.applications(),
            ..Solution::default()
        };
        match bound {
            Bound::Frozen(_) => {
                solution.solved_by = SolvedBy::Minimisation;
                solution.history = vec![OuterStep {
                    change: 0.0,
                    inner_tolerance: self.tolerance(),
                    inner_residual: answer.error.min(1.0),
                    steps: StepCounts::default(),
                    applications: solution.applications,
                    seconds: started.elapsed().as_secs_f64(),
                }];
            }
            Bound::Coulomb(laws, law) => {
                let image = evaluate_mapping(&answer.dual, local, laws, law, &answer.multiplier);
                solution.solved_by = SolvedBy::Newton;
                solution.mapping_change = Some(image.relative_change);
                solution.applications += image.evaluations;
                let slip = || slip_of(&answer.dual, laws, &answer.multiplier);
                solution.slip = law.depends_on_slip().then(slip);
                solution.coulomb = Some(coulomb_state(&answer.dual, laws, law, &answer.multiplier));
            }
        }
        solution.displacement = answer.displacement;
        solution.rigid_motion = dual.motion(&answer.multiplier).to_vec();
        solution.multiplier = dual.multipliers(&answer.multiplier).to_vec();
        solution
    }

    /// Takes the answer of successive approximations, after Newton's method failed in `steps`, to the
    /// accuracy of Newton's method, which needs no more than a start in the right zones.
    pub(super) fn completed(
        &self,
        dual: &ExplicitDual,
        local: &LocalStiffness,
        bound: Bound<'_>,
        mut solution: Solution,
        mut steps: Vec<NewtonStep>,
    ) -> Solution {
        let started = Instant::now();
        let unknowns = self.unknowns(&solution);
        let polished = self.polished(dual, local, bound, &unknowns, self.tolerance());
        steps.extend(&polished.history);
        let applications = solution.applications + polished.applications;
        if polished.is_solution() {
            let answer = self.answer(dual, local, bound, polished, started);
            solution = Solution {
                solved_by: SolvedBy::FixedPoint,
                applications: applications + answer.applications,
                history: solution.history,
                ..answer
            };
        } else if solution.status.is_solved() {
            solution.status = Status::Inaccurate;
            // An answer without a digit is off by its own size.
            solution.accuracy = polished.error.min(1.0);
        }
        solution.newton = steps;
        solution.local_stiffness.clone_from(&local.stiffness);
        solution
    }
}

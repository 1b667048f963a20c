//! The answers of other algorithms to the same problem.

use super::explicit_problem::ExplicitProblem;
use crate::StudyStep;
use contact3d::{
    ProblemError,
    contact::CoulombLaw,
    dual::LocalStiffness,
    scene::{InnerSolver, Method, PrecisionControl, SolveSettings},
    solver::{Linearisation, Solution, Status, evaluate_mapping},
};

/// Accuracy asked of all.
const TO_ROUNDING: f64 = 1e-12;

units::worded! {
    /// An algorithm that shares with the others only S and h.
    pub enum CrossCheck {
        /// The semismooth Newton method for slip bound and friction at once.
        Newton = "Newton",
        /// Successive approximations with Newton's method inside; one minimisation without Coulomb's
        /// law.
        FixedPointNewton = "fixed point with Newton",
        /// The same with GPCG inside.
        FixedPointGpcg = "fixed point with GPCG",
        /// λ ← λ + θ (Ψ(λ) − λ) with the paper's mapping Ψ and θ = ½, then ⅛: converges where Ψ itself
        /// oscillates. Only asked when fewer than two others find a solution.
        Averaged = "averaged fixed point",
    }
}

impl CrossCheck {
    fn settings(self) -> SolveSettings {
        let (method, inner) = match self {
            Self::Newton => (Method::Newton, InnerSolver::default()),
            Self::FixedPointNewton => (Method::FixedPoint, InnerSolver::Newton),
            Self::FixedPointGpcg | Self::Averaged => (Method::FixedPoint, InnerSolver::Gpcg),
        };
        SolveSettings {
            method,
            inner,
            epsilon: Some(TO_ROUNDING),
            precision: PrecisionControl::Fixed,
            // Applications of S that GPCG may take in one inner problem; a solve that needs more is reported as such.
            max_operator_applications: 100_000,
            ..SolveSettings::default()
        }
    }
}

/// What a cross-check found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossCheckResult {
    /// The algorithm.
    pub cross_check: CrossCheck,
    /// How it ended.
    pub status: Status,
    /// The error that it says its answer has.
    pub accuracy: f64,
    /// Steps of Newton's method, or of successive approximations.
    pub steps: usize,
    /// ‖λ − λ*‖ / ‖λ*‖ for the answer λ* of the program.
    pub disagreement: f64,
    /// ‖R(λ)‖ / ‖λ‖ of the natural map, the same yardstick for all.
    pub residual: f64,
}

impl CrossCheckResult {
    /// Whether the algorithm says that it has found a solution, as accurate as was asked or not.
    #[must_use]
    pub fn is_solution(&self) -> bool {
        match self.status {
            // An answer that says it is further from the solution than this says nothing of it.
            Status::ReducedAccuracy => self.accuracy <= 1e-6,
            status => status.is_solved(),
        }
    }
}

/// Solves by the cross-checks, as many as it takes.
pub(super) fn compare(
    problem: &ExplicitProblem,
    answer: &Solution,
    observe: &mut dyn FnMut(StudyStep),
) -> Result<Vec<CrossCheckResult>, ProblemError> {
    let mut results: Vec<CrossCheckResult> = Vec::new();
    for cross_check in CrossCheck::ALL {
        observe(StudyStep::Begin(cross_check.word().to_owned()));
        let (status, accuracy, steps, unknowns) = if cross_check == CrossCheck::Averaged {
            let solved = results.iter().filter(|result| result.is_solution());
            match problem.contact().interface.coulomb() {
                Some(law) if solved.count() < 2 => averaged(problem, law),
                _ => continue,
            }
        } else {
            let solution = problem.assembled.solve(&cross_check.settings())?;
            let steps = solution
                .trace
                .newton
                .len()
                .max(solution.trace.history.len());
            let unknowns = problem.unknowns(&solution.multiplier, &solution);
            (solution.status, solution.accuracy, steps, unknowns)
        };
        let multiplier = problem.dual().multipliers(&unknowns);
        let laws = problem.contact().laws();
        results.push(CrossCheckResult {
            cross_check,
            status,
            accuracy,
            steps,
            disagreement: problem.distance(multiplier, &answer.multiplier),
            residual: Linearisation::residual_of(problem.dual(), &laws, &unknowns),
        });
    }
    Ok(results)
}

/// Averaged successive approximations from λ = 0.
fn averaged(problem: &ExplicitProblem, law: &CoulombLaw) -> (Status, f64, usize, Vec<f64>) {
    let (dual, laws) = (problem.dual(), problem.contact().laws());
    let local = LocalStiffness::new(dual);
    let mut steps = 0;
    // Without pressure no friction balances the load of a body that floats.
    let start = match &dual.rigid {
        None => vec![0.0; dual.dimension()],
        Some(_) => local.bonded_start(dual),
    };
    let mut multiplier = start.clone();
    for share in [0.5, 0.125] {
        multiplier.clone_from(&start);
        // Steps of averaging with one share; from 1 to rounding ½ takes 45.
        for _ in 0..400 {
            let image = evaluate_mapping(dual, &local, &laws, law, &multiplier);
            steps += 1;
            for (l, image) in multiplier.iter_mut().zip(&image.unknowns) {
                *l += share * (image - *l);
            }
            if image.relative_change <= TO_ROUNDING {
                return (Status::Converged, image.relative_change, steps, multiplier);
            }
        }
    }
    (Status::MaxOuterSteps, 1.0, steps, multiplier)
}

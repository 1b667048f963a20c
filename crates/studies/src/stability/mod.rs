//! How far an answer can be trusted: conditioning, agreement of independent algorithms, and
//! invariance under all that must not matter.

mod conditioning;
mod cross_checks;
mod explicit_problem;
mod invariance;
mod obstacles;
mod scaling;
mod symmetry;
#[cfg(test)]
mod tests;
mod verdict;

pub use conditioning::RoundingBound;
pub use conditioning::{Conditioning, Spectrum};
pub use cross_checks::{CrossCheck, CrossCheckResult};
pub use invariance::{Invariance, InvarianceResult};
pub(crate) use scaling::UnitChange;
pub(crate) use symmetry::Symmetry;
pub use verdict::{GOAL, Verdict, VerdictLevel};

use std::{path::Path, time::Instant};

use explicit_problem::ExplicitProblem;

use contact3d::{
    ProblemError,
    linalg::Precision,
    post::Zone,
    scene::{FactorPrecision, Scene},
    solver::{Linearisation, SolvedBy, Start, Status},
};

/// How much is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// Conditioning, algorithms, certificate.
    Solve,
    /// These, and the problem in every other description.
    Invariances,
}

/// How many solutions are expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solutions {
    /// One, on which all algorithms must agree.
    One,
    /// Several: an algorithm may find another one, if it is one.
    Several,
}

/// All that is known of one problem.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// How many solutions were expected.
    pub solutions: Solutions,
    /// Free degrees of freedom.
    pub n_free: usize,
    /// Multipliers.
    pub n_multipliers: usize,
    /// Precision of the factor that the scene's own settings took.
    pub precision: Precision,
    /// How the solve with the scene's own settings ended.
    pub status: Status,
    /// Which algorithm gave the answer.
    pub solved_by: SolvedBy,
    /// Steps of Newton's method, and of successive approximations.
    pub steps: [usize; 2],
    /// The accuracy ε that was asked for.
    pub asked: f64,
    /// The accuracy that the solver says it reached.
    pub accuracy: f64,
    /// Open, sticking and slipping panes.
    pub zones: [usize; 3],
    /// The largest figure of the certificate.
    pub certificate: f64,
    /// Condition of A and S.
    pub conditioning: Conditioning,
    /// R' at the answer.
    pub linearisation: Linearisation,
    /// What rounding allows.
    pub rounding_bound: RoundingBound,
    /// What other algorithms found.
    pub cross_checks: Vec<CrossCheckResult>,
    /// What other descriptions of the problem gave; empty unless asked for.
    pub invariances: Vec<InvarianceResult>,
    /// Wall-clock seconds of assembly and solve, without the comparisons.
    pub seconds: f64,
}

impl Check {
    /// Checks a scene with contact; mesh files are looked for in `folder`. An answer from a factor in single precision is held
    /// against those from one in double precision.
    ///
    /// # Errors
    /// [`ProblemError`] for a scene that has no discrete problem.
    pub fn new(
        scene: &Scene,
        folder: &Path,
        depth: Depth,
        solutions: Solutions,
    ) -> Result<Self, ProblemError> {
        let started = Instant::now();
        let mut own = ExplicitProblem::new(scene.clone(), folder)?;
        scene.solve.validate("solve")?;
        let mut answer = own
            .assembled
            .solve_from(&scene.solve, Start::default(), &mut |_| {})?;
        if answer.status.gave_up(&scene.solve)
            && scene.assemble.factor == FactorPrecision::Auto
            && let Some(double) = own.in_double_precision(scene, folder)?
        {
            own = double;
            answer = own.assembled.solve(&scene.solve)?;
        }
        let seconds = started.elapsed().as_secs_f64();
        let double = own.in_double_precision(scene, folder)?;
        let problem = double.as_ref().unwrap_or(&own);
        let report = problem.assembled.report(&answer)?;
        report.judge(&mut answer);
        let laws = problem.contact().laws();
        let unknowns = problem.unknowns(&answer.multiplier, &answer);
        let linearisation = Linearisation::new(problem.dual(), &laws, &unknowns);
        let conditioning = Conditioning::of(problem);
        Ok(Self {
            solutions,
            n_free: answer.displacement.len(),
            n_multipliers: answer.multiplier.len(),
            precision: own.precision(),
            status: answer.status,
            solved_by: answer.solved_by,
            steps: [answer.newton.len(), answer.history.len()],
            asked: scene.solve.epsilon(),
            accuracy: answer.accuracy,
            zones: [Zone::Open, Zone::Stick, Zone::Slip].map(|zone| report.count(zone)),
            certificate: report.certificate.worst(),
            rounding_bound: RoundingBound::of(
                problem,
                &answer,
                &report,
                &conditioning,
                &linearisation,
            ),
            conditioning,
            linearisation,
            cross_checks: cross_checks::compare(problem, &answer)?,
            invariances: match depth {
                Depth::Solve => Vec::new(),
                Depth::Invariances => invariance::compare(&own, folder, &answer)?,
            },
            seconds,
        })
    }

    /// What an algorithm found; `None` where it was not asked.
    #[must_use]
    pub fn cross_check(&self, cross_check: CrossCheck) -> Option<&CrossCheckResult> {
        self.cross_checks
            .iter()
            .find(|result| result.cross_check == cross_check)
    }

    /// The largest difference to another algorithm that found a solution; 0 for none.
    #[must_use]
    pub fn disagreement(&self) -> f64 {
        let solutions = self
            .cross_checks
            .iter()
            .filter(|cross_check| cross_check.is_solution());
        solutions
            .map(|cross_check| cross_check.disagreement)
            .fold(0.0, f64::max)
    }

    /// The largest difference between descriptions of the problem; `None` where not asked for.
    #[must_use]
    pub fn variation(&self) -> Option<f64> {
        let differences = self.invariances.iter().map(|result| result.difference);
        differences.reduce(f64::max)
    }

    /// Whether the case holds what it should, and what is to be said about it.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        Verdict::of(self)
    }
}

//! Load histories in memory.

use super::{AssembledProblem, Problem, ProblemError};
use crate::{
    history::{HistoryError, LoadHistory, SolvedHistory, StepRecord},
    post::ContactReport,
    scene::SolveSettings,
    solver::{Solution, Start},
};

/// A history as far as it was solved: to its end, or to the increment whose solve failed.
#[derive(Debug)]
pub struct SteppedProblem {
    /// One record for each increment that was solved.
    pub records: Vec<StepRecord>,
    /// The problem of the last one.
    pub last: AssembledProblem,
    /// Its solution.
    pub solution: Solution,
    /// What follows from it.
    pub report: ContactReport,
}

impl AssembledProblem {
    /// Solves the steps of the scene one after the other, on one factor.
    ///
    /// ```
    /// use contact3d::{Problem, scene::*};
    ///
    /// let scene = Scene::new(Body::brick([1.0; 3], [2, 2, 2]), Material::isotropic(2e11, 0.3))
    ///     .with_clamp(Clamp::face("z_max"))
    ///     .with_pressure(Pressure::on("x_min", 1e7).named("push"))
    ///     .with_body_force([0.0, 0.0, -1e8])
    ///     .with_contact(Contact::on("z_min"))
    ///     .with_friction(Friction::coulomb(0.3))
    ///     .with_step(Step::new("weight").with_factor("push", 0.0))
    ///     .with_step(Step::new("push").with_factor("push", 1.0).in_increments(4))
    ///     .with_step(Step::new("let go").with_factor("push", 0.0));
    /// let history = Problem::new(scene)?.assemble()?.solve_history(&SolveSettings::default())?;
    /// let dissipated: f64 = history.records.iter().map(|record| record.energies.dissipation).sum();
    /// assert_eq!(history.records.len(), 6);
    /// assert!(dissipated > 0.0);
    /// # Ok::<(), contact3d::ProblemError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::solve`], and [`ProblemError::Invalid`] for a scene without steps.
    pub fn solve_history(&self, settings: &SolveSettings) -> Result<SteppedProblem, ProblemError> {
        settings.validate("solve")?;
        let history = LoadHistory {
            scene: self.scene(),
            mesh: self.mesh(),
            operator: &self.system,
        };
        let go_on = |history: &LoadHistory<'_>, records| {
            let start = Start::default();
            history.solve(settings, records, start, &mut |_, _| {}, &mut |_| {})
        };
        let mut solved = go_on(&history, Vec::new())?;
        if let Some(double) = history.reconsidered(&solved, settings, &|_| Ok(()), &|_, _| ()) {
            let history = LoadHistory {
                operator: &double,
                ..history
            };
            solved = go_on(&history, solved.records_before())?;
        }
        let SolvedHistory {
            records,
            problem,
            solution,
            report,
        } = solved;
        Ok(SteppedProblem {
            last: AssembledProblem {
                problem: Problem {
                    scene: problem.scene,
                    mesh: self.problem.mesh.clone(),
                    interface: problem.interface,
                },
                system: problem.system,
            },
            records,
            solution,
            report,
        })
    }
}

impl From<HistoryError> for ProblemError {
    fn from(error: HistoryError) -> Self {
        match error {
            HistoryError::Invalid(invalid) => Self::Invalid(invalid),
            HistoryError::NeedsExplicit(error) => Self::NeedsExplicit(error),
        }
    }
}

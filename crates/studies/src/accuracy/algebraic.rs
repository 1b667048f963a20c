//! Errors and costs of the solvers on the mesh of the scene, for tolerances from loose to strict.

use std::{path::Path, sync::Arc, time::Instant};

use super::{AccuracySettings, Cost, cost::measure};
use crate::StudyStep;
use contact3d::{
    AssembledProblem, Problem, ProblemError,
    linalg::{difference, dot, norm},
    mesh::Mesh,
    scene::{DualOperatorKind, InnerSolver, Method, PrecisionControl, Scene, SolveSettings},
    solver::{Solution, Start, Status},
};

/// The entries ε, loose to strict.
pub const EPSILONS: [f64; 11] = [
    1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12,
];

/// A solve is repeated, for the median of its seconds, when one takes no more than this share of
/// the budget.
pub(super) const CHEAP_SHARE: f64 = 1.0 / 60.0;

units::worded! {
    /// A method of the study. The inner solver of successive approximations is the scene's.
    pub enum RunMethod {
        /// Successive approximations with inner precision (a).
        FixedPrecision = "fixed point (a)",
        /// Successive approximations with inner precision (b).
        AdaptivePrecision = "fixed point (b)",
        /// Semismooth Newton.
        Newton = "Newton",
    }
}

units::worded! {
    /// How the dual operator is held.
    pub enum RunOperator {
        /// Two sparse triangular solves for each application.
        Implicit = "implicit",
        /// A dense matrix.
        Explicit = "explicit",
    }
}

/// One accuracy ε asked of one method on one operator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolverRun {
    /// The method.
    pub method: RunMethod,
    /// How S is held.
    pub operator: RunOperator,
    /// The accuracy asked for.
    pub epsilon: f64,
    /// What came of it; `None` where it was not run because the budget does not suffice.
    pub result: Option<RunResult>,
}

/// What a solve reached, and at what cost.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RunResult {
    /// How it ended.
    pub status: Status,
    /// ‖u − u*‖_A / ‖u*‖_A.
    pub energy_error: f64,
    /// ‖λ − λ*‖ / ‖λ*‖.
    pub multiplier_error: f64,
    /// n_A.
    pub applications: usize,
    /// Seconds and memory of the solve alone; the assembly is reported apart.
    pub cost: Cost,
}

/// All entries on the scene's own mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AlgebraicStudy {
    /// How the reference (u*, λ*) ended: Newton's method on the explicit operator to rounding.
    pub reference_status: Status,
    /// ‖R‖ / ‖λ‖ of the reference.
    pub reference_accuracy: f64,
    /// Assembly with the implicit and the explicit operator.
    pub assembly: [Cost; 2],
    /// Series after series, each from loose to strict; empty when the reference failed.
    pub entries: Vec<SolverRun>,
}

/// The assembled problem with its reference solution.
struct StudiedProblem<'a> {
    scene: &'a Scene,
    assembled: AssembledProblem,
    reference: Solution,
    /// Seconds of a method on an operator.
    budget: f64,
}

/// The methods on a dense S.
const EXPLICIT: [RunMethod; 3] = [
    RunMethod::FixedPrecision,
    RunMethod::AdaptivePrecision,
    RunMethod::Newton,
];

/// Those on an implicit one.
fn on_implicit(scene: &Scene) -> &'static [RunMethod] {
    if scene.solve.inner == InnerSolver::Newton {
        &[]
    } else {
        &[RunMethod::FixedPrecision, RunMethod::AdaptivePrecision]
    }
}

impl AlgebraicStudy {
    /// Solves the scene on its own mesh to every ε by every method; `None` without contact, where
    /// one solve with the factor gives the answer.
    ///
    /// # Errors
    /// [`ProblemError`].
    pub(super) fn of(
        scene: &Scene,
        folder: &Path,
        settings: &AccuracySettings,
        observe: &mut dyn FnMut(StudyStep),
    ) -> Result<Option<Self>, ProblemError> {
        let mesh = Arc::new(Mesh::of_scene(scene, folder)?);
        if mesh.contact.is_none() {
            return Ok(None);
        }
        observe(StudyStep::Begin("assembly and reference".to_owned()));
        let budget = settings.budget.unwrap_or(10.0);
        let assemble = |kind| {
            let mut scene = scene.clone();
            scene.assemble.dual_operator = kind;
            measure(budget * CHEAP_SHARE, || {
                Problem::of_checked(scene.clone(), Arc::clone(&mesh))?.assemble()
            })
        };
        let (_, implicit) = assemble(DualOperatorKind::Implicit)?;
        let (assembled, explicit) = assemble(DualOperatorKind::Explicit)?;
        let to_rounding = SolveSettings {
            method: Method::Newton,
            epsilon: Some(0.0),
            ..scene.solve.clone()
        };
        let mut reference = assembled.solve_from(&to_rounding, Start::default(), &mut |_| {})?;
        assembled.report(&reference)?.classify(&mut reference);
        let mut study = Self {
            reference_status: reference.status,
            reference_accuracy: reference.accuracy,
            assembly: [implicit, explicit],
            entries: Vec::new(),
        };
        if !reference.status.is_solved() {
            return Ok(Some(study));
        }
        observe(StudyStep::Figure(format!(
            "assembled in {:.2} s, reference solved to {:.1e}",
            explicit.seconds, reference.accuracy
        )));
        let mut problem = StudiedProblem {
            scene,
            assembled,
            reference,
            budget: 0.0,
        };
        let dense = EXPLICIT.map(|method| (method, RunOperator::Explicit));
        let implicit = on_implicit(scene).iter();
        let implicit = implicit.map(|method| (*method, RunOperator::Implicit));
        let series: Vec<_> = dense.into_iter().chain(implicit).collect();
        let began = Instant::now();
        for (done, &(method, operator)) in series.iter().enumerate() {
            if operator == RunOperator::Implicit
                && let Some(contact) = &mut problem.assembled.system.contact
            {
                contact.make_implicit();
            }
            // What one series leaves goes to those after it.
            let left = (budget - began.elapsed().as_secs_f64()).max(0.0);
            problem.budget = left / (series.len() - done) as f64;
            let entries = problem.series(method, operator, observe)?;
            study.entries.extend(entries);
        }
        Ok(Some(study))
    }

    /// The entries of each method and operator that ran, loose to strict.
    #[must_use]
    pub fn series(&self) -> Vec<&[SolverRun]> {
        self.entries
            .chunk_by(|a, b| (a.method, a.operator) == (b.method, b.operator))
            .collect()
    }
}

impl StudiedProblem<'_> {
    /// One method on one operator, until the budget is spent.
    fn series(
        &self,
        method: RunMethod,
        operator: RunOperator,
        observe: &mut dyn FnMut(StudyStep),
    ) -> Result<Vec<SolverRun>, ProblemError> {
        let mut entries: Vec<SolverRun> = Vec::new();
        let mut spent = 0.0;
        for epsilon in EPSILONS {
            let result = match self.affordable(&entries, spent) {
                None => None,
                Some(applications) => {
                    let words = [method.word(), operator.word()].join(", ");
                    observe(StudyStep::Begin(format!("{words}, epsilon {epsilon:.0e}")));
                    Some(self.run(method, epsilon, applications)?)
                }
            };
            spent += result.map_or(0.0, |r| r.cost.seconds * r.cost.repeats as f64);
            entries.push(SolverRun {
                method,
                operator,
                epsilon,
                result,
            });
        }
        Ok(entries)
    }

    /// Applications of S that fit in what is left of the budget, by the price of the last entry's; `None` where the next entry would take
    /// more when costs grow as they last did.
    fn affordable(&self, entries: &[SolverRun], spent: f64) -> Option<usize> {
        let most = self.scene.solve.max_operator_applications;
        let mut results = entries.iter().rev().map(|entry| entry.result);
        let Some(last) = results.next() else {
            return Some(most);
        };
        let last = last?;
        let growth = match results.next().flatten() {
            Some(before) if before.cost.seconds > 0.0 => last.cost.seconds / before.cost.seconds,
            _ => 1.0,
        };
        if spent + last.cost.seconds * growth.max(1.0) > self.budget {
            return None;
        }
        let price = last.cost.seconds / last.applications.max(1) as f64;
        let affordable = ((self.budget - spent) / price).floor();
        // Saturates, which is what is meant.
        Some(most.min(affordable.max(1.0) as usize))
    }

    fn run(
        &self,
        method: RunMethod,
        epsilon: f64,
        max_operator_applications: usize,
    ) -> Result<RunResult, ProblemError> {
        let (method, precision) = match method {
            RunMethod::FixedPrecision => (Method::FixedPoint, PrecisionControl::Fixed),
            RunMethod::AdaptivePrecision => (Method::FixedPoint, PrecisionControl::Adaptive),
            RunMethod::Newton => (Method::Newton, PrecisionControl::default()),
        };
        let settings = SolveSettings {
            method,
            precision,
            epsilon: Some(epsilon),
            max_operator_applications,
            ..self.scene.solve.clone()
        };
        let (solution, cost) = measure(self.budget * CHEAP_SHARE, || {
            self.assembled
                .solve_from(&settings, Start::default(), &mut |_| {})
        })?;
        let stiffness = &self.assembled.system.assembly.primal.stiffness;
        let energy = |u: &[f64]| {
            let mut forces = vec![0.0; u.len()];
            stiffness.mul(u, &mut forces);
            dot(u, &forces).max(0.0).sqrt()
        };
        let (u, exact_u) = (&solution.displacement, &self.reference.displacement);
        let (multiplier, exact) = (&solution.multiplier, &self.reference.multiplier);
        Ok(RunResult {
            status: solution.status,
            energy_error: relative(&energy, u, exact_u),
            multiplier_error: relative(&norm, multiplier, exact),
            applications: solution.trace.applications,
            cost,
        })
    }
}

/// ‖v − w‖ / ‖w‖, and 0 for 0/0.
fn relative(norm: &dyn Fn(&[f64]) -> f64, v: &[f64], w: &[f64]) -> f64 {
    match (norm(&difference(v, w)), norm(w)) {
        (0.0, _) => 0.0,
        (difference, size) => difference / size,
    }
}

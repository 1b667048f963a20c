//! What a solve came to: handed over by the driver, or read back.

use std::path::Path;

use contact3d::{
    AssembledProblem, Problem, SolvedProblem,
    contact::{Coupling, Interface},
    dual::PrimalSystem,
    elasticity::DofMap,
    history::{StepRecord, largest_norm},
    linalg::EngineError,
    mesh::{ContactSurface, Mesh},
    post::ContactReport,
    scene::{InvalidValue, SceneFile, Warning},
    solver::{Solution, Status},
};
use runfile::{GroupWriter, Reader, StoreError};
use studies::bound::ErrorBound;

use super::{OpenRun, StageError, mesh, stages};
use crate::format::{self, FormatError, GridSeries, ResultState, Stage};

/// What a solve came to.
#[derive(Debug)]
pub struct Results {
    /// The scene on its mesh; of a load history the last increment that was solved.
    problem: Problem,
    dofs: DofMap,
    /// Multipliers and displacement.
    pub solution: Solution,
    /// What follows from them.
    pub report: ContactReport,
    /// The increments of a load history, the last of which the other results are of; none without one.
    pub increments: Vec<StepRecord>,
    /// Increments before the last that are loaded more, by their places.
    loaded: Vec<(usize, Problem, ContactReport)>,
}

impl Results {
    /// The largest depth in m to which a foundation cuts into the body before it is pressed apart; zero without interference.
    #[must_use]
    pub fn interference(&self) -> f64 {
        let side = self.problem.contact_side().into_iter();
        let depths = side.flat_map(|it| it.interface.depths(self.problem.scene(), it.surface));
        depths.fold(0.0, |deepest, (_, depth)| deepest.max(depth))
    }

    /// What follows from the increment with the largest load of a kind, and its place; of a scene without a history 0.
    #[must_use]
    pub fn loaded_most(&self, load: fn(&StepRecord) -> f64) -> (&Problem, &ContactReport, usize) {
        let most = StepRecord::loaded_most(&self.increments, load);
        let mut earlier = self.loaded.iter();
        let earlier = earlier.find(|(place, ..)| *place == most);
        let own = (&self.problem, &self.report, most);
        earlier.map_or(own, |(_, problem, report)| (problem, report, most))
    }

    /// The largest depth in m to which bodies overlap that are taken to touch; zero where none do.
    #[must_use]
    pub fn dropped_overlap(&self) -> f64 {
        let scene = self.problem.scene();
        let side = self.problem.contact_side().into_iter();
        let faces = side.flat_map(|it| {
            let faces = scene.contact_order().into_iter().zip(&it.surface.faces);
            let faces = faces.filter(|(entry, _)| !scene.contacts[*entry].interference);
            faces.filter_map(|(_, face)| it.surface.clearance.get(face.nodes.clone()))
        });
        faces.flatten().fold(0.0, |deepest, at| deepest.max(-at))
    }

    /// The share of the normal force on panes beside open ones where it is the largest and contact no wider, and the place of its increment.
    #[must_use]
    pub fn narrow_share(&self) -> Option<(f64, usize)> {
        let [.., force] = StepRecord::LOADS;
        let (problem, report, place) = self.loaded_most(force);
        let solved = self.solution.status.is_solved();
        let side = problem.contact_side().filter(|_| solved)?;
        Some((report.narrow_share(problem.mesh(), side)?, place))
    }

    /// What is allowed in the scene, of a load history that of the increment with the largest strain energy, and probably not meant.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        // The scene of an increment has no steps.
        let is_history = !self.increments.is_empty();
        let holds =
            |warning: &Warning| !is_history || !matches!(warning, Warning::NothingToFollow { .. });
        let (problem, ..) = self.loaded_most(StepRecord::LOADS[0]);
        let warnings = problem.warnings().into_iter().filter(holds);
        warnings.map(|warning| warning.to_string()).collect()
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        self.problem.mesh()
    }

    /// The laws of the contact face; `None` without contact.
    pub fn interface(&self) -> Option<&Interface> {
        self.problem.interface()
    }

    /// Reads the results of a scene on its mesh and evaluates them anew; A, l and B are read without the factor.
    pub(super) fn read(
        reader: &Reader,
        input: &SceneFile,
        problem: &Problem,
    ) -> Result<Self, StageError> {
        let mut solve = StoredSolve::read(reader, input, problem)?;
        let is_solved = solve.solution.status != Status::NumericalError;
        let known = format::read_functionals(reader, &input.scene, is_solved)?;
        let (primal, coupling) = (&solve.primal, solve.coupling.as_ref());
        let judged = solve
            .problem
            .assess(primal, coupling, &mut solve.solution, known);
        let report = judged.map_err(|invalid| input.refuse(invalid))?;
        let known = (primal, coupling);
        let loaded = problem.loaded_most(&solve.increments, known, &solve.solution);
        Ok(Self {
            loaded: loaded.map_err(|invalid| input.refuse(invalid))?,
            problem: solve.problem,
            dofs: solve.primal.dofs,
            solution: solve.solution,
            report,
            increments: solve.increments,
        })
    }

    /// Those of a solve of a problem, whose increments that are loaded most are evaluated.
    pub(super) fn of(problem: &Problem, answer: SolvedProblem) -> Result<Self, InvalidValue> {
        let AssembledProblem {
            problem: last,
            system,
        } = answer.problem;
        let primal = system.assembly.primal;
        let coupling = system.contact.as_ref().map(|contact| &contact.coupling);
        Ok(Self {
            loaded: problem.loaded_most(&answer.records, (&primal, coupling), &answer.solution)?,
            problem: last,
            dofs: primal.dofs,
            solution: answer.solution,
            report: answer.report,
            increments: answer.records,
        })
    }

    /// Writes the solution; that of a load history belongs to increments with some digest.
    pub(super) fn write_solution(
        &self,
        writer: &mut GroupWriter<'_>,
        history_digest: Option<&str>,
    ) -> Result<(), StoreError> {
        let surface = self.mesh().contact.as_ref();
        let n_panes = surface.map_or(0, ContactSurface::n_panes);
        let functionals = &self.report.functionals;
        format::write_solution(writer, &self.solution, n_panes, &self.dofs, history_digest)?;
        format::write_functionals(writer, functionals, self.problem.scene().units)
    }

    /// Writes the report as ParaView reads it; of a load history all increments, as a series that it plays.
    pub(super) fn write_vtkhdf(&self, writer: &mut GroupWriter<'_>) -> Result<(), StoreError> {
        let frame = self.interface().map(|interface| &interface.frame);
        let mesh = self.mesh();
        if self.increments.is_empty() {
            let rigid = self.solution.rigid.as_ref();
            let mechanism = rigid.and_then(|rigid| rigid.mechanism.as_deref());
            let mechanism = mechanism.map(|rows| &rows[..mesh.coordinates.len()]);
            return format::write_vtkhdf(writer, mesh, &self.report, frame, mechanism);
        }
        let times = self.increments.iter().map(|record| record.increment.time);
        let times: Vec<f64> = times.collect();
        let mut series = GridSeries::begin(writer, mesh, &times)?;
        let norm = largest_norm(&self.increments);
        for record in &self.increments {
            series.step(mesh, &ResultState::of_increment(record, norm), frame);
        }
        series.finish()
    }

    /// Writes the report beside that for ParaView, whose digest it holds.
    pub(super) fn write_report(
        &self,
        writer: &mut GroupWriter<'_>,
        vtkhdf_digest: &str,
    ) -> Result<(), StoreError> {
        let face = self.problem.contact_side();
        let face = face.map(|face| (face.surface, &face.interface.frame));
        format::write_report(writer, self.mesh(), &self.report, face, vtkhdf_digest)
    }
}

/// What the stages up to `solve` leave in a run file, without the factor.
struct StoredSolve {
    /// The scene on its mesh; of a load history the last increment that was solved.
    problem: Problem,
    primal: PrimalSystem,
    coupling: Option<Coupling>,
    solution: Solution,
    increments: Vec<StepRecord>,
}

impl StoredSolve {
    fn read(reader: &Reader, input: &SceneFile, problem: &Problem) -> Result<Self, StageError> {
        let mut primal = format::read_primal(reader)?;
        primal.dofs.glue(problem.scene(), problem.mesh());
        let coupling = format::read_coupling(reader)?;
        let solution = format::read_solution(reader, &primal.dofs)?;
        let has_history = input.scene.has_history();
        let increments = if has_history {
            format::read_history(reader, &input.scene)?
        } else {
            Vec::new()
        };
        let after = || problem.system_after(&increments, &primal);
        let (problem, primal, followed) = match has_history {
            true => after().map_err(|invalid| input.refuse(invalid))?,
            false => (problem.clone(), primal, None),
        };
        Ok(Self {
            // The stored one is that of the scene before it moves.
            coupling: followed.or(coupling),
            problem,
            primal,
            solution,
            increments,
        })
    }
}

/// The results that a finished run file holds; takes no lock.
pub fn read_results(reader: &Reader, input: &SceneFile) -> Result<Results, StageError> {
    let problem = mesh::read(reader, input)?;
    Results::read(reader, input, &problem)
}

/// A bound of the error of the answer in a finished run file, with its scene; takes no lock.
///
/// # Errors
/// A stage that is missing, stale or damaged, unreadable datasets; an answer that is none; a scene whose error cannot be bounded.
///
/// The last is the stored estimate over ‖u_h‖_A; `None` where the solution is not evaluated, and for a body at rest.
pub(super) fn read_bound(path: &Path) -> Result<(SceneFile, ErrorBound, Option<f64>), StageError> {
    let run = OpenRun::open(path)?;
    run.require_fresh(Stage::Solve, "solved")?;
    let is_evaluated = run.is_fresh(Stage::Post);
    let OpenRun { reader, input, .. } = run;
    let estimate = is_evaluated.then(|| format::read_estimate(&reader));
    let problem = mesh::read(&reader, &input)?;
    let solve = StoredSolve::read(&reader, &input, &problem)?;
    if !solve.solution.has_computed_solution() {
        return Err(StageError::Unfit {
            file: path.to_owned(),
            reason: "the solve has no answer whose error could be bounded; `status` says why"
                .into(),
        });
    }
    let coupling = solve.coupling.as_ref();
    let solved = solve
        .problem
        .solved(&solve.primal, coupling, &solve.solution);
    let bound = ErrorBound::new(&solved).map_err(|invalid| input.refuse(invalid))?;
    Ok((input, bound, estimate.transpose()?.flatten()))
}

/// The assembled problem of a run file whose stages up to `solve` are fresh, and its solution.
///
/// # Errors
/// A stage that is missing, stale or damaged, unreadable datasets.
pub fn read_solved(path: &Path) -> Result<(AssembledProblem, Solution), StageError> {
    let run = OpenRun::open(path)?;
    run.require_fresh(Stage::Solve, "solved")?;
    let OpenRun { reader, input, .. } = run;
    let problem = mesh::read(&reader, &input)?;
    let mut system = match format::read_assembly(&reader, None) {
        Err(FormatError::Engine(EngineError::NotAtHand)) => {
            let assembled = problem.clone().assemble();
            let assembled = assembled.map_err(|error| stages::refused(&input, error))?;
            assembled.system
        }
        read => read?,
    };
    format::read_loads(&reader, &mut system)?;
    let solution = format::read_solution(&reader, &system.assembly.primal.dofs)?;
    Ok((AssembledProblem { problem, system }, solution))
}

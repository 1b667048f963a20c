//! The one loop of adaptive levels, whoever solves and keeps them.

use std::{path::Path, sync::Arc, time::Instant};

use super::{
    Adaptation, AdaptiveLevel, AdaptiveStatus, LevelForecast, Target, marking::graded_cells,
    next_cuts,
};
use crate::{
    InMemory, Problem, ProblemError, SolvedProblem,
    contact::transferred,
    history::{HistoryErrors, StepRecord},
    mesh::{Mesh, RefinableBody, RefinedLevel},
    post::{ContactReport, Zone},
    scene::{Functional, InvalidValue, Scene},
    solver::{Solution, Start},
};

/// A level that is solved.
#[derive(Debug, Clone, Copy)]
pub struct SolvedLevel<'a> {
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// Whether S is dense, without which quantities have no errors.
    pub has_dense_operator: bool,
    /// What the solver found.
    pub solution: &'a Solution,
    /// What follows from it.
    pub report: &'a ContactReport,
    /// The increments of a load history, the last of which solution and report are of; none without one.
    pub increments: &'a [StepRecord],
    /// Seconds of mesh, assembly, solve and evaluation.
    pub seconds: f64,
}

/// Solves the levels of an adaptive computation and keeps what they leave.
pub trait LevelStorage {
    /// Why a level cannot be solved.
    type Error: From<ProblemError>;

    /// A level of those whose cuts and starts are known, solved unless it is at hand.
    ///
    /// # Errors
    /// What meshing, assembling and solving refuse.
    fn solved(&mut self, level: usize, known: &Adaptation) -> Result<SolvedLevel<'_>, Self::Error>;

    /// Sees a level that is done.
    fn done(&mut self, _number: usize, _level: &AdaptiveLevel) {}

    /// Sees why a refined level does not fit into memory or on the disk, if that is what the error says.
    ///
    /// # Errors
    /// Any other error.
    fn too_large(&mut self, _level: usize, error: Self::Error) -> Result<(), Self::Error> {
        Err(error)
    }

    /// Sees what the next level, by its number, is expected to come to.
    fn forecast(&mut self, _level: usize, _forecast: &LevelForecast) {}

    /// Keeps what an interrupted computation could go on from, and the mesh of the level that comes next.
    fn checkpoint(&mut self, known: &Adaptation, next: Mesh);
}

/// What adaptive levels came to.
#[derive(Debug)]
pub struct RefinedLevels {
    /// All levels, those that were known before included.
    pub adaptation: Adaptation,
    /// How they ended.
    pub status: AdaptiveStatus,
    /// The level that meets the target, or the last.
    pub level: usize,
}

/// Solves a scene on finer and finer meshes until the estimated error meets its target `adapt.error`, or the next level would end after
/// the deadline, and goes on from the levels that are known; mesh files are looked for in `folder`. A target that is not met is a status.
///
/// # Errors
/// A scene without a target, those of the storage, a mesh that cannot be cut.
pub fn refine<K: LevelStorage>(
    scene: &Scene,
    folder: &Path,
    deadline: Option<Instant>,
    mut known: Adaptation,
    storage: &mut K,
) -> Result<RefinedLevels, K::Error> {
    let adapt = scene.adapt.ok_or_else(|| ProblemError::from(no_target()))?;
    let (target, of) = (adapt.error, adapt.of);
    let mut ended = None;
    if let Some(end) = deadline
        && let Some(forecast) = forecast_of_prepared(scene, folder, target, &known)?
    {
        let before = known.levels.len() - 1;
        storage.forecast(before + 1, &forecast);
        if forecast.ends_after(end) {
            ended = Some(AdaptiveStatus::OverBudget);
            known.refinement.truncate(before);
            known.starts.truncate(before);
        }
    }
    while known.level_that_meets(target).is_none() {
        let level = known.refinement.len();
        if known.levels.len() > level {
            if ended.is_some() || known.status(target, of) != AdaptiveStatus::Refining {
                break;
            }
            let solved = storage.solved(level, &known)?;
            let (refined, mesh, start, forecast) =
                next_level(scene, folder, target, &known, solved)?;
            storage.forecast(level + 1, &forecast);
            if deadline.is_some_and(|end| forecast.ends_after(end)) {
                ended = Some(AdaptiveStatus::OverBudget);
                break;
            }
            known.refinement.push(refined);
            known.starts.push(start);
            storage.checkpoint(&known, mesh);
            continue;
        }
        let solved = storage.solved(level, &known);
        let last = match solved.map(|solved| AdaptiveLevel::new(scene, solved, known.levels.last()))
        {
            Ok(Ok(done)) => {
                storage.done(level, &done);
                known.levels.push(done);
                continue;
            }
            Ok(Err(error)) if level == 0 => return Err(error.into()),
            Ok(Err(_)) => AdaptiveStatus::NotEstimated,
            Err(error) if level == 0 => return Err(error),
            Err(error) => {
                storage.too_large(level, error)?;
                AdaptiveStatus::TooLarge
            }
        };
        ended = Some(last);
        known.refinement.truncate(level - 1);
        known.starts.truncate(level - 1);
    }
    Ok(RefinedLevels {
        status: ended.unwrap_or_else(|| known.status(target, of)),
        level: known
            .level_that_meets(target)
            .unwrap_or(known.levels.len() - 1),
        adaptation: known,
    })
}

/// How the next mesh comes from that of a level, the mesh, what the next solve starts from, which is nothing where the body is meshed anew,
/// and what it is expected to come to.
fn next_level(
    scene: &Scene,
    folder: &Path,
    target: f64,
    known: &Adaptation,
    solved: SolvedLevel<'_>,
) -> Result<(RefinedLevel, Mesh, Vec<f64>, LevelForecast), ProblemError> {
    let estimated = known.levels.last().map_or(0.0, |last| last.estimated_error);
    let cells = graded_cells(scene, &known.refinement, estimated.min(1.0), target);
    let next = match (cells, solved.errors(scene)) {
        (Some(cells), _) => RefinedLevel::Cells(cells),
        (None, Some(errors)) => {
            let (indicator, aim) = Target::of_history(scene, &errors, target);
            RefinedLevel::Cuts(next_cuts(&indicator, aim))
        }
        // The edges of all tetrahedra are halved.
        (None, None) if !solved.solution.status.is_solved() => {
            RefinedLevel::Cuts(vec![3; solved.mesh.tetrahedra.len()])
        }
        (None, None) => {
            let (indicator, mut aim) = Target::of(scene, solved.report, target);
            let is_cut = matches!(known.refinement.last(), Some(RefinedLevel::Cuts(_)));
            // Errors of quantities have signs and tell less.
            if is_cut && scene.adapt.is_none_or(|adapt| adapt.of.is_none()) {
                aim = aim.after(&known.levels, target);
            }
            RefinedLevel::Cuts(next_cuts(&indicator, aim))
        }
    };
    let mut refinement = known.refinement.clone();
    refinement.push(next.clone());
    let body = RefinableBody::refined(scene, folder, &refinement)?;
    let mesh = body.mesh()?;
    let growth = mesh.coordinates.len() as f64 / solved.mesh.coordinates.len() as f64;
    // A history begins with its first increment.
    let first = solved.increments.first().map(|record| &record.multiplier);
    let multiplier = first.unwrap_or(&solved.solution.multiplier);
    let start = match next {
        RefinedLevel::Cells(_) => Vec::new(),
        RefinedLevel::Cuts(_) => transferred(solved.mesh, &mesh, &body.parents(), multiplier),
    };
    let forecast = LevelForecast {
        cells,
        ..LevelForecast::new(&known.levels, growth, target)
    };
    Ok((next, mesh, start, forecast))
}

/// What the level that an interrupted computation has left to be solved is expected to come to; `None` without such a level.
fn forecast_of_prepared(
    scene: &Scene,
    folder: &Path,
    target: f64,
    known: &Adaptation,
) -> Result<Option<LevelForecast>, ProblemError> {
    let before = known.levels.len().checked_sub(1);
    let next = before.and_then(|before| known.refinement.get(before));
    let Some(next) = next.filter(|_| known.level_that_meets(target).is_none()) else {
        return Ok(None);
    };
    let mut refinement = known.refinement.clone();
    let n_nodes = Mesh::refined(scene, folder, &refinement)?.coordinates.len();
    refinement.pop();
    let n_before = Mesh::refined(scene, folder, &refinement)?.coordinates.len();
    let growth = n_nodes as f64 / n_before as f64;
    Ok(Some(LevelForecast {
        cells: match next {
            RefinedLevel::Cells(cells) => Some(*cells),
            RefinedLevel::Cuts(_) => None,
        },
        ..LevelForecast::new(&known.levels, growth, target)
    }))
}

/// Solves a scene on finer and finer meshes until the estimated error meets the scene's
/// `adapt.error`; mesh files are looked for in `folder`. Returns what the level came to that meets it, or the last one, and all levels.
///
/// Nothing is asked about memory: what does not fit aborts, as any allocation does.
///
/// # Errors
/// [`ProblemError`] for a scene without a target or without a discrete problem.
pub fn adapted(
    scene: Scene,
    folder: &Path,
) -> Result<(SolvedProblem, RefinedLevels), ProblemError> {
    let scene = scene.checked()?.with_first_mesh();
    let mut levels = LevelInMemory {
        scene: &scene,
        folder,
        prepared: None,
        at_hand: None,
    };
    let refined = refine(&scene, folder, None, Adaptation::default(), &mut levels)?;
    levels.solved(refined.level, &refined.adaptation)?;
    let (_, answer, _) = levels.at_hand.expect("the level was just solved");
    Ok((answer, refined))
}

fn no_target() -> InvalidValue {
    InvalidValue {
        key: "adapt".into(),
        expected: "a target for the error".into(),
        found: "none".into(),
        help: "write [adapt] with error = 0.01, for example".into(),
    }
}

/// Keeps the last level only.
struct LevelInMemory<'a> {
    scene: &'a Scene,
    folder: &'a Path,
    /// The mesh of the next level.
    prepared: Option<Mesh>,
    /// Its number, what it came to, and the seconds it took.
    at_hand: Option<(usize, SolvedProblem, f64)>,
}

impl LevelInMemory<'_> {
    fn solve(&mut self, level: usize, known: &Adaptation) -> Result<SolvedProblem, ProblemError> {
        let is_last = level == known.refinement.len();
        let mesh = match self.prepared.take().filter(|_| is_last) {
            Some(mesh) => mesh,
            None => {
                let mut refinement = known.refinement.clone();
                refinement.truncate(level);
                Mesh::refined(self.scene, self.folder, &refinement)?
            }
        };
        let problem = Problem::of_checked(self.scene.clone(), Arc::new(mesh))?;
        let before = level.checked_sub(1).map(|before| &*known.starts[before]);
        let start = Start {
            multiplier: before.filter(|start| !start.is_empty()),
            checkpoint: None,
        };
        let settings = &self.scene.solve;
        problem
            .assemble()?
            .run(settings, start, Vec::new(), &mut InMemory)
    }
}

impl LevelStorage for LevelInMemory<'_> {
    type Error = ProblemError;

    fn solved(
        &mut self,
        level: usize,
        known: &Adaptation,
    ) -> Result<SolvedLevel<'_>, ProblemError> {
        let at_hand = match self.at_hand.take() {
            Some(at_hand) if at_hand.0 == level => at_hand,
            _ => {
                let began = Instant::now();
                let answer = self.solve(level, known)?;
                (level, answer, began.elapsed().as_secs_f64())
            }
        };
        let (_, answer, seconds) = self.at_hand.insert(at_hand);
        let contact = answer.problem.system.contact.as_ref();
        Ok(SolvedLevel {
            mesh: answer.problem.mesh(),
            has_dense_operator: contact.is_some_and(|contact| contact.explicit().is_some()),
            solution: &answer.solution,
            report: &answer.report,
            increments: &answer.records,
            seconds: *seconds,
        })
    }

    fn checkpoint(&mut self, _: &Adaptation, next: Mesh) {
        self.prepared = Some(next);
    }
}

impl SolvedLevel<'_> {
    /// The errors of a load history in the measure that the scene is refined for; `None` without a history, and without estimates.
    fn errors(&self, scene: &Scene) -> Option<HistoryErrors> {
        HistoryErrors::new(self.increments, scene.adapt.and_then(|adapt| adapt.of))
    }

    /// The estimated error of the mesh; `None` where the quantity that it is refined for has none, NaN where a load history ended before
    /// its last increment.
    fn estimated_error(&self, scene: &Scene) -> Option<f64> {
        if !scene.has_history() && !self.solution.has_computed_solution() {
            // All of the solution is missed where the panes of the mesh cannot hold the body.
            let is_of_mesh = self.solution.is_mechanism_of_panes(self.mesh);
            return Some(if is_of_mesh { 1.0 } else { f64::NAN });
        }
        if !scene.has_history() {
            let of = scene.adapt.and_then(|adapt| adapt.of);
            let of = of.filter(|_| self.solution.status.is_solved());
            return self.report.relative_error(of);
        }
        if self.increments.len() < scene.increments().len() || !self.solution.status.is_solved() {
            return Some(f64::NAN);
        }
        self.errors(scene).map(|errors| errors.largest())
    }
}

impl AdaptiveLevel {
    /// What a solved mesh came to.
    fn new(
        scene: &Scene,
        level: SolvedLevel<'_>,
        before: Option<&Self>,
    ) -> Result<Self, ProblemError> {
        let of = scene.adapt.and_then(|adapt| adapt.of);
        let quantity = of.and_then(|of| level.report.functional(of));
        let value = quantity.filter(|_| !scene.has_history()).map(|it| it.value);
        let mut estimated_error = level.estimated_error(scene);
        if let Some(value) = value.filter(|_| of.is_some_and(Functional::is_largest)) {
            // It is known where it has settled from one mesh to the next.
            let change = |before: f64| (value - before).abs() / value;
            let change = before.and_then(|before| before.value).map_or(1.0, change);
            estimated_error = estimated_error.map(|error| error.max(change));
        }
        Ok(Self {
            value,
            n_tetrahedra: level.mesh.tetrahedra.len(),
            n_free: level.solution.displacement.len(),
            n_multipliers: level.solution.multiplier.len(),
            n_closed: level.report.panes.len() - level.report.count(Zone::Open),
            estimated_error: estimated_error
                .ok_or_else(|| nothing_to_refine_for(of, level.has_dense_operator))?,
            status: level.solution.status,
            seconds: level.seconds,
        })
    }
}

/// Refuses to refine for a quantity that a solution does not have.
fn nothing_to_refine_for(of: Option<Functional>, has_dense_operator: bool) -> InvalidValue {
    let name = of.map_or("", Functional::word);
    let rest = if has_dense_operator {
        ""
    } else {
        ", or set assemble.dual_operator = \"explicit\""
    };
    InvalidValue {
        key: "adapt.of".into(),
        expected: "a quantity that the answer has, other than zero".into(),
        found: format!("{name}, which is zero or has no estimate"),
        help: format!("leave it out to refine for the energy norm, refine the first mesh{rest}"),
    }
}

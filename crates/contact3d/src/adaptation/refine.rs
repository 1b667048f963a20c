//! The one loop of adaptive levels, whoever solves and keeps them.

use std::{path::Path, sync::Arc, time::Instant};

use super::{Adaptation, AdaptiveLevel, AdaptiveStatus, Target, next_cuts, transferred};
use crate::{
    Answer, AssembledProblem, InMemory, Problem, ProblemError,
    dual::{ExplicitDual, smallest_eigenvalue},
    mesh::{Mesh, RefinableBody},
    post::ContactReport,
    scene::{Invalid, Scene},
    solver::{Solution, Start},
};

/// A level that is solved.
#[derive(Debug, Clone, Copy)]
pub struct SolvedLevel<'a> {
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// S where it is held.
    pub dual: Option<&'a ExplicitDual>,
    /// What the solver found.
    pub solution: &'a Solution,
    /// What follows from it.
    pub report: &'a ContactReport,
    /// Seconds of mesh, assembly, solve and evaluation.
    pub seconds: f64,
}

/// Solves the levels of an adaptive computation and keeps what they leave.
pub trait LevelKeeper {
    /// Why a level cannot be solved.
    type Error: From<ProblemError>;

    /// A level of those whose cuts and starts are known, solved unless it is at hand.
    ///
    /// # Errors
    /// What meshing, assembling and solving refuse.
    fn solved(&mut self, level: usize, known: &Adaptation) -> Result<SolvedLevel<'_>, Self::Error>;

    /// Sees a level that is done.
    fn done(&mut self, number: usize, level: &AdaptiveLevel);

    /// Sees why a refined level does not fit into memory or on the disk, if that is what the error says.
    ///
    /// # Errors
    /// Any other error.
    fn too_large(&mut self, level: usize, error: Self::Error) -> Result<(), Self::Error>;

    /// Keeps what an interrupted computation could go on from.
    fn keep(&mut self, known: &Adaptation);
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

/// Solves a scene on finer and finer meshes until the estimated error meets a target, and goes on from the levels that are known; mesh
/// files are looked for in `folder`. A target that is not met is a status.
///
/// # Errors
/// Those of the keeper, a mesh that cannot be cut.
pub fn refine<K: LevelKeeper>(
    scene: &Scene,
    folder: &Path,
    target: f64,
    mut known: Adaptation,
    keeper: &mut K,
) -> Result<RefinedLevels, K::Error> {
    let mut too_large = false;
    while known.level_that_meets(target).is_none() {
        let level = known.refinement.levels().len();
        if known.levels.len() > level {
            if too_large || known.status(target) != AdaptiveStatus::Refining {
                break;
            }
            let solved = keeper.solved(level, &known)?;
            let (cuts, start) = next_level(scene, folder, target, &known, solved)?;
            known.refinement.push(cuts);
            known.starts.push(start);
            keeper.keep(&known);
            continue;
        }
        match keeper.solved(level, &known).map(AdaptiveLevel::new) {
            Ok(done) => {
                keeper.done(level, &done);
                known.levels.push(done);
            }
            Err(error) if level > 0 => {
                keeper.too_large(level, error)?;
                too_large = true;
                known.refinement.truncate(level - 1);
                known.starts.truncate(level - 1);
            }
            Err(error) => return Err(error),
        }
    }
    Ok(RefinedLevels {
        status: if too_large {
            AdaptiveStatus::TooLarge
        } else {
            known.status(target)
        },
        level: known
            .level_that_meets(target)
            .unwrap_or(known.levels.len() - 1),
        adaptation: known,
    })
}

/// What to cut of a level, and what the next one starts from.
fn next_level(
    scene: &Scene,
    folder: &Path,
    target: f64,
    known: &Adaptation,
    solved: SolvedLevel<'_>,
) -> Result<(Vec<u8>, Vec<f64>), ProblemError> {
    let error = &solved.report.discretisation_error;
    let cuts = next_cuts(&error.indicator, Target::of(scene, error, target));
    let mut refinement = known.refinement.clone();
    refinement.push(cuts.clone());
    let body = RefinableBody::refined(scene, folder, &refinement)?;
    let start = transferred(
        solved.mesh,
        &body.mesh()?,
        &body.parents(),
        &solved.solution.multiplier,
    );
    Ok((cuts, start))
}

/// The last level of an adaptive computation, with all that led to it.
#[derive(Debug)]
pub struct AdaptedProblem {
    /// The problem on the last mesh.
    pub assembled: AssembledProblem,
    /// Its solution.
    pub solution: Solution,
    /// What follows from it.
    pub report: ContactReport,
    /// All levels.
    pub adaptation: Adaptation,
    /// Whether the target is met.
    pub status: AdaptiveStatus,
}

/// Solves a scene on finer and finer meshes until the estimated error meets the scene's
/// `adapt.error`; mesh files are looked for in `folder`, and `observe` sees every level that is done.
///
/// Nothing is asked about memory: what does not fit aborts, as any allocation does.
///
/// # Errors
/// [`ProblemError`] for a scene without a target or without a discrete problem.
pub fn adapted(
    scene: Scene,
    folder: &Path,
    observe: &mut dyn FnMut(&AdaptiveLevel),
) -> Result<AdaptedProblem, ProblemError> {
    let scene = scene.checked()?;
    scene.require_no_history("an adaptive mesh")?;
    let target = scene.adapt.ok_or_else(no_target)?.error;
    let mut levels = LevelInMemory {
        scene: &scene,
        folder,
        observe,
        at_hand: None,
    };
    let refined = refine(&scene, folder, target, Adaptation::default(), &mut levels)?;
    levels.solved(refined.level, &refined.adaptation)?;
    let (_, answer, _) = levels.at_hand.expect("the level was just solved");
    Ok(AdaptedProblem {
        assembled: answer.problem,
        solution: answer.solution,
        report: answer.report,
        adaptation: refined.adaptation,
        status: refined.status,
    })
}

fn no_target() -> Invalid {
    Invalid {
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
    observe: &'a mut dyn FnMut(&AdaptiveLevel),
    /// Its number, what it came to, and the seconds it took.
    at_hand: Option<(usize, Answer, f64)>,
}

impl LevelInMemory<'_> {
    fn solve(&self, level: usize, known: &Adaptation) -> Result<Answer, ProblemError> {
        let mut refinement = known.refinement.clone();
        refinement.truncate(level);
        let mesh = Mesh::refined(self.scene, self.folder, &refinement)?;
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

impl LevelKeeper for LevelInMemory<'_> {
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
        let contact = answer.problem.system().contact.as_ref();
        Ok(SolvedLevel {
            mesh: answer.problem.mesh(),
            dual: contact.and_then(|contact| contact.explicit()),
            solution: &answer.solution,
            report: &answer.report,
            seconds: *seconds,
        })
    }

    fn done(&mut self, _: usize, level: &AdaptiveLevel) {
        (self.observe)(level);
    }

    fn too_large(&mut self, _: usize, error: ProblemError) -> Result<(), ProblemError> {
        Err(error)
    }

    fn keep(&mut self, _: &Adaptation) {}
}

impl AdaptiveLevel {
    /// What a solved mesh came to.
    fn new(level: SolvedLevel<'_>) -> Self {
        Self {
            n_tetrahedra: level.mesh.tetrahedra.len(),
            n_free: level.solution.displacement.len(),
            n_multipliers: level.solution.multiplier.len(),
            estimated_error: level.report.discretisation_error.relative(),
            stability: level.dual.map(smallest_eigenvalue),
            status: level.solution.status,
            seconds: level.seconds,
        }
    }
}

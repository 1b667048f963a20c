//! Adaptive levels in memory.

use std::{path::Path, sync::Arc, time::Instant};

use super::{Adaptation, AdaptiveLevel, AdaptiveStatus, Target, next_cuts, transferred};
use crate::{
    AssembledProblem, Problem, ProblemError,
    dual::{ExplicitDual, smallest_eigenvalue},
    mesh::{Mesh, RefinableBody},
    post::ContactReport,
    scene::{Invalid, Scene},
    solver::{Solution, Start},
};

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
    let mut adaptation = Adaptation::default();
    let mut body = RefinableBody::new(&scene, folder)?;
    let mut mesh = Arc::new(body.mesh()?);
    let mut start: Option<Vec<f64>> = None;
    loop {
        let began = Instant::now();
        let problem = Problem::of_checked(scene.clone(), Arc::clone(&mesh))?;
        let assembled = problem.assemble()?;
        let from = Start {
            multiplier: start.as_deref(),
            ..Start::default()
        };
        let mut solution = assembled.solve_from(&scene.solve, from, &mut |_| {})?;
        let report = assembled.report(&solution)?;
        report.judge(&mut solution);
        let seconds = began.elapsed().as_secs_f64();
        adaptation
            .levels
            .push(level(&assembled, &solution, &report, seconds));
        adaptation.levels.last().into_iter().for_each(&mut *observe);
        let status = adaptation.status(target);
        if status != AdaptiveStatus::Refining {
            return Ok(AdaptedProblem {
                assembled,
                solution,
                report,
                adaptation,
                status,
            });
        }
        let error = &report.discretisation_error;
        let cuts = next_cuts(&error.indicator, Target::of(&scene, error, target));
        body.refine(&cuts);
        adaptation.refinement.push(cuts);
        let finer = Arc::new(body.mesh()?);
        let multiplier = &solution.multiplier;
        let next = transferred(&mesh, &finer, &body.parents(), multiplier);
        adaptation.starts.push(next.clone());
        start = Some(next).filter(|start| !start.is_empty());
        mesh = finer;
    }
}

fn no_target() -> Invalid {
    Invalid {
        key: "adapt".into(),
        expected: "a target for the error".into(),
        found: "none".into(),
        help: "write [adapt] with error = 0.01, for example".into(),
    }
}

fn level(
    assembled: &AssembledProblem,
    solution: &Solution,
    report: &ContactReport,
    seconds: f64,
) -> AdaptiveLevel {
    let contact = assembled.system().contact.as_ref();
    let dual = contact.and_then(|contact| contact.explicit());
    AdaptiveLevel::new(assembled.mesh(), dual, solution, report, seconds)
}

impl AdaptiveLevel {
    /// What a solved mesh came to; `dual` is S where it is held.
    #[must_use]
    pub fn new(
        mesh: &Mesh,
        dual: Option<&ExplicitDual>,
        solution: &Solution,
        report: &ContactReport,
        seconds: f64,
    ) -> Self {
        Self {
            n_tetrahedra: mesh.tetrahedra.len(),
            n_free: solution.displacement.len(),
            n_multipliers: solution.multiplier.len(),
            estimated_error: report.discretisation_error.relative(),
            stability: dual.map(smallest_eigenvalue),
            status: solution.status,
            seconds,
        }
    }
}

//! The stage `post`: what follows from a solution, for h5py and for ParaView.

use contact3d::{
    post::{ContactReport, Solved, SolvedContact},
    scene::{Friction, Parameters, Scene, SceneFile},
    solver::Solution,
};
use runfile::{GroupWriter, StoreError};
use serde::Serialize;

use super::{
    StageError,
    history::History,
    mesh::Meshed,
    solve::{Answer, Equations, FaceFriction, of_friction, only_friction, several_frictions},
};
use crate::format::{self, GridValues, Series};

/// What the stage depends on.
pub(super) struct Inputs<'a> {
    pub(super) input: &'a SceneFile,
    pub(super) meshed: &'a Meshed,
    pub(super) answer: Answer,
}

/// An answer with its report.
#[derive(Debug)]
pub(super) struct Evaluated {
    /// The solution, which has failed if a figure of the report is out of range, and its equations.
    pub(super) answer: Answer,
    pub(super) report: ContactReport,
    /// How a load history came to it; `None` without one.
    pub(super) history: Option<History>,
}

/// Evaluates an answer.
///
/// # Errors
/// A law of friction without a value at the slips of the solution.
pub(super) fn run(inputs: Inputs<'_>) -> Result<Evaluated, StageError> {
    let Inputs {
        input,
        meshed,
        mut answer,
    } = inputs;
    let report = report(&input.scene, meshed, &answer.equations, &answer.solution);
    let report = report.map_err(|invalid| input.refuse(invalid))?;
    report.judge(&mut answer.solution);
    Ok(Evaluated {
        answer,
        report,
        history: None,
    })
}

fn report(
    scene: &Scene,
    meshed: &Meshed,
    equations: &Equations,
    solution: &Solution,
) -> Result<ContactReport, contact3d::scene::Invalid> {
    let contact = equations.coupling().zip(meshed.contact());
    ContactReport::new(&Solved {
        scene,
        mesh: &meshed.mesh,
        system: equations.primal(),
        contact: contact.map(|(coupling, state)| SolvedContact { coupling, state }),
        solution,
    })
}

/// Writes the report as ParaView reads it; of a load history all increments, as a series that it plays.
pub(super) fn write_vtkhdf(
    writer: &mut GroupWriter<'_>,
    meshed: &Meshed,
    evaluated: &Evaluated,
) -> Result<(), StoreError> {
    let frame = meshed.interface.as_ref().map(|interface| &interface.frame);
    let Some(history) = &evaluated.history else {
        let unstopped = evaluated.answer.solution.unstopped_motion.as_deref();
        return format::write_vtkhdf(writer, &meshed.mesh, &evaluated.report, frame, unstopped);
    };
    let times = history.records.iter().map(|record| record.increment.time);
    let times: Vec<f64> = times.collect();
    let mut series = Series::begin(writer, &meshed.mesh, &times)?;
    for record in &history.records {
        series.step(&meshed.mesh, &GridValues::from(record), frame)?;
    }
    series.finish()
}

/// Writes the report beside that for ParaView, whose digest it holds.
pub(super) fn write(
    writer: &mut GroupWriter<'_>,
    meshed: &Meshed,
    evaluated: &Evaluated,
    vtkhdf_digest: &str,
) -> Result<(), StoreError> {
    let frame = meshed.interface.as_ref().map(|interface| &interface.frame);
    let face = meshed.mesh.contact.as_ref().zip(frame);
    format::write_report(writer, &evaluated.report, face, vtkhdf_digest)
}

/// The part of a scene that the stage depends on directly.
#[derive(Serialize)]
pub(super) struct Settings<'a> {
    friction: Option<&'a Friction>,
    /// The laws of several contact faces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    frictions: Vec<FaceFriction<'a>>,
    /// What the formulas here use.
    #[serde(skip_serializing_if = "Parameters::is_empty")]
    parameters: Parameters,
}

impl<'a> Settings<'a> {
    pub(super) fn of(scene: &'a Scene) -> Self {
        Self {
            friction: only_friction(scene),
            frictions: several_frictions(scene),
            parameters: scene.parameters_used(of_friction),
        }
    }
}

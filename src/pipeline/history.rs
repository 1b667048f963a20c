//! Load histories: the stage `solve` of a scene with steps, one increment after the other.

use contact3d::{
    contact::{Coupling, Interface},
    dual::{Admission, DualSystem, Need, PrimalSystem},
    history::{HistoryError, LoadHistory, SolvedHistory, StepRecord, interface_after},
    mesh::Mesh,
    post::{ContactReport, Solved, SolvedContact},
    scene::{Increment, Invalid, SceneFile, SolveSettings},
    solver::{ContactState, Progress, Start},
};
use runfile::Reader;

use super::{
    StageError,
    mesh::Meshed,
    post::Evaluated,
    solve::{Answer, Equations},
};
use crate::format;

/// What storing the increments takes before it is known, in s.
pub(super) const SECONDS_OF_A_COMMIT: f64 = 0.05;

/// How a load history came to its last increment.
#[derive(Debug)]
pub(super) struct History {
    /// The increments that were solved.
    pub(super) records: Vec<StepRecord>,
    /// The laws of the contact face in the last of them; `None` without contact.
    pub(super) interface: Option<Interface>,
}

/// What the stage depends on.
pub(super) struct Inputs<'a> {
    pub(super) input: &'a SceneFile,
    pub(super) settings: &'a SolveSettings,
    pub(super) mesh: &'a Mesh,
    /// The assembled problem, whatever its loads.
    pub(super) operator: &'a DualSystem,
    /// The multipliers that the first increment starts from.
    pub(super) start: Option<&'a [f64]>,
    /// What a killed solve of the same history did.
    pub(super) done: Vec<StepRecord>,
    /// Decides whether the operators in double precision may be formed, should single precision lead to no answer.
    pub(super) admit: Admission<'a>,
}

/// A history, and the operators in double precision that it ended with where those in single precision led to no answer.
pub(super) struct HistoryOutcome {
    pub(super) evaluated: Evaluated,
    pub(super) double: Option<DualSystem>,
}

/// Solves the increments that are left, and evaluates the last one; `keep` sees all records after each.
///
/// # Errors
/// A value that no problem can have, a method that needs the dense operator.
pub(super) fn run(
    inputs: Inputs<'_>,
    observe: &mut dyn FnMut(Increment, Progress<'_>),
    keep: &mut dyn FnMut(&[StepRecord]),
) -> Result<HistoryOutcome, StageError> {
    let history = LoadHistory {
        scene: &inputs.input.scene,
        mesh: inputs.mesh,
        operator: inputs.operator,
    };
    let start = Start {
        multiplier: inputs.start,
        checkpoint: None,
    };
    let refuse = |error| match error {
        HistoryError::Invalid(invalid) => inputs.input.refuse(invalid).into(),
        HistoryError::NeedsExplicit(error) => StageError::from(error),
    };
    let mut solved = history
        .solve(inputs.settings, inputs.done, start, observe, keep)
        .map_err(refuse)?;
    let double = history.reconsidered(&solved, inputs.settings, inputs.admit, &|_, _| ());
    if let Some(operator) = &double {
        let history = LoadHistory {
            operator,
            ..history
        };
        let records = solved.records_before();
        solved = history
            .solve(inputs.settings, records, start, observe, keep)
            .map_err(refuse)?;
    }
    let SolvedHistory {
        records,
        problem,
        solution,
        report,
    } = solved;
    let evaluated = Evaluated {
        answer: Answer {
            equations: Equations::CachedProblem(problem.system.into()),
            solution,
        },
        report,
        history: Some(History {
            records,
            interface: problem.interface,
        }),
    };
    Ok(HistoryOutcome { evaluated, double })
}

/// Reads the last increment back and evaluates it; `equations` may have the loads of another one.
///
/// # Errors
/// Missing or altered datasets, laws that no problem can have.
pub(super) fn read(
    reader: &Reader,
    input: &SceneFile,
    meshed: &Meshed,
    equations: Equations,
) -> Result<Evaluated, StageError> {
    let records = format::read_history(reader, &input.scene)?;
    let mesh = &*meshed.mesh;
    let refuse = |invalid: Invalid| input.refuse(invalid);
    let (mut primal, coupling) = equations.into_primal();
    let solution = format::read_solution(reader, &primal.dofs)?;
    let evaluate = |primal: &mut PrimalSystem,
                    coupling: Option<&Coupling>|
     -> Result<(ContactReport, Option<Interface>), Invalid> {
        let (scene, before) = match records.split_last() {
            Some((last, before)) => (input.scene.at_increment(last.increment)?, before.last()),
            None => (input.scene.at_end()?, None),
        };
        let interface = interface_after(&input.scene, &scene, mesh, before)?;
        primal.apply_loads(&scene, mesh)?;
        let face = mesh.contact.as_ref().zip(interface.as_ref());
        let state = face.map(|(surface, interface)| ContactState { surface, interface });
        let report = ContactReport::new(&Solved {
            scene: &scene,
            mesh,
            system: primal,
            contact: coupling
                .zip(state)
                .map(|(coupling, state)| SolvedContact { coupling, state }),
            solution: &solution,
        })?;
        Ok((report, interface))
    };
    let (report, interface) = evaluate(&mut primal, coupling.as_ref()).map_err(refuse)?;
    let mut solution = solution;
    report.judge(&mut solution);
    Ok(Evaluated {
        answer: Answer {
            equations: Equations::Primal(primal, coupling),
            solution,
        },
        report,
        history: Some(History { records, interface }),
    })
}

/// What the increments of a history take: their fields in memory, twice while they are written, and on the disk.
pub(super) fn need_of(input: &SceneFile, mesh: &Mesh) -> Need {
    let contact = mesh.contact.as_ref();
    let nodes = contact.map_or(0, |surface| surface.nodes.len());
    let panes = contact.map_or(0, |surface| surface.n_panes());
    let numbers = 6 * mesh.coordinates.len() + mesh.tetrahedra.len() + 5 * nodes + 12 * panes + 64;
    let bytes = 8 * numbers as u64 * input.scene.increments().len() as u64;
    Need {
        step: "keeping the increments of the load history",
        memory: bytes + bytes / 2,
        stored: 2 * bytes,
    }
}

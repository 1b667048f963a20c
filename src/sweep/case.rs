//! Running one case, with what other cases of the folder have made.

use std::path::Path;

use contact3d::{adaptation::RefinementGoal, scene::Scene};
use runfile::Reader;

use super::{Event, Options, Plan, folder::operator_turn, operators::Operators};
use crate::{
    format::{self, LAYOUT, Stage},
    pipeline::{Commit, Session, StageError, operator_settings},
};

/// What two cases must have in common to share an operator.
pub(super) fn operator_key(scene: &Scene) -> String {
    let digest = blake3::hash(operator_settings(scene).as_bytes());
    digest.to_hex().to_string()
}

/// Runs what is not fresh of a case.
pub(super) fn run(
    plan: &Plan,
    index: usize,
    folder: &Path,
    options: &Options,
    operators: &Operators,
) -> Result<Event, StageError> {
    let case = &plan.cases[index];
    let mut session = Session::with_scene(&case.file(folder), case.scene.clone(), options.threads)?;
    session.mend_scene()?;
    if let Some(adapt) = case.scene.scene.adapt {
        let goal = RefinementGoal {
            error: adapt.error,
            deadline: None,
        };
        let adapted = session.adapt(goal, &mut |_| {})?;
        if options.self_contained {
            session.embed_assembly()?;
        }
        return Ok(if adapted.performed.is_empty() {
            Event::Kept
        } else {
            Event::Computed
        });
    }
    if let Some(start) = case.start {
        session.start_from(multiplier(&plan.cases[start].file(folder))?.unwrap_or_default());
    }
    let mut event = Event::Kept;
    if !session.is_done()? {
        event = Event::Computed;
        let key = operator_key(&case.scene.scene);
        let outcome = operators
            .prepare(&key, |known| {
                let turn = operator_turn(folder, &key).map_err(|source| StageError::Write {
                    file: folder.to_owned(),
                    source,
                })?;
                let operator = session.prepare_operator(known);
                drop(turn);
                operator
            })
            .and_then(|()| compute(&mut session));
        operators.release(&key);
        outcome?;
    }
    if options.self_contained {
        session.embed_assembly()?;
    }
    Ok(event)
}

/// Loads, solution and report, each if it or an earlier one is not fresh.
fn compute(session: &mut Session) -> Result<(), StageError> {
    let commit = Commit::WithNextIfCheap;
    let mut stale = false;
    for state in session.states()? {
        stale |= !state.is_fresh();
        if !stale {
            continue;
        }
        session.perform(state.stage, commit, &mut |_| {})?;
    }
    Ok(())
}

/// The multipliers of a solved case; `None` if it has none or did not converge.
fn multiplier(run_file: &Path) -> Result<Option<Vec<f64>>, StageError> {
    let Ok(reader) = Reader::open(run_file, LAYOUT) else {
        return Ok(None);
    };
    if !matches!(reader.group_record(Stage::Post.group()), Ok(Some(_))) {
        return Ok(None);
    }
    let (status, multiplier) = format::read_multiplier(&reader)?;
    Ok(status
        .is_solved()
        .then_some(multiplier)
        .filter(|m| !m.is_empty()))
}

//! What a run file has for ParaView and PyVista, in a file of its own.

use std::path::Path;

use runfile::{IfMissing, Reader, RunFile, Transaction};

use crate::{
    format::{self, LAYOUT, SERIES_LAYOUT, Stage, VTKHDF},
    output::Inputs,
    pipeline::{Freshness, StageError, states},
};

/// Copies `/VTKHDF` of a run file; returns the bytes of the file.
///
/// # Errors
/// A run file whose report is not fresh, a target that is an input or no file of this kind.
pub fn export_grid(run_file: &Path, target: &Path) -> Result<u64, StageError> {
    Inputs::of([run_file]).refuse(target)?;
    let reader = Reader::open(run_file, LAYOUT)?;
    let input = format::read_scene(&reader, run_file)?;
    let states = states(&reader, &input.scene);
    if let Some(state) = states
        .into_iter()
        .find(|state| state.stage <= Stage::Post && state.freshness != Freshness::Fresh)
    {
        return Err(StageError::Unfit {
            file: run_file.to_owned(),
            reason: format!(
                "`export` needs a finished file, but `{}` cannot be used, {}; run `contact3d-pipe run` first",
                state.stage.word(),
                state.freshness.why()
            ),
        });
    }
    let layout = SERIES_LAYOUT.in_units(input.scene.units);
    let file = RunFile::lock(target, layout, IfMissing::Create)?;
    let mut transaction = Transaction::begin(&file)?;
    transaction.copy(&reader, VTKHDF)?;
    transaction.commit()?;
    let written = std::fs::metadata(target).map_err(|source| StageError::Write {
        file: target.to_owned(),
        source,
    })?;
    Ok(written.len())
}

//! What a run file has for ParaView and PyVista, in a file of its own.

use std::path::Path;

use runfile::{IfMissing, RunFile, Transaction};

use crate::{
    format::{SERIES_LAYOUT, Stage, VTKHDF},
    output::Inputs,
    pipeline::{OpenRun, StageError},
};

/// Copies `/VTKHDF` of a run file; returns the bytes of the file.
///
/// # Errors
/// A run file whose report is not fresh, a target that is an input or no file of this kind.
pub fn export_grid(run_file: &Path, target: &Path) -> Result<u64, StageError> {
    Inputs::of([run_file]).refuse(target)?;
    let run = OpenRun::open(run_file)?;
    run.require_fresh(Stage::Post, "finished")?;
    let layout = SERIES_LAYOUT.in_units(run.input.scene.units);
    let file = RunFile::lock(target, layout, IfMissing::Create)?;
    let mut transaction = Transaction::begin(&file)?;
    transaction.copy(&run.reader, VTKHDF)?;
    transaction.commit()?;
    let written = std::fs::metadata(target).map_err(|source| StageError::Write {
        file: target.to_owned(),
        source,
    })?;
    Ok(written.len())
}

//! Files for other programs: frictional contact problems in those of FCLIB, grids for ParaView.
//!
//! `frozen` makes a problem of a solution, `fclib` knows the layout of its file, `export` joins them. Files are put together beside
//! their places before the output guard lets them in.

mod export;
mod fclib;
mod frozen;

use std::{fs, path::Path};

use runfile::{IfMissing, RunFile, Transaction, WrittenFile};

use crate::{
    format::{SERIES_LAYOUT, Stage, VTKHDF},
    output::{self, Inputs, OutputError, OutputFile, OutputKind},
    pipeline::{OpenRun, StageError},
};

pub use export::{FclibForm, export};

/// Lets a file of FCLIB into its place; returns its bytes.
fn put(written: &WrittenFile, target: &Path, inputs: &Inputs) -> Result<usize, OutputError> {
    let bytes = fs::read(written.path()).map_err(|source| OutputError::Io {
        file: target.to_owned(),
        action: "read the file just made",
        source,
    })?;
    let file = OutputFile {
        path: target.to_owned(),
        kind: OutputKind::Fclib,
        bytes,
    };
    output::write(std::slice::from_ref(&file), inputs)?;
    Ok(file.bytes.len())
}

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
    let written = fs::metadata(target).map_err(|source| StageError::Write {
        file: target.to_owned(),
        source,
    })?;
    Ok(written.len())
}

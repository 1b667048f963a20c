//! Many scenes that differ in a few keys: planned, run in parallel with shared work, resumed,
//! summed up.
//!
//! Every case is a run file of its own, named by a digest of its scene, so changed axes add files
//! and never replace one. Cases whose assembled problems differ only in loads or friction share the
//! files of mesh and factor, and in one process the arrays themselves.

mod axes;
mod folder;
mod operators;
mod plan;
mod run;
mod series;
mod summary;

pub use axes::{MOST_CASES, SweepFile, read_index};
pub use folder::is_busy;
pub use plan::{Case, Plan, changed as changed_scene};
pub use run::{Event, Options, Outcome, run, run_case};
pub use series::write as write_series;
pub use summary::{CSV_FILE, SUMMARY_FILE, write as write_summary};

use std::path::PathBuf;

use thiserror::Error;

use crate::pipeline::StageError;

/// Bad input of a sweep.
#[derive(Debug, Error)]
pub enum SweepError {
    /// An axis that no sweep can have, or a key of it.
    #[error("{}: {place}: expected {expected}, found {found}", file.display())]
    Axis {
        file: PathBuf,
        place: String,
        expected: String,
        found: String,
    },
    /// The plan of a sweep has no case with this name.
    #[error("no case {id} in this sweep; `contact3d-pipe sweep plan` lists them")]
    NoSuchCase { id: String },
    /// Another process runs the sweep.
    #[error("{}: another sweep is at work in this folder; wait until it is done", folder.display())]
    Busy { folder: PathBuf },
    /// A table of another sweep, whose file is named as seen from the folder, where the table says it.
    #[error("{}: this table belongs to another sweep{}{sweep}; nothing was changed, name another folder or move summary.h5 and summary.csv away", file.display(), if sweep.is_empty() { "" } else { ", " })]
    OthersTable { file: PathBuf, sweep: String },
}

impl From<SweepError> for StageError {
    fn from(error: SweepError) -> Self {
        Self::Command(error.into())
    }
}

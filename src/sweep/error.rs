//! Why a sweep, or the index of a suite, cannot be used.

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
    #[error("{}: this table belongs to another sweep{}{sweep}; nothing was changed, give another folder with --out or move summary.h5 and summary.csv away", file.display(), if sweep.is_empty() { "" } else { ", " })]
    OthersTable { file: PathBuf, sweep: String },
}

impl From<SweepError> for StageError {
    fn from(error: SweepError) -> Self {
        Self::Command(error.into())
    }
}

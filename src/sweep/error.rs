//! Why a sweep cannot be planned, run or summarised.

use std::path::PathBuf;

use contact3d::scene::SceneError;
use runfile::StoreError;
use thiserror::Error;

use crate::{format::FormatError, output::OutputError, pipeline::StageError};

/// Why a sweep cannot be planned, run or summed up.
#[derive(Debug, Error)]
pub enum SweepError {
    /// A file or folder cannot be read or written.
    #[error("cannot {action} {}: {source}", file.display())]
    Io {
        /// What was tried.
        action: &'static str,
        /// The file or folder.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// An axis that no sweep can have.
    #[error("{}: {place}: expected {expected}, found {found}", file.display())]
    Axis {
        /// The sweep file.
        file: PathBuf,
        /// The axis or key.
        place: String,
        /// What a sweep allows.
        expected: String,
        /// What stands there.
        found: String,
    },
    /// The text of a sweep, the scene of a case, or the scene that all cases change.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The plan has no case with this name.
    #[error("no case {id} in this sweep; `contact3d-pipe sweep plan` lists them")]
    NoSuchCase {
        /// The name that was asked for.
        id: String,
    },
    /// Another process runs the sweep.
    #[error("{}: another sweep is at work in this folder; wait until it is done", folder.display())]
    Busy {
        /// The folder.
        folder: PathBuf,
    },
    /// A table of another sweep.
    #[error("{}: this table belongs to another sweep{}; nothing was changed, give another folder with --out or move summary.h5 and summary.csv away", file.display(), of(sweep))]
    OthersTable {
        /// The table.
        file: PathBuf,
        /// The sweep file that wrote it, as seen from the folder; empty if the table does not say.
        sweep: String,
    },
    /// An output that is an input, or in the place of a file of another kind, or that cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The cases were run, but their tables cannot be written.
    #[error("{0}; the cases are stored and kept, `contact3d-pipe sweep summary` writes the tables")]
    NotSummedUp(#[source] Box<SweepError>),
    /// The table of the sweep cannot be written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A run file cannot be summed up.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A case that was run alone.
    #[error(transparent)]
    Stage(#[from] StageError),
    /// The CSV table cannot be written.
    #[error("cannot write {}: {source}", file.display())]
    Csv {
        /// The file.
        file: PathBuf,
        /// What went wrong.
        source: csv::Error,
    },
}

/// What a message says of the sweep file that wrote a table.
fn of(sweep: &str) -> String {
    match sweep {
        "" => String::new(),
        sweep => format!(", {sweep}"),
    }
}

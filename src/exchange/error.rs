//! Why problems cannot be exchanged.

use std::path::PathBuf;

use contact3d::solver::DelassusError;
use fclib::FclibError;
use thiserror::Error;

/// Why a file of FCLIB cannot be written or solved.
#[derive(Debug, Error)]
pub enum ExchangeError {
    /// A solved problem that such files cannot hold.
    #[error("{}: {reason}", file.display())]
    Unfit {
        /// The run file.
        file: PathBuf,
        /// What does not fit, and what to do.
        reason: String,
    },
    /// A file of FCLIB.
    #[error(transparent)]
    Fclib(#[from] FclibError),
    /// Numbers that make no problem.
    #[error("{}: {source}", file.display())]
    Problem {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        source: DelassusError,
    },
}

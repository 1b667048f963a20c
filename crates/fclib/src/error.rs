//! What is wrong with a file.

use std::path::{Path, PathBuf};

use hdf5_metno as hdf5;
use runfile::StoreError;
use thiserror::Error;

/// Why a file cannot be read or written.
#[derive(Debug, Error)]
pub enum FclibError {
    /// HDF5 cannot do what was asked.
    #[error("{}: cannot {action}: {source}; check that it is an HDF5 file that can be used so", file.display())]
    Hdf5 {
        /// The file.
        file: PathBuf,
        /// What was tried.
        action: String,
        /// What HDF5 says.
        source: hdf5::Error,
    },
    /// The file cannot be opened, is damaged, or does not hold its own data.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A group or dataset that is not there.
    #[error("{}: {path} is missing; {help}", file.display())]
    Missing {
        /// The file.
        file: PathBuf,
        /// The group or dataset.
        path: String,
        /// What to do.
        help: &'static str,
    },
    /// Something that FCLIB files do not hold.
    #[error("{}: {path}: expected {expected}, found {found}; write the file anew with FCLIB's own library", file.display())]
    Unexpected {
        /// The file.
        file: PathBuf,
        /// The group or dataset.
        path: String,
        /// What it should be.
        expected: String,
        /// What it is.
        found: String,
    },
    /// A problem of a kind that nothing here reads.
    #[error("{}: {path}: {found} is not supported; {help}", file.display())]
    Unsupported {
        /// The file.
        file: PathBuf,
        /// The group or dataset.
        path: String,
        /// What it is.
        found: String,
        /// What to do.
        help: &'static str,
    },
    /// More rows or entries than 32-bit indices count.
    #[error("{what}: {count} do not fit the 32-bit indices of FCLIB files; take a smaller problem")]
    TooLarge {
        /// What is counted.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
}

/// Adds the file and what was tried to an error of HDF5.
pub(crate) trait InFile<T> {
    fn in_file(self, file: &Path, action: impl FnOnce() -> String) -> Result<T, FclibError>;
}

impl<T> InFile<T> for hdf5::Result<T> {
    fn in_file(self, file: &Path, action: impl FnOnce() -> String) -> Result<T, FclibError> {
        self.map_err(|source| FclibError::Hdf5 {
            file: file.to_owned(),
            action: action(),
            source,
        })
    }
}

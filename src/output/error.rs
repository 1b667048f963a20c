//! Why an output cannot be written.

use std::{io, path::PathBuf};

use thiserror::Error;

/// Why an output cannot be written.
#[derive(Debug, Error)]
pub enum OutputError {
    /// The output is one of the files that the command reads.
    #[error("{}: this command reads that file ({}); nothing was changed, choose another output", file.display(), input.display())]
    IsInput {
        /// The output.
        file: PathBuf,
        /// The input that is the same file.
        input: PathBuf,
    },
    /// The file is there and this program did not write it as what it would be now.
    #[error("{}: expected {expected} of this program or no file, found {found}; nothing was changed, choose another output or move the file away", file.display())]
    Foreign {
        /// The output.
        file: PathBuf,
        /// What would be written.
        expected: &'static str,
        /// What is there.
        found: &'static str,
    },
    /// Something that cannot be written to.
    #[error("{}: expected a file, found {found}; nothing was changed, choose another output", file.display())]
    NotAFile {
        /// The output.
        file: PathBuf,
        /// What is there.
        found: &'static str,
    },
    /// A folder for outputs cannot be made or written to.
    #[error("{}: expected a folder to write to, found {found}; nothing was changed, choose another folder", folder.display())]
    Folder {
        /// The folder asked for.
        folder: PathBuf,
        /// What is in the way.
        found: String,
    },
    /// The file system failed.
    #[error("{}: cannot {action}: {source}; check the free space and the permissions of the folder, or choose another output", file.display())]
    Io {
        /// The output.
        file: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system says.
        source: io::Error,
    },
}

impl OutputError {
    /// Whether the machine failed rather than the input being at fault.
    #[must_use]
    pub fn is_of_machine(&self) -> bool {
        matches!(self, Self::Io { .. })
    }
}

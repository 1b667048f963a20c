//! Why an output cannot be written.

use std::{io, path::PathBuf};

use thiserror::Error;

/// Why an output cannot be written.
#[derive(Debug, Error)]
pub enum OutputError {
    /// The output is one of the files that the command reads.
    #[error("{}: this command reads that file ({}); nothing was changed, choose another output", file.display(), input.display())]
    IsInput { file: PathBuf, input: PathBuf },
    /// The file is there and this program did not write it as what it would be now.
    #[error("{}: expected {expected} of this program or no file, found {found}; nothing was changed, choose another output or move the file away", file.display())]
    Foreign {
        file: PathBuf,
        expected: &'static str,
        found: &'static str,
    },
    /// Something that cannot be written to.
    #[error("{}: expected a file, found {found}; nothing was changed, choose another output", file.display())]
    NotAFile { file: PathBuf, found: &'static str },
    /// A folder for outputs cannot be made or written to.
    #[error("{}: expected a folder to write to, found {found}; nothing was changed, choose another folder", folder.display())]
    Folder { folder: PathBuf, found: String },
    /// The file system failed.
    #[error("{}: cannot {action}: {source}; check the free space and the permissions of the folder, or choose another output", file.display())]
    Io {
        file: PathBuf,
        action: &'static str,
        source: io::Error,
    },
}

impl OutputError {
    /// Whether the machine failed rather than the input being at fault.
    pub fn is_of_machine(&self) -> bool {
        matches!(self, Self::Io { .. })
    }
}

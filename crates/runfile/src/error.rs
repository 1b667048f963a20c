//! What can go wrong with a run file, with the place, the expectation, the finding and the remedy.

use std::io;
use std::path::{Path, PathBuf};

use hdf5_metno as hdf5;
use thiserror::Error;

use crate::layout::Group;

/// An error of the file store.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The run file does not exist.
    #[error("{}: no such file; create it with an earlier stage, or check the path", file.display())]
    NotFound {
        /// The run file.
        file: PathBuf,
    },
    /// The path of the run file is a directory.
    #[error("{}: is a directory; give the path of a file inside it", file.display())]
    IsDirectory {
        /// The path given.
        file: PathBuf,
    },
    /// The path of the run file is a pipe, a device or a socket.
    #[error("{}: expected a regular file, found a pipe, device or socket; nothing was changed, choose another path", file.display())]
    NotAFile {
        /// The path given.
        file: PathBuf,
    },
    /// The folder of the run file does not exist.
    #[error("{}: the folder {} does not exist; create it first", file.display(), folder.display())]
    FolderMissing {
        /// The run file.
        file: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The file is no HDF5 file.
    #[error("{}: not an HDF5 file; nothing was changed, give such a file to read, or another path to write", file.display())]
    NotHdf5 {
        /// The file.
        file: PathBuf,
    },
    /// The file is an HDF5 file of something else.
    #[error("{}: not one of our files: expected filetype \"{expected}\", found {found}; nothing was changed, give such a file to read, or run again with another path", file.display())]
    NotOurs {
        /// The file.
        file: PathBuf,
        /// The file type of the layout.
        expected: &'static str,
        /// What stands there.
        found: String,
    },
    /// The file has a format version this program does not read.
    #[error("{}: is of format {}.{}, expected {}.{}; nothing was changed, run again with another path, or use the program that wrote it ({creator})", file.display(), found[0], found[1], expected[0], expected[1])]
    Version {
        /// The file.
        file: PathBuf,
        /// The version this program writes.
        expected: [i64; 2],
        /// The version of the file.
        found: [i64; 2],
        /// The program that wrote the file.
        creator: String,
    },
    /// Another process is writing the file.
    #[error("{}: busy, another process is writing it; wait until it is done (lock file {})", file.display(), lock.display())]
    Busy {
        /// The run file.
        file: PathBuf,
        /// The lock file beside it.
        lock: PathBuf,
    },
    /// The file system has no locks.
    #[error("{}: the file system has no locks; if no other process writes to the folder meanwhile, set HDF5_USE_FILE_LOCKING=FALSE in the environment", lock.display())]
    NoLocks {
        /// The lock file.
        lock: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Another program changed, replaced or removed the file while this one was at work on it.
    #[error("{}: another program changed or removed the file, or one that it links, while this one was at work on it; nothing was stored, run the command again", file.display())]
    Changed {
        /// The run file.
        file: PathBuf,
    },
    /// A dataset or group that should be there is missing.
    #[error("{}: {dataset} is missing; run `{}` again", file.display(), group.writer())]
    Missing {
        /// The run file.
        file: PathBuf,
        /// Path of the dataset, group or attribute.
        dataset: String,
        /// The group it belongs to.
        group: Group,
    },
    /// A dataset has another type, shape or encoding than the table says.
    #[error("{}: {dataset}: expected {expected}, found {found}; run the stage that owns it again", file.display())]
    Mismatch {
        /// The run file.
        file: PathBuf,
        /// Path of the dataset or attribute.
        dataset: String,
        /// What the table, or an upstream dataset, says.
        expected: String,
        /// What the file holds.
        found: String,
    },
    /// The file is not as it was written.
    #[error("{}: its bytes are not those that contact3d-pipe wrote: another program opened it for writing, or the disk gives back other bytes; nothing was changed, restore the file, or remove it and run again", file.display())]
    Altered {
        /// The file.
        file: PathBuf,
    },
    /// A group is kept in a file of its own, and that file cannot be used.
    #[error("{}: /{group} is kept in a file of its own, and {problem}; run `{}` again", file.display(), group.writer())]
    Linked {
        /// The run file.
        file: PathBuf,
        /// The group.
        group: Group,
        /// What is wrong with the other file.
        problem: LinkProblem,
    },
    /// A number that must be finite is not.
    #[error("{}: {dataset}: expected finite numbers, found {found} at flat index {index}; run the stage that owns it again", file.display())]
    NotFinite {
        /// The run file.
        file: PathBuf,
        /// Path of the dataset.
        dataset: String,
        /// Position in row-major order.
        index: usize,
        /// The value.
        found: f64,
    },
    /// The file, or a dataset of it, cannot be what was written.
    #[error("{}: {dataset} is damaged: {reason}; remove the file, or restore it, and run again", file.display())]
    Damaged {
        /// The run file.
        file: PathBuf,
        /// Path of the dataset, `/` for the whole file.
        dataset: String,
        /// What gave it away.
        reason: String,
    },
    /// HDF5 failed.
    #[error("{}: {dataset}: HDF5 could not {action}; check the free space and the permissions of the folder", file.display())]
    Hdf5 {
        /// The file being read or written.
        file: PathBuf,
        /// Path of the dataset, group or attribute.
        dataset: String,
        /// What was tried.
        action: &'static str,
        /// The cause.
        source: Box<hdf5::Error>,
    },
    /// The file system failed.
    #[error("{}: could not {action}; check the free space and the permissions of the folder", file.display())]
    Io {
        /// The file being read or written.
        file: PathBuf,
        /// What was tried.
        action: &'static str,
        /// The cause.
        source: io::Error,
    },
    /// The environment has HDF5 open files by other means than it is told.
    #[error(
        "{variable} = {found:?} in the environment: expected {plain:?} or nothing, since other means of opening files are not supported; unset it"
    )]
    Environment {
        /// The name of the variable.
        variable: &'static str,
        /// Its only value that changes nothing.
        plain: &'static str,
        /// Its value.
        found: String,
    },
    /// A file was written without an error, and the disk gives back something else.
    #[error("{}: the new state was written, and what the disk gives back is another one ({reason}); the earlier state was kept, check the disk", file.display())]
    Unproven {
        /// The run file.
        file: PathBuf,
        /// What is different.
        reason: String,
    },
    /// A state is in its place, but the disk does not promise that it is there after a loss of power.
    #[error("{}: the new state is in its place, but the folder could not be synced, so a loss of power may undo it; check the disk", file.display())]
    Unsynced {
        /// The run file.
        file: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The program broke the table of datasets: a defect of the program, not of the file.
    #[error("internal error in the use of the dataset table: {0}; please report it")]
    Internal(#[from] LayoutError),
}

impl StoreError {
    /// Whether the error is a defect of the program rather than of the file or the machine.
    #[must_use]
    pub fn is_internal(&self) -> bool {
        matches!(self, StoreError::Internal(_))
    }

    /// Whether the new state is in its place all the same.
    #[must_use]
    pub fn is_after_storing(&self) -> bool {
        matches!(self, StoreError::Unsynced { .. })
    }
}

/// Why the file that holds a group of a run file cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LinkProblem {
    /// What the run file says cannot be the name of such a file.
    #[error(
        "{found:?} cannot be its name: expected STAGE-DIGEST.h5 in the same folder, nothing was followed"
    )]
    NotAName {
        /// What the run file says.
        found: String,
    },
    /// There is no such file.
    #[error("{} is missing: put it back beside the run file", file.display())]
    Missing {
        /// Where it should be.
        file: PathBuf,
    },
    /// It is damaged, or something else.
    #[error("it cannot be used ({reason})")]
    Unusable {
        /// Which file it is and what is wrong.
        reason: String,
    },
    /// It holds another result than the one its name stands for.
    #[error("{} was replaced: expected a stage whose digest begins like its name ends, found {found}", file.display())]
    Replaced {
        /// The file.
        file: PathBuf,
        /// The digest of the group in it.
        found: String,
    },
}

/// A breach of the dataset table by the program itself.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LayoutError {
    /// A dataset that the table does not have, not there, or not so: with the path what is wrong.
    #[error("{path}{problem}")]
    Dataset {
        /// The path asked for.
        path: String,
        /// What is wrong with it, in words that go on from the path.
        problem: String,
    },
    /// A dataset, or a whole group, was written twice.
    #[error("{path} was written twice")]
    Twice {
        /// The dataset or group.
        path: String,
    },
    /// A group ended without a required dataset.
    #[error("the group `{group}` was finished without {}", missing.join(", "))]
    NotWritten {
        /// The group.
        group: Group,
        /// The datasets that are missing.
        missing: Vec<&'static str>,
    },
    /// A commit while a group was still being written.
    #[error("the group `{group}` was begun but not finished")]
    NotFinished {
        /// The group.
        group: Group,
    },
}

impl LayoutError {
    /// A dataset that the table does not have.
    pub(super) fn unknown(path: &str) -> StoreError {
        Self::dataset(path, " is not in the table")
    }

    /// What is wrong with a dataset, in words that go on from its path.
    pub(super) fn dataset(path: &str, problem: impl Into<String>) -> StoreError {
        let (path, problem) = (path.to_owned(), problem.into());
        Self::Dataset { path, problem }.into()
    }
}

/// A file and a path inside it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<'a> {
    pub(super) file: &'a Path,
    pub(super) dataset: &'a str,
}

impl<'a> Place<'a> {
    pub(super) const fn new(file: &'a Path, dataset: &'a str) -> Self {
        Place { file, dataset }
    }

    /// Another place in the same file.
    pub(super) const fn beside(self, dataset: &'a str) -> Self {
        Place { dataset, ..self }
    }

    pub(super) fn mismatch(
        &self,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> StoreError {
        StoreError::Mismatch {
            file: self.file.into(),
            dataset: self.dataset.into(),
            expected: expected.into(),
            found: found.into(),
        }
    }

    pub(super) fn damaged(&self, reason: impl Into<String>) -> StoreError {
        StoreError::Damaged {
            file: self.file.into(),
            dataset: self.dataset.into(),
            reason: reason.into(),
        }
    }
}

/// Gives a failed HDF5 call its place.
pub(super) trait AtPlace<T> {
    fn at(self, place: Place<'_>, action: &'static str) -> Result<T, StoreError>;
}

impl<T> AtPlace<T> for hdf5::Result<T> {
    fn at(self, place: Place<'_>, action: &'static str) -> Result<T, StoreError> {
        self.map_err(|source| StoreError::Hdf5 {
            file: place.file.into(),
            dataset: place.dataset.into(),
            action,
            source: Box::new(source),
        })
    }
}

/// Gives a failed call of the file system its file.
pub(super) trait AtFile<T> {
    fn at_file(self, file: &Path, action: &'static str) -> Result<T, StoreError>;
}

impl<T> AtFile<T> for io::Result<T> {
    fn at_file(self, file: &Path, action: &'static str) -> Result<T, StoreError> {
        self.map_err(|source| StoreError::Io {
            file: file.into(),
            action,
            source,
        })
    }
}

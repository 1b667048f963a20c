//! One HDF5 file opened for reading: the run file, or the file beside it that holds one group.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use hdf5_metno as hdf5;

use crate::error::{AtFile, StoreError};
use crate::header;
use crate::layout::Layout;

/// An open file that is as it was written.
#[derive(Debug)]
pub(super) struct Hdf5File {
    pub(super) path: PathBuf,
    pub(super) hdf5: hdf5::File,
    /// Length of the file.
    pub(super) bytes: u64,
}

impl Hdf5File {
    /// Opens a file; errors as for [`crate::Reader::open`].
    pub(super) fn open(
        path: &Path,
        layout: &Layout,
        filetype: &'static str,
    ) -> Result<Self, StoreError> {
        Ok(Hdf5File {
            hdf5: header::open(path, layout, filetype)?,
            bytes: fs::metadata(path).at_file(path, "look at the file")?.len(),
            path: path.into(),
        })
    }

    /// Whether a group or dataset is there.
    pub(super) fn holds(&self, path: &str) -> bool {
        has_path(&self.hdf5, path)
    }
}

/// Whether every group on the way to an object, and the object itself, is there.
pub(super) fn has_path(from: &hdf5::Group, path: &str) -> bool {
    let mut ends = path
        .match_indices('/')
        .map(|(end, _)| end)
        .filter(|end| *end > 0)
        .chain([path.len()]);
    ends.all(|end| from.link_exists(&path[..end]))
}

/// What tells the present state of a file from any other: what changes when it is written, replaced or removed.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct FileState(Option<(u64, SystemTime, u64)>);

impl FileState {
    /// The length, the time of the last change and, where the system has it, the number of the
    /// file at a path.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        let metadata = fs::metadata(path).ok();
        Self(metadata.and_then(|m| Some((m.len(), m.modified().ok()?, inode(&m)))))
    }

    /// Whether the last change is so long ago.
    pub(super) fn is_older_than(&self, age: Duration) -> bool {
        let elapsed = self.0.and_then(|(_, changed, _)| changed.elapsed().ok());
        elapsed.is_some_and(|elapsed| elapsed > age)
    }
}

#[cfg(unix)]
pub(super) fn inode(metadata: &fs::Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(metadata)
}

#[cfg(not(unix))]
pub(super) fn inode(_: &fs::Metadata) -> u64 {
    0
}

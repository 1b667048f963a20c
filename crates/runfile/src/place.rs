//! A place in a run file: turns failures of HDF5 and of the file system into errors that name it.

use std::fs::File;
use std::io;
use std::path::Path;

use hdf5_metno as hdf5;

use super::error::StoreError;

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

    /// Why HDF5 lists nothing here: the disk does not give the file back, or what it gives is damaged.
    pub(super) fn unlisted(&self, error: &hdf5::Error) -> StoreError {
        let read = File::open(self.file).and_then(|mut file| io::copy(&mut file, &mut io::sink()));
        match read {
            Ok(_) => self.damaged(format!("HDF5 cannot list its groups ({error})")),
            Err(source) => StoreError::Io {
                file: self.file.into(),
                action: "read the file",
                source,
            },
        }
    }

    /// An error unless the two digests are equal.
    pub(super) fn same_digest(&self, expected: String, found: String) -> Result<(), StoreError> {
        if expected == found {
            return Ok(());
        }
        Err(StoreError::Altered {
            file: self.file.into(),
            dataset: self.dataset.into(),
            expected,
            found,
        })
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

//! A file on its way: written under a hidden name, synced, and renamed.

use std::fs::{self, File, Permissions};
use std::io;
use std::path::{Path, PathBuf};

use hdf5_metno as hdf5;

use super::error::StoreError;
use super::header;
use super::place::{AtFile, AtPlace, Place};
use super::signals::Temporary;
use super::table::Layout;

/// An HDF5 file being written; dropping it removes it.
#[derive(Debug)]
pub(super) struct Part {
    // Declared before the temporary, so that HDF5 lets go of the file before it is removed.
    pub(super) file: hdf5::File,
    temporary: Temporary,
}

impl Part {
    /// Creates the hidden file with its root attributes.
    pub(super) fn create(
        path: PathBuf,
        layout: &Layout,
        filetype: &'static str,
    ) -> Result<Self, StoreError> {
        let (temporary, file) = Temporary::create(path, |path| {
            let file = header::create(path, layout, filetype);
            file.inspect_err(|_| drop(fs::remove_file(path)))
        })?;
        Ok(Part { file, temporary })
    }

    /// Sends what is written so far to the disk.
    pub(super) fn write_back(&self) -> Result<(), StoreError> {
        let path = self.temporary.path();
        let place = Place {
            file: path,
            dataset: "/",
        };
        self.file.flush().at(place, "flush the temporary file")?;
        let written = File::open(path).at_file(path, "open the temporary file")?;
        written.sync_data().at_file(path, "sync the temporary file")
    }

    /// Puts the file in its place, safe against loss of power once the folder is synced.
    pub(super) fn publish(
        self,
        target: &Path,
        permissions: Option<Permissions>,
    ) -> Result<(), StoreError> {
        let Part { file, temporary } = self;
        let path = temporary.path();
        let place = Place {
            file: path,
            dataset: "/",
        };
        file.close().at(place, "close the temporary file")?;
        if let Some(permissions) = permissions {
            fs::set_permissions(path, permissions).at_file(target, "keep the permissions")?;
        }
        let written = File::open(path).at_file(path, "open the temporary file")?;
        written
            .sync_all()
            .at_file(path, "sync the temporary file")?;
        temporary
            .publish(target)
            .at_file(target, "rename the temporary file")
    }
}

/// Makes renames in a folder safe against loss of power.
pub(super) fn sync_folder(folder: &Path) -> Result<(), StoreError> {
    File::open(folder)
        .and_then(|folder| folder.sync_all())
        .at_file(folder, "sync the folder")
}

/// The permissions of a file that is to be replaced, if it exists.
///
/// # Errors
/// `Io` if it is write-protected.
pub(super) fn replaceable(target: &Path) -> Result<Option<Permissions>, StoreError> {
    let permissions = match fs::metadata(target) {
        Ok(metadata) => metadata.permissions(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error).at_file(target, "look at the file"),
    };
    if permissions.readonly() {
        let refused = Err(io::Error::from(io::ErrorKind::PermissionDenied));
        return refused.at_file(target, "replace a write-protected file");
    }
    Ok(Some(permissions))
}

//! An HDF5 file that comes whole or not at all: written under a hidden name, given its digest, synced, and renamed.
//!
//! HDF5 writes a file in memory when it is closed, and closing sees every error. It writes all of it with the mark of a file that is
//! being written, and then once more the pages without the mark: if the second call is lost, the file does not open.

use std::fs::{File, Permissions};
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::{fs, io};

use hdf5_metno as hdf5;

use hdf5::file::LibraryVersion;

use crate::error::{AtFile, AtPlace, Place, StoreError};
use crate::hdf5_file::FileState;
use crate::signals::{Temporary, remove_left_overs};
use crate::user_block::USER_BLOCK_BYTES;
use crate::{header, user_block};

/// An HDF5 file being written; dropping it removes it.
#[derive(Debug)]
pub struct AtomicFile {
    /// The file, to write to. Handles made from it must be dropped before it is closed.
    // Declared before the temporary, so that HDF5 lets go of the file before it is removed.
    pub(super) file: hdf5::File,
    temporary: Temporary,
    /// The same file, for what is not HDF5's.
    handle: File,
}

/// A whole file, still under its hidden name; dropping it removes it.
#[derive(Debug)]
pub struct WrittenFile {
    temporary: Temporary,
    handle: File,
    /// With its digest.
    state: FileState,
}

impl AtomicFile {
    /// Writes a file of a format of others under a hidden name beside a place; it begins with its type all the same.
    ///
    /// # Errors
    /// Those of `write`; `Io` or `Hdf5` if the folder does not take it; `Unproven` if the disk gives back something else.
    pub fn filled<E: From<StoreError>>(
        target: &Path,
        filetype: &str,
        write: impl FnOnce(&hdf5::File) -> Result<(), E>,
    ) -> Result<WrittenFile, E> {
        remove_left_overs(target);
        let written = Self::create(target, create)?;
        write(&written.file)?;
        Ok(written.finish(target, filetype)?)
    }

    /// Takes charge of a hidden file beside a place, which `make` creates.
    pub(super) fn create(
        target: &Path,
        make: impl Fn(&Path) -> Result<hdf5::File, StoreError>,
    ) -> Result<Self, StoreError> {
        let made = Temporary::beside(target, |path| {
            make(path).map_err(|error| {
                let _ = fs::remove_file(path);
                io::Error::other(error)
            })
        });
        let (temporary, handle, file) = made.at_file(target, "make a file in its folder")?;
        Ok(Self {
            file,
            temporary,
            handle,
        })
    }

    /// Has the file written, proves that it is what was written, gives it its type and digest, and syncs it.
    ///
    /// # Errors
    /// `Hdf5` if anything could not be written; `Io` if the disk does not take it; `Unproven`, which names `target`, if the disk
    /// gives back something else.
    pub(super) fn finish(self, target: &Path, filetype: &str) -> Result<WrittenFile, StoreError> {
        let AtomicFile {
            temporary,
            file,
            mut handle,
        } = self;
        let path = temporary.path();
        file.close()
            .at(Place::new(path, "/"), "write the temporary file")?;
        header::open_any(path).map_err(|error| StoreError::Unproven {
            file: target.into(),
            reason: error.to_string(),
        })?;
        let written = user_block::write(&mut handle, filetype);
        let state = FileState::of(path);
        let synced = written.and_then(|()| handle.sync_all());
        synced.at_file(path, "sync the temporary file")?;
        Ok(WrittenFile {
            temporary,
            handle,
            state,
        })
    }
}

impl WrittenFile {
    /// Where the file lies.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.temporary.path()
    }

    /// Puts the file in its place, safe against loss of power once the folder is synced.
    ///
    /// # Errors
    /// `Io` if the permissions cannot be set or renaming fails.
    pub fn publish(
        self,
        target: &Path,
        permissions: Option<Permissions>,
    ) -> Result<(), StoreError> {
        if let Some(permissions) = permissions {
            let set = self.handle.set_permissions(permissions);
            set.at_file(target, "keep the permissions")?;
        }
        let renamed = self.temporary.publish(target);
        renamed.at_file(target, "rename the temporary file")?;
        // Its digest was made from what the disk gave back: this process need not read it all again.
        if FileState::of(target) == self.state {
            user_block::note_unaltered(self.state);
        }
        Ok(())
    }
}

/// Whether two sources give the same bytes.
pub fn is_same(one: impl Read, other: impl Read) -> io::Result<bool> {
    let (mut one, mut other) = (BufReader::new(one), BufReader::new(other));
    loop {
        let (first, second) = (one.fill_buf()?, other.fill_buf()?);
        let count = first.len().min(second.len());
        if first[..count] != second[..count] || first.is_empty() != second.is_empty() {
            return Ok(false);
        }
        if count == 0 {
            return Ok(true);
        }
        one.consume(count);
        other.consume(count);
    }
}

/// A file in memory grows by this many bytes, and changes of it are written in pages of as many.
const GROWTH_BYTES: usize = 1 << 16;

/// Creates an HDF5 file where nothing stands, readable by HDF5 1.10 and newer.
///
/// HDF5 puts it together in memory: where a disk fails under it midway, it loses datasets and crashes when it closes the file.
pub(super) fn create(path: &Path) -> Result<hdf5::File, StoreError> {
    let mut options = hdf5::File::with_options();
    let options = options
        .with_fapl(|access| {
            access
                .core_options(GROWTH_BYTES, true)
                .write_tracking(GROWTH_BYTES)
                .libver_bounds(LibraryVersion::V110, LibraryVersion::V110)
                .file_locking(false)
        })
        .with_fcpl(|creation| {
            creation
                .obj_track_times(false)
                .userblock(USER_BLOCK_BYTES as u64)
        });
    options
        .create_excl(path)
        .at(Place::new(path, "/"), "create the temporary file")
}

/// Makes renames in a folder safe against loss of power.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder).and_then(|folder| folder.sync_all())
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

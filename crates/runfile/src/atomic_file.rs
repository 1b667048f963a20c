//! An HDF5 file that comes whole or not at all: written under a hidden name, given its digest, synced, and renamed.
//!
//! HDF5 writes a file in memory when it is closed, and closing sees every error. It writes all of it twice, first with the mark of a
//! file that is being written: if the second call is lost, the file does not open.

use std::fs::{File, Permissions};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::{fs, io};

use hdf5_metno as hdf5;

use hdf5::file::LibraryVersion;

use crate::error::{AtFile, AtPlace, Place, StoreError};
use crate::signals::Temporary;
use crate::user_block::USER_BLOCK_BYTES;
use crate::{header, user_block};

/// An HDF5 file being written; dropping it removes it.
#[derive(Debug)]
pub struct AtomicFile {
    // Declared before the temporary, so that HDF5 lets go of the file before it is removed.
    file: hdf5::File,
    temporary: Temporary,
}

/// A whole file, still under its hidden name; dropping it removes it.
#[derive(Debug)]
pub struct WrittenFile(Temporary);

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
        let temporary = hidden_beside(target)?;
        let file = create(temporary.path(), Workplace::Memory)?;
        write(&file)?;
        let written = Self { file, temporary };
        Ok(written.finish(target, filetype, |path| header::open_any(path).map(drop))?)
    }

    /// Takes charge of a file that `make` creates.
    pub(super) fn create(
        path: PathBuf,
        make: impl FnOnce(&Path) -> Result<hdf5::File, StoreError>,
    ) -> Result<Self, StoreError> {
        let (temporary, file) = Temporary::create(path, |path| {
            make(path).inspect_err(|_| drop(fs::remove_file(path)))
        })?;
        Ok(Self { file, temporary })
    }

    /// The file, to write to. Handles made from it must be dropped before it is closed.
    pub(super) fn file(&self) -> &hdf5::File {
        &self.file
    }

    /// Has the file written, proves that it is what was written, gives it its type and digest, and syncs it.
    ///
    /// # Errors
    /// `Hdf5` if anything could not be written; `Io` if the disk does not take it; `Unproven`, which names `target`, if the disk
    /// gives back something else.
    pub(super) fn finish(
        self,
        target: &Path,
        filetype: &str,
        proof: impl FnOnce(&Path) -> Result<(), StoreError>,
    ) -> Result<WrittenFile, StoreError> {
        let AtomicFile { temporary, file } = self;
        let path = temporary.path();
        file.close()
            .at(Place::new(path, "/"), "write the temporary file")?;
        proof(path).map_err(|error| StoreError::Unproven {
            file: target.into(),
            reason: error.to_string(),
        })?;
        let synced = user_block::write(path, filetype).and_then(|written| written.sync_all());
        synced.at_file(path, "sync the temporary file")?;
        Ok(WrittenFile(temporary))
    }
}

impl WrittenFile {
    /// Where the file lies.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.0.path()
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
            let set = fs::set_permissions(self.path(), permissions);
            set.at_file(target, "keep the permissions")?;
        }
        let renamed = self.0.publish(target);
        renamed.at_file(target, "rename the temporary file")
    }
}

/// Makes an empty file under a hidden name for this process alone, beside the place it is for.
fn hidden_beside(target: &Path) -> Result<Temporary, StoreError> {
    let folder = target.parent().filter(|f| !f.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    let claim = |path: &Path| {
        let claimed = Temporary::create(path.into(), |path| File::create_new(path));
        claimed.map(|(temporary, _)| temporary)
    };
    let mut builder = tempfile::Builder::new();
    let builder = builder.prefix(".contact3d-pipe-").suffix(".part");
    let made = builder.make_in(folder, claim);
    let made = made.at_file(target, "make a file in its folder")?;
    // From here on it is removed by its own keeper, which knows signals.
    let (temporary, path) = made.into_parts();
    let kept = path.keep().map_err(io::Error::from);
    kept.at_file(target, "make a file in its folder")?;
    Ok(temporary)
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

/// Where HDF5 puts a file together.
#[derive(Clone, Copy, Debug)]
pub(super) enum Workplace {
    /// In memory; it is written whole, twice, when it is closed.
    Memory,
    /// On the disk, so that large values are in memory once.
    Disk,
}

/// A file in memory grows by this many bytes.
const GROWTH_BYTES: usize = 1 << 16;

/// Creates an HDF5 file, readable by HDF5 1.10 and newer.
pub(super) fn create(path: &Path, workplace: Workplace) -> Result<hdf5::File, StoreError> {
    let mut options = hdf5::File::with_options();
    let options = options
        .with_fapl(|access| {
            match workplace {
                Workplace::Memory => access.core_options(GROWTH_BYTES, true),
                Workplace::Disk => access.sec2(),
            }
            .libver_bounds(LibraryVersion::V110, LibraryVersion::V110)
        })
        .with_fcpl(|creation| {
            creation
                .obj_track_times(false)
                .userblock(USER_BLOCK_BYTES as u64)
        });
    options
        .create(path)
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

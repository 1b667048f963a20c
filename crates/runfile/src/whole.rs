//! An HDF5 file that comes whole or not at all: written under a hidden name, closed with every error seen, synced, and renamed.
//!
//! HDF5 keeps values back until a dataset is closed, and who drops a handle never hears that this failed; what is more, the
//! library then keeps a dataset that is gone and dies at the next flush of any file. So nothing is kept back:
//! [`seeing_every_error`] has values written by the call that hands them over, and metadata by a flush or the end.

use std::fs::{File, Permissions};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::{fs, io, thread};

use hdf5::plist::file_access::{
    CacheDecreaseMode, CacheIncreaseMode, FileAccessBuilder, FlashIncreaseMode, MetadataCacheConfig,
};
use hdf5_metno as hdf5;

use crate::error::{AtFile, AtPlace, Place, StoreError};
use crate::signals::Temporary;
use crate::{contents, header};

/// An HDF5 file being written; dropping it removes it.
#[derive(Debug)]
pub struct WholeFile {
    // Declared before the temporary, so that HDF5 lets go of the file before it is removed.
    file: hdf5::File,
    temporary: Temporary,
}

/// A file that the disk has taken and given back, still under its hidden name; dropping it removes it.
#[derive(Debug)]
pub struct WrittenFile(Temporary);

impl WholeFile {
    /// Writes a file under a hidden name beside a place, and reads it back.
    ///
    /// `write` is called twice, for a file in memory and for that on the disk, which has to hold the same in the end.
    ///
    /// # Errors
    /// Those of `write`; `Io` or `Hdf5` if the folder does not take it; `Unproven` if the disk gives back something else.
    pub fn filled<E: From<StoreError>>(
        target: &Path,
        write: impl Fn(&hdf5::File) -> Result<(), E>,
    ) -> Result<WrittenFile, E> {
        let temporary = hidden_beside(target)?;
        let path = temporary.path();
        let in_memory = create(path, |access| access.core_filebacked(false))?;
        write(&in_memory)?;
        let expected = contents::of(&in_memory, Place::new(path, "/"), u64::MAX)?;
        drop(in_memory);
        let file = create(path, seeing_every_error)?;
        write(&file)?;
        Self { file, temporary }.finish(|path| {
            let file = header::open_written(path)?;
            let bytes = fs::metadata(path).at_file(path, "look at the file")?.len();
            let found = contents::of(&file, Place::new(path, "/"), bytes)?;
            let objects = expected.keys().chain(found.keys());
            let mut different = objects.filter(|name| expected.get(*name) != found.get(*name));
            match different.next() {
                None => Ok(()),
                Some(name) => Err(StoreError::Unproven {
                    file: target.into(),
                    reason: format!("{name} is different"),
                }
                .into()),
            }
        })
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

    /// Ends writing, and reads the file back by `proof`, an error unless it holds what it should, while the disk takes it.
    ///
    /// # Errors
    /// `Hdf5` if anything could not be written; `Io` if the disk does not take it; those of `proof`.
    pub(super) fn finish<E: From<StoreError>>(
        self,
        proof: impl FnOnce(&Path) -> Result<(), E>,
    ) -> Result<WrittenFile, E> {
        let WholeFile { temporary, file } = self;
        let path = temporary.path();
        let place = Place::new(path, "/");
        file.flush().at(place, "flush the temporary file")?;
        file.close().at(place, "close the temporary file")?;
        let sync = || {
            let synced = File::open(path).and_then(|written| written.sync_all());
            synced.at_file(path, "sync the temporary file")
        };
        thread::scope(|scope| {
            let syncing = thread::Builder::new().spawn_scoped(scope, sync);
            proof(path)?;
            let synced = match syncing {
                Ok(syncing) => syncing
                    .join()
                    .unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
                // The system has no thread for it.
                Err(_) => sync(),
            };
            Ok::<(), E>(synced?)
        })?;
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

/// Creates an HDF5 file.
pub(super) fn create(
    path: &Path,
    access: impl Fn(&mut FileAccessBuilder) -> &mut FileAccessBuilder,
) -> Result<hdf5::File, StoreError> {
    let mut options = hdf5::File::with_options();
    let options = options
        .with_fapl(access)
        .with_fcpl(|creation| creation.obj_track_times(false));
    options
        .create(path)
        .at(Place::new(path, "/"), "create the temporary file")
}

/// Has every value written by the call that hands it over: no sieve buffer, no cache of chunks, and metadata that leave their
/// cache only when they are flushed. Writers hand over whole chunks.
pub(super) fn seeing_every_error(access: &mut FileAccessBuilder) -> &mut FileAccessBuilder {
    let metadata = MetadataCacheConfig {
        evictions_enabled: false,
        incr_mode: CacheIncreaseMode::Off,
        flash_incr_mode: FlashIncreaseMode::Off,
        decr_mode: CacheDecreaseMode::Off,
        ..MetadataCacheConfig::default()
    };
    // The lock of HDF5 would outlive its owner in a process that is started meanwhile and inherits the file.
    access
        .sec2()
        .file_locking(false)
        .sieve_buf_size(0)
        .chunk_cache(1, 0, 1.0)
        .mdc_config(&metadata)
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

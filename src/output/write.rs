//! Files that belong together, written whole or not at all.

use std::{
    fs::{self, File, TryLockError},
    io::{self, Write},
    path::{Path, PathBuf},
};

use runfile::{Temporary, is_same};

use super::{
    Inputs, OutputError, OutputKind,
    guard::{Destination, place},
};

/// A file to be written.
#[derive(Debug, Clone)]
pub struct OutputFile {
    /// Where.
    pub path: PathBuf,
    /// As what.
    pub kind: OutputKind,
    /// What.
    pub bytes: Vec<u8>,
}

/// Writes files that belong together: all are admitted before one is changed, and all are written
/// beside their places, synced and read back before the first is renamed, so that none is ever cut off.
///
/// # Errors
/// As [`super::admit`]; [`OutputError::Io`] if writing fails.
pub fn write(files: &[OutputFile], inputs: &Inputs) -> Result<(), OutputError> {
    let places = files
        .iter()
        .map(|file| place(&file.path, file.kind, inputs));
    let places = places.collect::<Result<Vec<Destination>, OutputError>>()?;
    let mut written = Vec::new();
    for (file, place) in files.iter().zip(places) {
        let failed = |source| OutputError::Io {
            file: file.path.clone(),
            action: "write the file",
            source,
        };
        match place {
            Destination::Stream(stream) => {
                let opened = File::options().write(true).open(stream);
                let wrote = opened.and_then(|mut stream| stream.write_all(&file.bytes));
                wrote.map_err(failed)?;
            }
            Destination::File(target, permissions) => {
                let hidden = HiddenFile::write(target, file, permissions);
                written.push(hidden.map_err(failed)?);
            }
        }
    }
    written.into_iter().try_for_each(HiddenFile::publish)
}

/// A file written under a hidden name beside its place.
struct HiddenFile {
    target: PathBuf,
    temporary: Temporary,
    // Its lock keeps another process from writing to the same name.
    _file: File,
}

impl HiddenFile {
    fn write(
        target: PathBuf,
        file: &OutputFile,
        permissions: Option<fs::Permissions>,
    ) -> io::Result<Self> {
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        let path = target.with_file_name(format!(".{name}.part"));
        let (temporary, mut part) = create(&path)?;
        part.write_all(&file.bytes)?;
        part.sync_all()?;
        if !is_same(File::open(&path)?, &file.bytes[..])? {
            let what = "the disk gives back something else than was written";
            return Err(io::Error::other(what));
        }
        if let Some(permissions) = permissions {
            part.set_permissions(permissions)?;
        }
        Ok(Self {
            target,
            temporary,
            _file: part,
        })
    }

    fn publish(self) -> Result<(), OutputError> {
        let published = self.temporary.publish(&self.target);
        published.map_err(|source| OutputError::Io {
            file: self.target,
            action: "write the file",
            source,
        })
    }
}

/// Creates a hidden file for this process alone, whatever a killed process left there.
fn create(path: &Path) -> io::Result<(Temporary, File)> {
    loop {
        let file = match Temporary::create(path.into(), open) {
            Ok(created) => return Ok(created),
            Err(NotOurs::Locked(file)) => file,
            Err(NotOurs::Failed(error)) => return Err(error),
        };
        // Another process writes there: wait until it has renamed the file.
        file.lock()?;
    }
}

/// Why a hidden file could not be opened for this process alone.
enum NotOurs {
    Locked(File),
    Failed(io::Error),
}

impl From<io::Error> for NotOurs {
    fn from(error: io::Error) -> Self {
        NotOurs::Failed(error)
    }
}

fn open(path: &Path) -> Result<File, NotOurs> {
    loop {
        if path.is_symlink() {
            fs::remove_file(path)?;
        }
        let file = File::options()
            .create(true)
            .truncate(false)
            .write(true)
            .open(path)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => return Err(NotOurs::Locked(file)),
            // Where the file system knows no locks, the last one to rename wins.
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        if is_still_at(&file, path) {
            file.set_len(0)?;
            return Ok(file);
        }
    }
}

/// Whether nobody renamed or removed an open file.
#[cfg(unix)]
pub(super) fn is_still_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let number = |metadata: io::Result<fs::Metadata>| metadata.ok().map(|m| (m.dev(), m.ino()));
    number(file.metadata()) == number(fs::symlink_metadata(path))
}

#[cfg(not(unix))]
pub(super) fn is_still_at(_: &File, path: &Path) -> bool {
    path.exists()
}

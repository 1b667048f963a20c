//! Files in folders that others may write to: links are not followed and pipes not opened; locks, and file systems without them.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::time::Duration;
use std::{env, io, thread};

use crate::error::{AtFile, StoreError};

/// Opens a regular file; a symbolic link, a pipe or a device in its place is an error.
pub fn open_plain(path: &Path, options: &mut OpenOptions) -> io::Result<File> {
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(options, libc::O_NOFOLLOW | libc::O_NONBLOCK);
    let is_other = |metadata: fs::Metadata| !metadata.is_file();
    let opened = options.open(path);
    if fs::symlink_metadata(path).is_ok_and(is_other) {
        let what = "expected a regular file, found a link, pipe, device or folder";
        return Err(io::Error::other(what));
    }
    opened
}

/// Opens a terminal, a device or a pipe for writing; a pipe that nobody reads is an error, since opening it would wait without end.
pub fn open_stream(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    options.write(true);
    #[cfg(unix)]
    let _reader = {
        let mut at_once = options.clone();
        std::os::unix::fs::OpenOptionsExt::custom_flags(&mut at_once, libc::O_NONBLOCK);
        at_once
            .open(path)
            .map_err(|error| match error.raw_os_error() {
                Some(libc::ENXIO) => io::Error::other("nobody reads the pipe"),
                _ => error,
            })?
    };
    options.open(path)
}

/// Where a symbolic link leads. Only links of the file's owner and of the system are followed: others could plant them.
pub fn follow_link(path: &Path) -> io::Result<PathBuf> {
    let target = path.canonicalize()?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let [link, file] = [fs::symlink_metadata(path)?, fs::metadata(&target)?];
        if link.uid() != file.uid() && link.uid() != 0 {
            let what = "the link belongs to another user than the file, give the path of the file";
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, what));
        }
    }
    Ok(target)
}

/// Whether nobody renamed or removed an open file.
#[cfg(unix)]
#[must_use]
pub fn is_still_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let number = |metadata: io::Result<fs::Metadata>| metadata.ok().map(|m| (m.dev(), m.ino()));
    number(file.metadata()) == number(fs::symlink_metadata(path))
}

#[cfg(not(unix))]
#[must_use]
pub fn is_still_at(_: &File, path: &Path) -> bool {
    path.exists()
}

/// The variable by which users of HDF5 say that a file system has no locks.
const LOCKING: &str = "HDF5_USE_FILE_LOCKING";

/// Creates a lock file and locks it, by [`File::try_lock`] for example; `None` if another process has it.
///
/// # Errors
/// `Io` if it cannot be opened, or something else than a file stands there; `NoLocks` if the file system has no locks and the
/// environment does not say to go on without.
pub fn lock_file(
    path: &Path,
    lock: impl Fn(&File) -> Result<(), TryLockError>,
) -> Result<Option<File>, StoreError> {
    let mut is_again = false;
    loop {
        let mut options = File::options();
        options.create(true).truncate(false).write(true);
        let file = open_plain(path, &mut options).at_file(path, "open the lock file")?;
        match lock(&file) {
            // Its owner may have removed it since it was opened.
            Ok(()) if !is_still_at(&file, path) => {}
            Ok(()) => return Ok(Some(file)),
            // Who only asks whether it is locked has it for a moment.
            Err(TryLockError::WouldBlock) if !is_again => {
                is_again = true;
                thread::sleep(Duration::from_millis(10));
            }
            Err(TryLockError::WouldBlock) => return Ok(None),
            Err(TryLockError::Error(source)) if is_unsupported(&source) => {
                return match env::var(LOCKING).as_deref() {
                    Ok("FALSE" | "0" | "BEST_EFFORT") => Ok(Some(file)),
                    _ => Err(StoreError::NoLocks {
                        lock: path.into(),
                        source,
                    }),
                };
            }
            Err(TryLockError::Error(source)) => Err(source).at_file(path, "lock the lock file")?,
        }
    }
}

/// Whether another process has a lock file locked for itself; false where there is none.
#[must_use]
pub fn is_locked(path: &Path) -> bool {
    let file = open_plain(path, File::options().read(true));
    file.is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

#[cfg(unix)]
fn is_unsupported(error: &io::Error) -> bool {
    let numbers = [libc::ENOLCK, libc::ENOSYS, libc::EOPNOTSUPP];
    error
        .raw_os_error()
        .is_some_and(|number| numbers.contains(&number))
}

#[cfg(not(unix))]
fn is_unsupported(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::Unsupported
}

//! Temporary files: removed when dropped, and before the process dies of SIGINT or SIGTERM.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::{File, TryLockError};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::{fs, io, thread};

use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;
use signal_hook::low_level::emulate_default_handler;

use crate::layout::Group;
use crate::plain_file::{is_still_at, open_plain};

/// The temporaries of this process. Whoever holds the lock decides alone: a rename, or the end of
/// the process.
static TEMPORARIES: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Whether the thread that waits for signals runs.
static INSTALLED: Mutex<bool> = Mutex::new(false);

/// The file that this process changed last, with the groups it holds since.
static LAST_COMMIT: Mutex<Option<(PathBuf, Vec<Group>)>> = Mutex::new(None);

/// The file that this process changed last, with the groups it holds since; `None` before the first
/// commit.
#[must_use]
pub fn last_commit() -> Option<(PathBuf, Vec<Group>)> {
    let last = LAST_COMMIT.lock().unwrap_or_else(PoisonError::into_inner);
    last.clone()
}

pub(super) fn note_commit(target: &Path, groups: Vec<Group>) {
    let mut last = LAST_COMMIT.lock().unwrap_or_else(PoisonError::into_inner);
    *last = Some((target.to_path_buf(), groups));
}

/// Starts the thread that removes the temporaries on SIGINT or SIGTERM, calls `on_exit`, and lets
/// the signal end the process.
///
/// A rename that has begun is completed first. A file that reaches the largest size allowed (SIGXFSZ) is an error of the
/// write from then on, and no longer the end of the process. Calling it again does nothing.
pub fn install(on_exit: fn()) -> io::Result<()> {
    let mut installed = INSTALLED.lock().unwrap_or_else(PoisonError::into_inner);
    if !*installed {
        let mut signals = Signals::new([SIGINT, SIGTERM, SIGXFSZ])?;
        thread::Builder::new()
            .name("signals".into())
            .spawn(move || {
                for signal in signals.forever().filter(|signal| *signal != SIGXFSZ) {
                    let temporaries = temporaries();
                    for temporary in temporaries.iter() {
                        let _ = fs::remove_file(temporary);
                    }
                    on_exit();
                    let _ = emulate_default_handler(signal);
                }
            })?;
        *installed = true;
    }
    Ok(())
}

/// A temporary file that vanishes unless it is published.
#[derive(Debug)]
pub struct Temporary {
    path: PathBuf,
    /// A file of its own, with a shared lock where the file system has locks: whoever removes left-overs wants it alone, and a
    /// reader that locks what it reads, as h5py does, is let in as soon as the file is in its place. `None` for a second name of
    /// another file.
    file: Option<File>,
}

/// The hidden files for a place begin with this; a dash and a random number follow.
pub(super) fn hidden_prefix(target: &Path) -> OsString {
    let mut prefix = OsString::from(".");
    prefix.push(target.file_name().unwrap_or_default());
    prefix.push(".part");
    prefix
}

/// The hidden files for a place.
pub(super) fn left_overs(target: &Path) -> impl Iterator<Item = PathBuf> {
    let prefix = hidden_prefix(target);
    let folder = target.parent().filter(|f| !f.as_os_str().is_empty());
    let entries = fs::read_dir(folder.unwrap_or(Path::new("."))).into_iter();
    // The random number has no dots, unlike what belongs to other files.
    let is_hidden = move |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        let rest = name.strip_prefix(prefix.as_encoded_bytes());
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(b"-") && !rest.contains(&b'.'))
    };
    let paths = entries.flatten().flatten().map(|entry| entry.path());
    paths.filter(is_hidden)
}

/// Removes what killed processes left of a file: hidden files for it that nobody has locked.
pub fn remove_left_overs(target: &Path) {
    for path in left_overs(target) {
        let opened = open_plain(&path, File::options().read(true).write(true));
        if opened.is_ok_and(|file| file.try_lock().is_ok() && is_still_at(&file, &path)) {
            let _ = fs::remove_file(path);
        }
    }
}

impl Temporary {
    /// Takes charge of a new file beside the place it is for, which `create` makes where nothing stands, with a handle of it; a signal
    /// acts either before or after. Nobody can guess its name, `.NAME.part-RANDOM`, and put something else there.
    ///
    /// # Errors
    /// Those of `create`, which has to leave nothing behind then, and of opening the file.
    pub fn beside<T>(
        target: &Path,
        create: impl Fn(&Path) -> io::Result<T>,
    ) -> io::Result<(Self, File, T)> {
        let mut temporaries = temporaries();
        loop {
            let mut name = hidden_prefix(target);
            let random = RandomState::new().build_hasher().finish();
            name.push(format!("-{:08x}", random as u32));
            let path = target.with_file_name(name);
            let created = create(&path)?;
            let opened = open_plain(&path, File::options().read(true).write(true));
            let file = opened.inspect_err(|_| drop(fs::remove_file(&path)))?;
            // Another process may take it for a left-over before it is locked.
            let is_taken = matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock));
            if !is_taken && is_still_at(&file, &path) {
                temporaries.insert(path.clone());
                let handle = file.try_clone()?;
                let file = Some(file);
                return Ok((Temporary { path, file }, handle, created));
            }
        }
    }

    /// Takes charge of a second name of a file, which `create` makes; a signal acts either before or after.
    ///
    /// # Errors
    /// Those of `create`, which has to leave nothing behind then.
    pub fn create<T, E>(
        path: PathBuf,
        create: impl FnOnce(&Path) -> Result<T, E>,
    ) -> Result<(Self, T), E> {
        let mut temporaries = temporaries();
        let created = create(&path)?;
        temporaries.insert(path.clone());
        Ok((Temporary { path, file: None }, created))
    }

    /// Where the temporary file lies.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Renames the file; a signal acts either before or after.
    ///
    /// # Errors
    /// Those of renaming, and if another program has put something else in the place of the file.
    pub fn publish(&self, target: &Path) -> io::Result<()> {
        let mut temporaries = temporaries();
        let is_ours = |file: &File| is_still_at(file, &self.path);
        if !self.file.as_ref().is_none_or(is_ours) {
            return Err(io::Error::other(
                "another program replaced the temporary file",
            ));
        }
        fs::rename(&self.path, target)?;
        // Two names of one file are left as they are by a rename.
        let _ = fs::remove_file(&self.path);
        temporaries.remove(&self.path);
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let mut temporaries = temporaries();
        if temporaries.remove(&self.path) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

fn temporaries() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    TEMPORARIES.lock().unwrap_or_else(PoisonError::into_inner)
}

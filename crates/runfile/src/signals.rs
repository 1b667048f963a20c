//! Temporary files: removed when dropped, and before the process dies of SIGINT or SIGTERM.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::{fs, io, thread};

use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;
use signal_hook::low_level::emulate_default_handler;

use crate::layout::Group;

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
}

impl Temporary {
    /// Takes charge of a file that `create` makes at the path; a signal acts either before or after.
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
        Ok((Temporary { path }, created))
    }

    /// Where the temporary file lies.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Renames the file; a signal acts either before or after.
    pub fn publish(&self, target: &Path) -> io::Result<()> {
        let mut temporaries = temporaries();
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

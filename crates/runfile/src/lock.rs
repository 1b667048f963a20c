//! The lock of a run file, one writing process at a time; and the state before a command that stores in several steps.

use std::ffi::OsString;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::{fs, io};

use units::Units;

use crate::atomic_file::sync_folder;
use crate::error::{AtFile, StoreError};
use crate::external::linked_names;
use crate::layout::Layout;
use crate::plain_file::{follow_link, is_locked, lock_file};
use crate::reader::Reader;
use crate::signals::{Temporary, left_overs};

/// What to do about a run file that does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IfMissing {
    /// Start a new file.
    Create,
    /// Refuse.
    Refuse,
}

/// A run file this process alone may replace; given free when dropped.
///
/// The lock is on a hidden file `.NAME.lock` beside the run file, because every commit replaces the
/// run file itself.
#[derive(Debug)]
pub struct RunFile {
    pub(super) path: PathBuf,
    pub(super) folder: PathBuf,
    name: OsString,
    pub(super) layout: Layout,
    lock: File,
}

impl RunFile {
    /// Locks a run file and removes what a killed process left beside it, and what only that linked.
    ///
    /// # Errors
    /// `Busy` if another process has it; `IsDirectory`, `FolderMissing`, `NotFound`, or the errors
    /// of [`Reader::open`] for a file that is not ours, with nothing changed on disk.
    pub fn lock(path: &Path, layout: Layout, if_missing: IfMissing) -> Result<Self, StoreError> {
        let (folder, name) = locate(path)?;
        let path = folder.join(&name);
        match if_missing {
            IfMissing::Create => drop(Reader::open_if_there(&path, layout)?),
            IfMissing::Refuse => drop(Reader::open(&path, layout)?),
        }
        let lock = hidden(&folder, &name, ".lock");
        if fs::symlink_metadata(&lock).is_ok_and(|metadata| !metadata.is_file()) {
            return Err(StoreError::NotAFile { file: lock });
        }
        let Some(file) = lock_file(&lock, File::try_lock)? else {
            return Err(StoreError::Busy { file: path, lock });
        };
        let run_file = RunFile {
            path,
            folder,
            name,
            layout,
            lock: file,
        };
        run_file.remove_left_overs()?;
        Ok(run_file)
    }

    /// Whether another process has a run file locked; asks, and locks nothing.
    #[must_use]
    pub fn is_busy(path: &Path) -> bool {
        locate(path).is_ok_and(|(folder, name)| is_locked(&hidden(&folder, &name, ".lock")))
    }

    fn remove_left_overs(&self) -> Result<(), StoreError> {
        // Without locks another process may be at work on them.
        if self.lock.try_lock().is_err() {
            return Ok(());
        }
        let mut named = Vec::new();
        for temporary in left_overs(&self.path).chain([self.previous()]) {
            named.extend(linked_names(&temporary, &self.layout).unwrap_or_default());
            remove_if_there(&temporary, "remove what a killed process left")?;
        }
        self.remove_unlinked(named);
        Ok(())
    }

    /// The file for writing numbers in other units from now on.
    #[must_use]
    pub fn in_units(mut self, units: Units) -> Self {
        self.layout = self.layout.in_units(units);
        self
    }

    /// Where the state before a command is kept.
    pub(super) fn previous(&self) -> PathBuf {
        hidden(&self.folder, &self.name, ".previous")
    }

    /// The path of the run file, symbolic links resolved.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

fn remove_if_there(path: &Path, action: &'static str) -> Result<(), StoreError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        removed => removed.at_file(path, action),
    }
}

impl Drop for RunFile {
    /// Unlocks at once, even while a process just forked still has a copy of the descriptor. Where
    /// no run file came to be, nothing is left of the lock either.
    fn drop(&mut self) {
        if !self.path.exists() {
            let _ = fs::remove_file(hidden(&self.folder, &self.name, ".lock"));
        }
        let _ = self.lock.unlock();
    }
}

/// The true folder and the name of a run file; a symbolic link to a file leads to the file.
fn locate(path: &Path) -> Result<(PathBuf, OsString), StoreError> {
    if path.is_dir() {
        return Err(StoreError::IsDirectory { file: path.into() });
    }
    let path = if path.is_symlink() {
        follow_link(path).at_file(path, "follow the symbolic link")?
    } else {
        path.to_path_buf()
    };
    let name = path
        .file_name()
        .ok_or_else(|| StoreError::IsDirectory { file: path.clone() })?;
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    match folder.canonicalize() {
        Ok(folder) => Ok((folder, name.into())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Err(StoreError::FolderMissing {
            file: path.clone(),
            folder: folder.into(),
        }),
        Err(error) => Err(error).at_file(folder, "find the folder"),
    }
}

fn hidden(folder: &Path, name: &OsString, suffix: &str) -> PathBuf {
    let mut hidden = OsString::from(".");
    hidden.push(name);
    hidden.push(suffix);
    folder.join(hidden)
}

/// An earlier state of a run file, in the hidden file `.NAME.previous`; dropping it gives that
/// state up.
///
/// It is a second name of the earlier file, so keeping it copies nothing, and the files that it
/// links stay.
#[derive(Debug)]
pub struct Savepoint {
    /// `None` if there was no file.
    earlier: Option<Temporary>,
    target: PathBuf,
    folder: PathBuf,
}

impl RunFile {
    /// Keeps the present state.
    ///
    /// # Errors
    /// `Io` if the folder does not take another file.
    pub fn savepoint(&self) -> Result<Savepoint, StoreError> {
        // A second name of the run file that another process left would be written through by a copy.
        remove_if_there(&self.previous(), "remove an earlier state")?;
        let link = |path: &Path| fs::hard_link(&self.path, path);
        let earlier = match Temporary::create(self.previous(), link) {
            Ok((earlier, ())) => Some(earlier),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            // Not every file system has hard links.
            Err(_) => {
                let copied = self.copy();
                Some(copied.at_file(&self.path, "keep the state before the command")?)
            }
        };
        Ok(Savepoint {
            earlier,
            target: self.path.clone(),
            folder: self.folder.clone(),
        })
    }

    fn copy(&self) -> io::Result<Temporary> {
        let mut present = File::open(&self.path)?;
        let (earlier, mut copy) =
            Temporary::create(self.previous(), |path| File::create_new(path))?;
        io::copy(&mut present, &mut copy)?;
        copy.set_permissions(present.metadata()?.permissions())?;
        Ok(earlier)
    }
}

impl Savepoint {
    /// Puts the earlier state back, or no file where there was none.
    ///
    /// # Errors
    /// `Io` if renaming or removing fails.
    pub fn restore(self) -> Result<(), StoreError> {
        match self.earlier {
            Some(earlier) => earlier.publish(&self.target),
            None => fs::remove_file(&self.target),
        }
        .at_file(&self.target, "put the earlier state back")?;
        sync_folder(&self.folder).at_file(&self.folder, "sync the folder")
    }
}

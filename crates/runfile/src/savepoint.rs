//! The state of a run file before a command that stores in several steps, put back if the command
//! is refused.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use super::error::StoreError;
use super::lock::RunFile;
use super::place::AtFile;
use super::signals::Temporary;
use super::volume::Stamp;
use super::whole::sync_folder;

/// What tells the present state of a run file from any other.
#[derive(Debug, PartialEq, Eq)]
pub struct FileState(Stamp);

impl FileState {
    /// The state of any file.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        Self(Stamp::of(path))
    }
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
        match fs::remove_file(self.previous()) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(error).at_file(&self.previous(), "remove an earlier state")?;
            }
            _ => {}
        }
        let link = |path: &Path| fs::hard_link(&self.path, path);
        let earlier = match Temporary::create(self.previous(), link) {
            Ok((earlier, ())) => Some(earlier),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            // Not every file system has hard links.
            Err(_) => Some(
                self.copy()
                    .at_file(&self.path, "keep the state before the command")?,
            ),
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

    /// The state the file is in now.
    #[must_use]
    pub fn state(&self) -> FileState {
        FileState(Stamp::of(&self.path))
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

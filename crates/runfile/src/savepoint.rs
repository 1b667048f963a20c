//! The state of a run file before a command that stores in several steps, put back if the command
//! is refused.

use std::fs;
use std::io;
use std::path::PathBuf;

use super::error::StoreError;
use super::home::remove_orphans;
use super::lock::RunFile;
use super::part::sync_folder;
use super::place::AtFile;
use super::signals::Temporary;
use super::table::Layout;
use super::volume::Stamp;

/// What tells the present state of a run file from any other.
#[derive(Debug, PartialEq, Eq)]
pub struct FileState(Stamp);

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
    layout: Layout,
}

impl RunFile {
    /// Keeps the present state.
    ///
    /// # Errors
    /// `Io` if the folder does not take another file.
    pub fn savepoint(&self) -> Result<Savepoint, StoreError> {
        let path = self.previous();
        let earlier = match fs::hard_link(&self.path, &path) {
            Ok(()) => Some(Temporary::new(path)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            // Not every file system has hard links.
            Err(_) => {
                let temporary = Temporary::new(path);
                fs::copy(&self.path, temporary.path())
                    .at_file(temporary.path(), "keep the state before the command")?;
                Some(temporary)
            }
        };
        Ok(Savepoint {
            earlier,
            target: self.path.clone(),
            folder: self.folder.clone(),
            layout: self.layout,
        })
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
    pub fn restore(mut self) -> Result<(), StoreError> {
        match self.earlier.take() {
            // Two names of one file are not renamed, so the hidden one is removed by itself.
            Some(earlier) => earlier.publish(&self.target).map(|()| {
                let _ = fs::remove_file(earlier.path());
            }),
            None => fs::remove_file(&self.target),
        }
        .at_file(&self.target, "put the earlier state back")?;
        sync_folder(&self.folder)
    }
}

impl Drop for Savepoint {
    /// The files that only the other state names are removed too.
    fn drop(&mut self) {
        drop(self.earlier.take());
        remove_orphans(&self.folder, &self.target, &self.layout);
    }
}

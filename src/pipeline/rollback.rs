//! All or nothing: a command that is refused midway leaves its run file as it found it.

use runfile::{FileState, Group, RunFile, Savepoint, StoreError};

use super::{Session, StageError};

/// What a session could put back.
#[derive(Debug, Default)]
pub(super) enum Rollback {
    /// Every commit is for good.
    #[default]
    Off,
    /// The state before the first commit will be kept.
    Armed,
    /// There were commits.
    Kept {
        savepoint: Box<Savepoint>,
        /// The file as the last commit left it; none before the first.
        last: Option<FileState>,
        stored: Vec<Group>,
    },
}

impl Rollback {
    /// Keeps the state of the file before the first commit of a command.
    pub(super) fn before_commit(&mut self, file: &RunFile) -> Result<(), StoreError> {
        match self {
            Self::Off | Self::Kept { .. } => {}
            Self::Armed => {
                *self = Self::Kept {
                    savepoint: Box::new(file.savepoint()?),
                    last: None,
                    stored: Vec::new(),
                };
            }
        }
        Ok(())
    }

    /// Notes what a commit stored.
    pub(super) fn after_commit(&mut self, file: &RunFile, changed: &[Group]) {
        match self {
            Self::Off | Self::Armed => {}
            Self::Kept { last, stored, .. } => {
                *last = Some(file.state());
                stored.extend(changed);
            }
        }
    }
}

impl Session {
    /// Does work that may store in several steps. If it is refused, the run file is as before; if
    /// the machine fails midway, for example because the disk is full, the stages stored by then
    /// stay and the error says so.
    ///
    /// # Errors
    /// Those of the work; [`StageError::Partly`] if something was stored.
    pub fn all_or_nothing<T>(
        &mut self,
        work: impl FnOnce(&mut Self) -> Result<T, StageError>,
    ) -> Result<T, StageError> {
        self.store.rollback = Rollback::Armed;
        self.store.linked = self.store.file.linked_names();
        let outcome = work(self);
        let linked = std::mem::take(&mut self.store.linked);
        let outcome = self.settled(outcome);
        self.store.file.remove_unlinked(linked);
        outcome
    }

    /// Keeps what the command stored, or puts the earlier state back.
    fn settled<T>(&mut self, outcome: Result<T, StageError>) -> Result<T, StageError> {
        let rollback = std::mem::take(&mut self.store.rollback);
        let error = match outcome {
            Ok(done) => return Ok(done),
            Err(error) => error,
        };
        match rollback {
            Rollback::Off | Rollback::Armed => Err(error),
            Rollback::Kept { stored, .. } if error.is_of_machine() && !stored.is_empty() => {
                Err(StageError::Partly {
                    stored,
                    source: Box::new(error),
                })
            }
            Rollback::Kept {
                savepoint, last, ..
            } => {
                let is_ours = last.is_some_and(|last| last == self.store.file.state());
                if is_ours && !error.is_internal() {
                    savepoint.restore()?;
                }
                Err(error)
            }
        }
    }
}

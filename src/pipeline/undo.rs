//! All or nothing: a command that is refused midway leaves its run file as it found it.

use std::cell::RefCell;

use runfile::{FileState, Group, Savepoint, StoreError, Transaction};

use super::{Session, StageError};

/// What a session could put back.
#[derive(Debug, Default)]
pub(super) struct Undo(RefCell<State>);

#[derive(Debug, Default)]
enum State {
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
        self.undo.0.replace(State::Armed);
        let outcome = work(self);
        let state = self.undo.0.replace(State::Off);
        match (outcome, state) {
            (
                Err(error),
                State::Kept {
                    savepoint,
                    last,
                    stored,
                },
            ) => {
                let ours = last.is_some_and(|last| last == self.file.state());
                if error.is_of_machine() && !stored.is_empty() {
                    return Err(StageError::Partly {
                        stored,
                        source: Box::new(error),
                    });
                }
                if ours && !error.is_internal() {
                    savepoint.restore()?;
                }
                Err(error)
            }
            (outcome, _) => outcome,
        }
    }

    /// Begins a change of the run file.
    pub(super) fn begin(&self) -> Result<Transaction, StoreError> {
        Transaction::begin(&self.file)
    }

    /// Ends a change of the run file, which stored some groups.
    pub(super) fn commit_change(
        &self,
        transaction: Transaction,
        changed: &[Group],
    ) -> Result<(), StoreError> {
        let mut undo = self.undo.0.borrow_mut();
        if matches!(*undo, State::Armed) {
            *undo = State::Kept {
                savepoint: Box::new(self.file.savepoint()?),
                last: None,
                stored: Vec::new(),
            };
        }
        transaction.commit()?;
        if let State::Kept { last, stored, .. } = &mut *undo {
            *last = Some(self.file.state());
            stored.extend(changed);
        }
        Ok(())
    }
}

//! What waits to be stored is written while the next stage computes.

use std::{
    sync::Arc,
    thread::{self, JoinHandle},
    time::Instant,
};

use runfile::{Group, StoreError};

use super::change::{Change, Pending};

/// A change of the run file that a thread of its own writes.
///
/// It builds on the run file as it was: nobody else changes that before the thread has ended. Dropping it waits for the thread
/// and gives up what is not stored for good.
#[derive(Debug)]
pub(super) struct Ahead {
    thread: Option<JoinHandle<Result<Written, StoreError>>>,
    /// Stages that it stores for good.
    commits: usize,
}

/// What becomes of a change once its stages are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Then {
    /// It waits for those of the next stage.
    Wait,
    /// It is stored for good.
    Commit,
}

/// What a thread has written.
#[derive(Debug)]
pub(super) enum Written {
    Begun(Box<Change>),
    Committed {
        changed: Vec<Group>,
        seconds: f64,
        /// What became of it: stored, whatever it says.
        committed: Result<(), StoreError>,
    },
}

impl Ahead {
    /// Starts to write stages; `None` where the system has no thread for it.
    pub(super) fn new(change: Change, stages: Vec<Arc<Pending>>, then: Then) -> Option<Self> {
        let commits = match then {
            Then::Wait => 0,
            Then::Commit => stages.len(),
        };
        let thread = thread::Builder::new()
            .name("store".into())
            .spawn(move || written(change, &stages, then));
        Some(Self {
            thread: Some(thread.ok()?),
            commits,
        })
    }

    /// Stages that will be stored for good.
    pub(super) fn commits(&self) -> usize {
        self.commits
    }

    /// Waits for the end of the thread.
    ///
    /// # Errors
    /// What writing met.
    pub(super) fn join(mut self) -> Result<Written, StoreError> {
        let thread = self.thread.take().expect("joined once");
        thread
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

impl Drop for Ahead {
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn written(mut change: Change, stages: &[Arc<Pending>], then: Then) -> Result<Written, StoreError> {
    let started = Instant::now();
    for stage in stages {
        change.write(stage)?;
    }
    match then {
        Then::Wait => {
            change.write_back()?;
            Ok(Written::Begun(Box::new(change)))
        }
        Then::Commit => {
            let (transaction, changed) = change.into_parts();
            match transaction.commit() {
                Err(error) if !error.is_after_storing() => Err(error),
                committed => Ok(Written::Committed {
                    changed,
                    seconds: started.elapsed().as_secs_f64(),
                    committed,
                }),
            }
        }
    }
}

//! Saving successive approximations between two steps, and going on from there.

use std::time::{Duration, Instant};

use contact3d::solver::OuterState;
use runfile::{StoreError, StoredGroup};

use super::{Session, StageError, freshness::input_digest};
use crate::format::{self, Stage};

/// At most one part in so many of a solve's time goes into checkpoints.
const SHARE: f64 = 20.0;

/// The checkpoints of one solve.
pub(super) struct Checkpoints<'a> {
    session: &'a Session,
    last: Instant,
    /// What writing one takes.
    cost: f64,
}

impl<'a> Checkpoints<'a> {
    pub(super) fn new(session: &'a Session) -> Self {
        Self {
            session,
            last: Instant::now(),
            cost: session.last_store_seconds,
        }
    }

    /// Stores the state if it is worth the time. A checkpoint that cannot be written is no reason
    /// to give up a solve: storing the solution will say what is wrong.
    pub(super) fn keep(&mut self, state: &OuterState) {
        if self.last.elapsed() < Duration::from_secs_f64(SHARE * self.cost) {
            return;
        }
        let started = Instant::now();
        let _ = self.session.write_checkpoint(state);
        self.cost = started.elapsed().as_secs_f64();
        self.last = Instant::now();
    }
}

impl Session {
    /// The state that a killed solve of the same problem left.
    pub(super) fn read_checkpoint(&self) -> Result<Option<OuterState>, StageError> {
        let reader = match self.reader() {
            Err(StoreError::NotFound { .. }) => return Ok(None),
            opened => opened?,
        };
        let Ok(Some(stored)) = reader.whole_group(format::CHECKPOINT) else {
            return Ok(None);
        };
        if stored.record.input_digest != self.solve_input()? {
            return Ok(None);
        }
        // A damaged checkpoint costs time only.
        Ok(format::read_checkpoint(&reader).ok())
    }

    /// The input digest that the solve has, or will have once what is pending is stored.
    fn solve_input(&self) -> Result<String, StageError> {
        let stored: Vec<StoredGroup> = self
            .states()?
            .into_iter()
            .filter(|state| state.stage < Stage::Solve)
            .filter_map(|state| state.stored)
            .collect();
        let upstream: Vec<&StoredGroup> = stored.iter().collect();
        Ok(input_digest(
            Stage::Solve,
            &self.settings(Stage::Solve),
            &upstream,
        ))
    }
}

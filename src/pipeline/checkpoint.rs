//! When successive approximations are saved between two steps, and adaptive runs between two levels.

use std::time::{Duration, Instant};

use super::StageError;

/// At most one part in so many of the time goes into checkpoints.
const SHARE: f64 = 20.0;

/// The checkpoints of one solve, or of one adaptive run.
pub(super) struct Checkpoints {
    last: Instant,
    /// What writing one takes.
    cost: f64,
}

impl Checkpoints {
    /// Of a solve that begins now; `cost` is what writing one takes, in s.
    pub(super) fn new(cost: f64) -> Self {
        Self {
            last: Instant::now(),
            cost,
        }
    }

    /// Writes one if it is worth the time. A checkpoint that cannot be written is no reason to
    /// give up a solve: storing the solution will say what is wrong.
    pub(super) fn keep(&mut self, write: impl FnOnce() -> Result<(), StageError>) {
        if self.last.elapsed() < Duration::from_secs_f64(SHARE * self.cost) {
            return;
        }
        let started = Instant::now();
        let _ = write();
        self.cost = started.elapsed().as_secs_f64();
        self.last = Instant::now();
    }
}

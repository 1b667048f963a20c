//! How far a long step is, for whoever watches it from another thread.

use std::sync::atomic::{AtomicU64, Ordering};

/// Operations of a step, counted before it begins, and those that are done.
#[derive(Debug, Default)]
pub struct Work {
    total: f64,
    done: AtomicU64,
}

impl Work {
    /// Work of some operations, none of which is done.
    #[must_use]
    pub fn of(total: f64) -> Self {
        Self {
            total,
            done: AtomicU64::new(0),
        }
    }

    /// Notes that operations are done.
    pub(super) fn add(&self, operations: f64) {
        self.done.fetch_add(operations as u64, Ordering::Relaxed);
    }

    /// The share that is done, from 0 to 1; 0 where there is nothing to do.
    #[must_use]
    pub fn share(&self) -> f64 {
        let done = self.done.load(Ordering::Relaxed) as f64;
        if self.total > 0.0 {
            (done / self.total).min(1.0)
        } else {
            0.0
        }
    }
}

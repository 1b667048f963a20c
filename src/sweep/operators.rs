//! Assembled problems that cases share in memory.

use std::{
    collections::BTreeMap,
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
};

use contact3d::AssembledProblem;

use crate::pipeline::StageError;

/// The assembled problems that cases in memory share, within a memory budget.
///
/// A worker that waits here uses no operator, so idle ones can always be given up until the next fits.
pub(super) struct Operators {
    held: Mutex<BTreeMap<String, Slot>>,
    changed: Condvar,
    budget: u64,
}

/// One assembled problem.
#[derive(Default)]
struct Slot {
    operator: Option<Arc<AssembledProblem>>,
    /// Whether a worker makes it.
    preparing: bool,
    /// Cases at work with it.
    users: usize,
    /// Cases that still need it.
    left: usize,
    bytes: u64,
}

impl Operators {
    /// No operators yet; `needed` holds for every operator how many cases use it and its bytes.
    pub(super) fn new(needed: BTreeMap<String, (usize, u64)>, budget: u64) -> Self {
        let slot = |(left, bytes)| Slot {
            left,
            bytes,
            ..Slot::default()
        };
        let held = needed.into_iter().map(|(key, need)| (key, slot(need)));
        Self {
            held: Mutex::new(held.collect()),
            changed: Condvar::new(),
            budget,
        }
    }

    /// Waits for an operator or for the memory to make it, and prepares a session with it.
    pub(super) fn prepare(
        &self,
        key: &str,
        prepare: impl FnOnce(
            Option<&Arc<AssembledProblem>>,
        ) -> Result<Arc<AssembledProblem>, StageError>,
    ) -> Result<(), StageError> {
        let known = self.claim(key);
        let prepared = prepare(known.as_ref());
        let mut held = self.lock();
        let slot = held.entry(key.to_owned()).or_default();
        if known.is_none() {
            slot.preparing = false;
        }
        let outcome = prepared.map(|operator| slot.operator = Some(operator));
        self.changed.notify_all();
        outcome
    }

    /// The operator if it is there; otherwise the right to make it.
    fn claim(&self, key: &str) -> Option<Arc<AssembledProblem>> {
        let mut held = self.lock();
        loop {
            let used: u64 = held
                .values()
                .filter(|s| s.preparing || s.operator.is_some())
                .map(|s| s.bytes)
                .sum();
            let slot = held.entry(key.to_owned()).or_default();
            if let Some(operator) = &slot.operator {
                slot.users += 1;
                return Some(operator.clone());
            }
            if !slot.preparing && (used == 0 || used + slot.bytes <= self.budget) {
                slot.preparing = true;
                slot.users += 1;
                return None;
            }
            let wanted = !slot.preparing;
            let mut idle = held
                .values_mut()
                .filter(|s| s.users == 0 && s.operator.is_some());
            match idle.next() {
                Some(slot) if wanted => slot.operator = None,
                _ => {
                    held = self
                        .changed
                        .wait(held)
                        .unwrap_or_else(PoisonError::into_inner);
                }
            }
        }
    }

    /// Ends the work of a case that was prepared.
    pub(super) fn release(&self, key: &str) {
        if let Some(slot) = self.lock().get_mut(key) {
            slot.users = slot.users.saturating_sub(1);
        }
        self.changed.notify_all();
    }

    /// Counts a case as done, and gives up an operator that no case needs any more.
    pub(super) fn done(&self, key: &str) {
        if let Some(slot) = self.lock().get_mut(key) {
            slot.left = slot.left.saturating_sub(1);
            if slot.left == 0 {
                slot.operator = None;
            }
        }
        self.changed.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Slot>> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

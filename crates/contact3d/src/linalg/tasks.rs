//! Long steps along the elimination tree: what one thread treats, in which order tasks run, and how far they are.

use std::{
    ops::Range,
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, AtomicUsize, Ordering},
    },
};

use rayon::ScopeFifo;

use super::structure::{FactorStructure, Front};

/// Supernodes that one thread treats one after another: a subtree, or one supernode above the subtrees.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SubtreeTask {
    /// In postorder.
    pub(super) supernodes: Range<usize>,
    /// Tasks whose updates the last supernode takes, ascending.
    pub(super) children: Vec<usize>,
    pub(super) parent: Option<usize>,
}

impl FactorStructure {
    /// Cuts the elimination tree into tasks, in postorder; subtrees of less than `share` of all the work are not cut.
    pub(super) fn tasks(&self, work: impl Fn(Front<'_>) -> f64, share: f64) -> Vec<SubtreeTask> {
        let tree = self.supernode_tree();
        let work: Vec<f64> = (0..self.supernodes())
            .map(|s| work(self.front(s)))
            .collect();
        let most = share * work.iter().sum::<f64>();
        let pieces = tree.pieces(|s| work[s], |work| work < most);
        let mut task_of = vec![0; self.supernodes()];
        let mut tasks: Vec<SubtreeTask> = Vec::with_capacity(pieces.len());
        for supernodes in pieces {
            task_of[supernodes.end - 1] = tasks.len();
            let (children, parent) = (Vec::new(), None);
            tasks.push(SubtreeTask {
                supernodes,
                children,
                parent,
            });
        }
        for k in 0..tasks.len() {
            let last = tasks[k].supernodes.end - 1;
            if let Some(parent) = tree.parent[last].map(|parent| task_of[parent]) {
                tasks[k].parent = Some(parent);
                tasks[parent].children.push(k);
            }
        }
        tasks
    }
}

/// The part of each task in values of which those of supernode s begin at `offsets[s]`.
pub(super) fn split<'a, V>(
    tasks: &[SubtreeTask],
    offsets: &[usize],
    values: &'a mut [V],
) -> Vec<Mutex<&'a mut [V]>> {
    let mut rest = values;
    let mut own = |task: &SubtreeTask| {
        let count = offsets[task.supernodes.end] - offsets[task.supernodes.start];
        Mutex::new(
            rest.split_off_mut(..count)
                .expect("offsets end with the values"),
        )
    };
    tasks.iter().map(&mut own).collect()
}

/// Runs every task after its children, side by side where the tree allows; a task that returns false keeps its ancestors
/// from running.
pub(super) fn ascend(tasks: &[SubtreeTask], run: impl Fn(usize) -> bool + Sync) {
    let waiting: Vec<AtomicUsize> = tasks
        .iter()
        .map(|task| AtomicUsize::new(task.children.len()))
        .collect();
    // A task goes on with its parent if it is the last child to finish.
    let from = |leaf: usize| {
        let mut next = Some(leaf);
        while let Some(k) = next.filter(|&k| run(k)) {
            let last = |parent: &usize| waiting[*parent].fetch_sub(1, Ordering::AcqRel) == 1;
            next = tasks[k].parent.filter(last);
        }
    };
    rayon::in_place_scope_fifo(|scope| {
        for leaf in (0..tasks.len()).filter(|&k| tasks[k].children.is_empty()) {
            let from = &from;
            scope.spawn_fifo(move |_| from(leaf));
        }
    });
}

/// Runs every task after its parent, side by side where the tree allows.
pub(super) fn descend(tasks: &[SubtreeTask], run: impl Fn(usize) + Sync) {
    fn from<'s>(
        k: usize,
        tasks: &'s [SubtreeTask],
        run: &'s (impl Fn(usize) + Sync),
        scope: &ScopeFifo<'s>,
    ) {
        run(k);
        for &child in tasks[k].children.iter().rev() {
            scope.spawn_fifo(move |scope| from(child, tasks, run, scope));
        }
    }
    rayon::in_place_scope_fifo(|scope| {
        for root in (0..tasks.len())
            .rev()
            .filter(|&k| tasks[k].parent.is_none())
        {
            let run = &run;
            scope.spawn_fifo(move |scope| from(root, tasks, run, scope));
        }
    });
}

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

/// The content of a mutex, whether or not a thread that held it panicked.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

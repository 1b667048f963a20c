//! Numeric factorisation by the multifrontal method (I. Duff, J. Reid, *ACM Trans. Math. Softw.* 9 (1983) 302; J. W. H. Liu,
//! *SIAM Review* 34 (1992) 82).
//!
//! Every supernode has a dense front: the coefficients of its columns, plus what its children in the elimination tree leave.
//! Eliminating its columns gives its panel of L and an update for its parent. Small subtrees are tasks for one thread; the
//! supernodes above them are tasks of their own, cut into tiles inside. Children are added in ascending order and tiles have
//! one size, so the factor has the same bits at any number of threads.

mod assemble;
mod eliminate;
mod tasks;

use std::sync::Mutex;

use assemble::Buffers;
pub(super) use assemble::zeros;
use assemble::{Child, UpdateMatrix, add_children, scatter};
use eliminate::eliminate;
pub(super) use tasks::{SubtreeTask, ascend, descend, split};

use super::analysis::FactorStructure;
use super::precision::Scalar;
use super::sparse::CscMatrix;
use super::work::Work;

/// A subtree of less than this share of all operations is one task.
const SMALLEST_SHARE: f64 = 1.0 / 64.0;

/// Why there is no factor.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Failure {
    /// There is no memory for an update.
    OutOfMemory,
    /// A column, in the new numbering, whose pivot is not positive.
    Pivot(usize),
}

impl FactorStructure {
    /// Numbers in the lower triangles of the updates that are held at once while `threads` threads factorise: those of children not yet used when
    /// supernodes come one after another, and for each further thread the most that one of its fronts takes.
    pub(crate) fn update_count(&self, threads: usize) -> usize {
        let tree = self.supernode_tree();
        let (mut waiting, mut most, mut largest) = (0, 0, 0);
        let mut of_children = vec![0; self.supernodes()];
        for s in 0..self.supernodes() {
            let order = self.front(s).below().len();
            let numbers = order * (order + 1) / 2;
            waiting += numbers;
            most = most.max(waiting);
            largest = largest.max(numbers);
            waiting -= of_children[s];
            if let Some(parent) = tree.parent[s] {
                of_children[parent] += numbers;
            }
        }
        most + threads.saturating_sub(1) * largest
    }
}

/// Computes the panels of L, which are zero, for PAPᵀ = LLᵀ, and notes each front that is done.
///
/// # Errors
/// [`Failure`]; of several pivots the first, and the columns before it in its subtree are complete.
pub(super) fn factorise<T: Scalar>(
    structure: &FactorStructure,
    a: &CscMatrix,
    values: &mut [T],
    work: &Work,
) -> Result<(), Failure> {
    let tasks = structure.tasks(|front| front.operations(), SMALLEST_SHARE);
    let run = Run {
        structure,
        a,
        new_of_old: structure.new_of_old(),
        panels: split(&tasks, &structure.value_offsets, values),
        updates: tasks.iter().map(|_| Mutex::new(None)).collect(),
        failure: Mutex::new(None),
        buffers: Buffers::default(),
        tasks: &tasks,
        work,
    };
    ascend(&tasks, |task| run.finish(task));
    locked(&run.failure).map_or(Ok(()), Err)
}

/// A factorisation under way.
struct Run<'a, T> {
    structure: &'a FactorStructure,
    a: &'a CscMatrix,
    new_of_old: Vec<usize>,
    tasks: &'a [SubtreeTask],
    panels: Vec<Mutex<&'a mut [T]>>,
    /// What each finished task leaves to its parent.
    updates: Vec<Mutex<Option<UpdateMatrix<T>>>>,
    /// The first failure so far.
    failure: Mutex<Option<Failure>>,
    buffers: Buffers<T>,
    work: &'a Work,
}

impl<T: Scalar> Run<'_, T> {
    /// Runs a task and keeps what it leaves to its parent; false where a pivot failed.
    fn finish(&self, k: usize) -> bool {
        let children = self.tasks[k].children.iter();
        let updates = children
            .filter_map(|&child| locked(&self.updates[child]).take())
            .collect();
        match self.subtree(k, updates) {
            Ok(update) => *locked(&self.updates[k]) = update,
            Err(failure) => {
                let mut first = locked(&self.failure);
                *first = Some(first.map_or(failure, |first| first.min(failure)));
                return false;
            }
        }
        true
    }

    /// Eliminates the supernodes of a task in postorder; the updates on the stack are those of children not yet used.
    fn subtree(
        &self,
        task: usize,
        mut stack: Vec<UpdateMatrix<T>>,
    ) -> Result<Option<UpdateMatrix<T>>, Failure> {
        let mut rest: &mut [T] = &mut locked(&self.panels[task]);
        for s in self.tasks[task].supernodes.clone() {
            let offsets = &self.structure.value_offsets;
            let (panel, next) = rest.split_at_mut(offsets[s + 1] - offsets[s]);
            rest = next;
            let update = self.front(s, panel, &mut stack)?;
            stack.extend(update);
        }
        Ok(stack.pop())
    }

    fn front(
        &self,
        s: usize,
        panel: &mut [T],
        stack: &mut Vec<UpdateMatrix<T>>,
    ) -> Result<Option<UpdateMatrix<T>>, Failure> {
        let front = self.structure.front(s);
        let (height, width) = (front.rows.len(), front.width);
        let order = height - width;
        let own = front.first..front.first + width;
        let is_child = |update: &UpdateMatrix<T>| {
            let child = self.structure.front(update.supernode);
            child.below().first().is_some_and(|row| own.contains(row))
        };
        let last_other = stack.iter().rposition(|update| !is_child(update));
        let finished = stack.split_off(last_other.map_or(0, |i| i + 1));
        let children = finished.iter().map(|update| {
            let child = self.structure.front(update.supernode);
            Child::new(&update.values, child.below(), front.rows)
        });
        let children: Vec<Child<'_, T>> = children.collect();
        let permutation = &self.structure.permutation;
        scatter(self.a, permutation, &self.new_of_old, front, panel);
        add_children(&children, panel, 0, 0, height);
        let values = self.buffers.take(order * order);
        let mut values = values.ok_or(Failure::OutOfMemory)?;
        let below = &mut values[..order * order];
        eliminate(panel, height, width, below)
            .map_err(|column| Failure::Pivot(front.first + column))?;
        add_children(&children, below, width, width, order);
        drop(children);
        self.work.add(front.operations());
        finished
            .into_iter()
            .for_each(|update| self.buffers.put(update.values));
        Ok((order > 0).then_some(UpdateMatrix {
            supernode: s,
            values,
        }))
    }
}

pub(super) fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

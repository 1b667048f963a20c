//! What a run asks of the storage of its results: whether memory allows a step, to show its progress, and to store unfinished work.

use std::{cell::RefCell, sync::Arc};

use crate::{
    dual::{Assembling, InsufficientResource, Requirement},
    history::StepRecord,
    linalg::Work,
    scene::Increment,
    solver::{OuterState, Progress},
};

/// What a run is doing.
#[derive(Debug, Clone, Copy)]
pub enum RunStep<'a> {
    /// The name of a long step of assembling that begins.
    Assembling(&'static str),
    /// How far that step is, to be read while it is at work.
    Counting(&'static str, &'a Arc<Work>),
    /// A load history goes on after an increment, which is one of how many.
    Resuming(Increment, [usize; 2]),
    /// A step of the solver, with its increment in a load history.
    Solving(Option<Increment>, Progress<'a>),
}

/// What a solve that is not done yet has to show, from which it goes on with the same bits.
#[derive(Debug, Clone, Copy)]
pub enum Checkpoint<'a> {
    /// Successive approximations between two steps.
    Solve(&'a OuterState),
    /// The first increments of a load history.
    History(&'a [StepRecord]),
}

/// Admits and observes the steps of a run, and stores what is unfinished.
pub trait RunStorage {
    /// Decides whether a step may begin, by the memory and the room on the disk that it takes.
    ///
    /// # Errors
    /// What there is too little of.
    fn admit(&self, _need: Requirement) -> Result<(), InsufficientResource> {
        Ok(())
    }

    /// The program that is to hold factors; `None` for this one.
    fn engine(&self) -> Option<&str> {
        None
    }

    /// Sees a step.
    fn observe(&mut self, _step: RunStep<'_>) {}

    /// Keeps what an interrupted run could go on from.
    fn checkpoint(&mut self, _checkpoint: Checkpoint<'_>) {}
}

/// Keeps results in memory only, admits all, and watches nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct InMemory;

impl RunStorage for InMemory {}

/// Admits and watches as another does, and keeps nothing.
pub(super) struct ReadOnly<'a>(pub(super) &'a mut dyn RunStorage);

impl RunStorage for ReadOnly<'_> {
    fn admit(&self, need: Requirement) -> Result<(), InsufficientResource> {
        self.0.admit(need)
    }

    fn engine(&self) -> Option<&str> {
        self.0.engine()
    }

    fn observe(&mut self, step: RunStep<'_>) {
        self.0.observe(step);
    }
}

/// Lets a storage admit and watch what assembles.
pub(super) fn assembled_by<T>(
    storage: &mut dyn RunStorage,
    assemble: impl FnOnce(&Assembling<'_>) -> T,
) -> T {
    let engine = storage.engine().map(str::to_owned);
    let storage = RefCell::new(storage);
    let admit = |need: Requirement| {
        storage.borrow_mut().observe(RunStep::Assembling(need.step));
        storage.borrow().admit(need)
    };
    let begun =
        |step, work: &Arc<Work>| storage.borrow_mut().observe(RunStep::Counting(step, work));
    assemble(&Assembling {
        admit: &admit,
        begun: &begun,
        engine: engine.as_deref(),
    })
}

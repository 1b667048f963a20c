//! What a run asks of the keeper of its results: whether memory allows a step, to show its progress, and to store unfinished work.

use std::{cell::RefCell, sync::Arc};

use crate::{
    dual::{Assembling, Need, Shortage},
    history::StepRecord,
    linalg::{EngineCommand, Work},
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
    /// A step of the solver, with its increment in a load history.
    Solving(Option<Increment>, Progress<'a>),
}

/// What a solve that is not done yet has to show, from which it goes on with the same bits.
#[derive(Debug, Clone, Copy)]
pub enum Unfinished<'a> {
    /// Successive approximations between two steps.
    Solve(&'a OuterState),
    /// The first increments of a load history.
    History(&'a [StepRecord]),
}

/// Admits and watches the steps of a run, and keeps what is unfinished.
pub trait Keeper {
    /// Decides whether a step may begin, by the memory and the room on the disk that it takes.
    ///
    /// # Errors
    /// What there is too little of.
    fn admit(&self, _need: Need) -> Result<(), Shortage> {
        Ok(())
    }

    /// The program that is to hold factors; `None` for this one.
    fn engine(&self) -> Option<&EngineCommand> {
        None
    }

    /// Sees a step.
    fn observe(&mut self, _step: RunStep<'_>) {}

    /// Keeps what an interrupted run could go on from.
    fn keep(&mut self, _unfinished: Unfinished<'_>) {}
}

/// Keeps results in memory only, admits all, and watches nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct InMemory;

impl Keeper for InMemory {}

/// Admits and watches as another does, and keeps nothing.
pub(super) struct Unkept<'a>(pub(super) &'a mut dyn Keeper);

impl Keeper for Unkept<'_> {
    fn admit(&self, need: Need) -> Result<(), Shortage> {
        self.0.admit(need)
    }

    fn engine(&self) -> Option<&EngineCommand> {
        self.0.engine()
    }

    fn observe(&mut self, step: RunStep<'_>) {
        self.0.observe(step);
    }
}

/// Lets a keeper admit and watch what assembles.
pub(super) fn assembled_by<T>(
    keeper: &mut dyn Keeper,
    assemble: impl FnOnce(&Assembling<'_>) -> T,
) -> T {
    let engine = keeper.engine().cloned();
    let keeper = RefCell::new(keeper);
    let admit = |need: Need| {
        keeper.borrow_mut().observe(RunStep::Assembling(need.step));
        keeper.borrow().admit(need)
    };
    let begun = |step, work: &Arc<Work>| keeper.borrow_mut().observe(RunStep::Counting(step, work));
    assemble(&Assembling {
        admit: &admit,
        begun: &begun,
        engine: engine.as_ref(),
    })
}

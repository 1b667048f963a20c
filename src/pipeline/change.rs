//! A change of the run file under way, written beside the next stage.

use std::{
    sync::Arc,
    thread::{self, JoinHandle},
    time::Instant,
};

use contact3d::{history::StepRecord, scene::Scene, solver::OuterState};
use runfile::{Group, GroupRecord, Home, Reader, StoreError, StoredGroup, Transaction};

use super::{
    AssemblyFile, StageState,
    freshness::input_digest,
    session::Task,
    stages::Output,
    store::{input_digest_of, write_group, write_scene},
};
use crate::format::{self, ADAPT, CHECKPOINT, HISTORY, Stage};

/// A computed stage that is not stored yet, with all that it takes to store it.
#[derive(Debug)]
pub(super) struct ComputedStage {
    output: Output,
    home: Home,
    /// Without what it was computed from.
    record: GroupRecord,
}

impl ComputedStage {
    pub(super) fn new(
        output: Output,
        seconds: f64,
        assembly_file: AssemblyFile,
        task: &Task,
    ) -> Self {
        Self {
            home: output.home(assembly_file),
            record: task.record(task.settings(output.stage()), seconds, String::new()),
            output,
        }
    }

    pub(super) fn stage(&self) -> Stage {
        self.output.stage()
    }

    /// Seconds of computing it.
    pub(super) fn seconds(&self) -> f64 {
        self.record.seconds
    }
}

/// What a solve that is not done yet has to show.
#[derive(Debug, Clone, Copy)]
pub(super) enum Unfinished<'a> {
    /// Successive approximations between two steps.
    Solve(&'a OuterState),
    /// The first increments of a load history.
    History(&'a [StepRecord]),
}

/// A change that has begun: the scene is written, and the stages given so far.
#[derive(Debug)]
pub(super) struct Update {
    transaction: Transaction,
    /// What the file will hold of the stages.
    stored: Vec<(Stage, StoredGroup)>,
    changed: Vec<Group>,
    scene: Scene,
}

impl Update {
    /// Begins with the scene; `states` are those of the file as it is.
    pub(super) fn new(
        mut transaction: Transaction,
        states: Vec<StageState>,
        assembly_file: AssemblyFile,
        task: &Task,
    ) -> Result<Self, StoreError> {
        // What is damaged cannot be used, and copying it could fail.
        let damaged = transaction.previous().map(Reader::damaged_groups);
        for group in damaged.into_iter().flatten() {
            transaction.remove(group);
        }
        if assembly_file == AssemblyFile::SelfContained {
            transaction.embed_linked();
        }
        transaction.remove(CHECKPOINT);
        if task.input.scene.adapt.is_none() {
            transaction.remove(ADAPT);
        }
        if !task.input.scene.has_history() {
            transaction.remove(HISTORY);
        }
        write_scene(&mut transaction, task)?;
        let stored = states
            .into_iter()
            .filter_map(|state| Some((state.stage, state.stored?)));
        Ok(Self {
            stored: stored.collect(),
            transaction,
            changed: Vec::new(),
            scene: task.input.scene.clone(),
        })
    }

    /// Writes a stage.
    pub(super) fn write(&mut self, pending: &ComputedStage) -> Result<(), StoreError> {
        let stage = pending.stage();
        self.stored.retain(|(earlier, _)| *earlier != stage);
        let upstream = self.stored.iter().filter(|(earlier, _)| *earlier < stage);
        let upstream: Vec<&StoredGroup> = upstream.map(|(_, stored)| stored).collect();
        let record = GroupRecord {
            input_digest: input_digest(stage, &pending.record.settings, &upstream),
            ..pending.record.clone()
        };
        let transaction = &mut self.transaction;
        let scene = &self.scene;
        let digest = pending
            .output
            .write(transaction, pending.home, &record, scene)?;
        let units = scene.units;
        self.stored.push((
            stage,
            StoredGroup {
                record,
                digest,
                units,
            },
        ));
        self.changed.push(stage.group());
        Ok(())
    }

    /// Writes the state of an unfinished solve.
    pub(super) fn write_unfinished(
        &mut self,
        unfinished: Unfinished<'_>,
        task: &Task,
    ) -> Result<(), StoreError> {
        let digest = input_digest_of(Stage::Solve, task, &self.stored);
        let record = task.record(String::new(), 0.0, digest);
        let group = match unfinished {
            Unfinished::Solve(_) => CHECKPOINT,
            Unfinished::History(_) => {
                // An older solution belongs to other increments.
                self.transaction.remove(Stage::Solve.group());
                HISTORY
            }
        };
        let (transaction, home) = (&mut self.transaction, Home::RunFile);
        write_group(
            transaction,
            group,
            home,
            &record,
            |writer| match unfinished {
                Unfinished::Solve(state) => format::write_checkpoint(writer, state),
                Unfinished::History(records) => {
                    format::write_history(writer, &task.input.scene, records)
                }
            },
        )?;
        self.changed.push(group);
        Ok(())
    }

    /// The groups written, in their order.
    pub(super) fn changed(&self) -> &[Group] {
        &self.changed
    }

    /// Lets the disk begin with what is written.
    pub(super) fn write_back(&self) -> Result<(), StoreError> {
        self.transaction.write_back()
    }

    pub(super) fn into_parts(self) -> (Transaction, Vec<Group>) {
        (self.transaction, self.changed)
    }
}

/// A change of the run file that a thread of its own writes.
///
/// It builds on the run file as it was: nobody else changes that before the thread has ended. Dropping it waits for the thread
/// and gives up what is not stored for good.
#[derive(Debug)]
pub(super) struct BackgroundWrite {
    thread: Option<JoinHandle<Result<WriteResult, StoreError>>>,
    /// Stages that it stores for good.
    commits: usize,
}

/// What becomes of a change once its stages are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AfterWriting {
    /// It waits for those of the next stage.
    Wait,
    /// It is stored for good.
    Commit,
}

/// What a thread has written.
#[derive(Debug)]
pub(super) enum WriteResult {
    Begun(Box<Update>),
    Committed {
        changed: Vec<Group>,
        seconds: f64,
        /// What became of it: stored, whatever it says.
        committed: Result<(), StoreError>,
    },
}

impl BackgroundWrite {
    /// Starts to write stages; `None` where the system has no thread for it.
    pub(super) fn new(
        change: Update,
        stages: Vec<Arc<ComputedStage>>,
        then: AfterWriting,
    ) -> Option<Self> {
        let commits = match then {
            AfterWriting::Wait => 0,
            AfterWriting::Commit => stages.len(),
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
    pub(super) fn join(mut self) -> Result<WriteResult, StoreError> {
        let thread = self.thread.take().expect("joined once");
        thread
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

impl Drop for BackgroundWrite {
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn written(
    mut change: Update,
    stages: &[Arc<ComputedStage>],
    then: AfterWriting,
) -> Result<WriteResult, StoreError> {
    let started = Instant::now();
    for stage in stages {
        change.write(stage)?;
    }
    match then {
        AfterWriting::Wait => {
            change.write_back()?;
            Ok(WriteResult::Begun(Box::new(change)))
        }
        AfterWriting::Commit => {
            let (transaction, changed) = change.into_parts();
            match transaction.commit() {
                Err(error) if !error.is_after_storing() => Err(error),
                committed => Ok(WriteResult::Committed {
                    changed,
                    seconds: started.elapsed().as_secs_f64(),
                    committed,
                }),
            }
        }
    }
}

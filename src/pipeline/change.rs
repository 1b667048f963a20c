//! A change of the run file under way.

use contact3d::solver::OuterState;
use runfile::{Group, GroupRecord, Home, Reader, StoreError, StoredGroup, Transaction};
use units::Units;

use super::{
    AssemblyFile, StageState,
    freshness::input_digest,
    session::Task,
    stages::Output,
    store::{input_digest_of, write_group, write_scene},
};
use crate::format::{self, ADAPT, CHECKPOINT, Stage};

/// A computed stage that is not stored yet, with all that it takes to store it.
#[derive(Debug)]
pub(super) struct Pending {
    output: Output,
    home: Home,
    /// Without what it was computed from.
    record: GroupRecord,
}

impl Pending {
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

/// A change that has begun: the scene is written, and the stages given so far.
#[derive(Debug)]
pub(super) struct Change {
    transaction: Transaction,
    /// What the file will hold of the stages.
    stored: Vec<(Stage, StoredGroup)>,
    changed: Vec<Group>,
    units: Units,
}

impl Change {
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
        write_scene(&mut transaction, task)?;
        let stored = states
            .into_iter()
            .filter_map(|state| Some((state.stage, state.stored?)));
        Ok(Self {
            stored: stored.collect(),
            transaction,
            changed: Vec::new(),
            units: task.input.scene.units,
        })
    }

    /// Writes a stage.
    pub(super) fn write(&mut self, pending: &Pending) -> Result<(), StoreError> {
        let stage = pending.stage();
        self.stored.retain(|(earlier, _)| *earlier != stage);
        let upstream = self.stored.iter().filter(|(earlier, _)| *earlier < stage);
        let upstream: Vec<&StoredGroup> = upstream.map(|(_, stored)| stored).collect();
        let record = GroupRecord {
            input_digest: input_digest(stage, &pending.record.settings, &upstream),
            ..pending.record.clone()
        };
        let transaction = &mut self.transaction;
        let digest = pending.output.write(transaction, pending.home, &record)?;
        let units = self.units;
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
    pub(super) fn write_checkpoint(
        &mut self,
        state: &OuterState,
        task: &Task,
    ) -> Result<(), StoreError> {
        let digest = input_digest_of(Stage::Solve, task, &self.stored);
        let record = task.record(String::new(), 0.0, digest);
        write_group(
            &mut self.transaction,
            CHECKPOINT,
            Home::RunFile,
            &record,
            |writer| format::write_checkpoint(writer, state),
        )?;
        self.changed.push(CHECKPOINT);
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

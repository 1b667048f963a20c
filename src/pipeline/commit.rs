//! A commit: the scene, the stages that wait, and what is unfinished, in one step; and the way back from commits: a command that
//! is refused midway leaves its run file as it found it.

use contact3d::Checkpoint;
use runfile::{
    FileState, Group, GroupRecord, RunFile, Savepoint, StoreError, StoredGroup, Transaction,
};

use super::{
    AssemblyFile, Session, StageError, freshness::input_digest, stages::StageOutput, store::Store,
};
use crate::format::{self, ADAPT, CHECKPOINT, HISTORY, Stage};

/// A computed stage that waits to be stored.
#[derive(Debug, Clone)]
pub(super) struct WaitingStage {
    pub(super) output: StageOutput,
    /// Without what it was computed from.
    pub(super) record: GroupRecord,
}

/// A commit that has begun: the scene is written, and the stages given so far.
#[derive(Debug)]
pub(super) struct Commit<'a> {
    store: &'a Store,
    pub(super) transaction: Transaction,
    /// What the file will hold of the stages.
    stored: Vec<(Stage, StoredGroup)>,
    /// The groups written, in their order.
    pub(super) changed: Vec<Group>,
}

impl<'a> Commit<'a> {
    /// Begins with the scene.
    ///
    /// # Errors
    /// `Changed` if the file holds other stages than those that the waiting ones build on.
    pub(super) fn begin(store: &'a Store) -> Result<Self, StoreError> {
        let mut transaction = Transaction::begin(&store.file)?;
        let states = store.states_in(transaction.previous())?;
        store.require_upstream(&states)?;
        if store.assembly_file == AssemblyFile::SelfContained {
            transaction.embed_linked();
        }
        transaction.remove(CHECKPOINT);
        let scene = &store.input.scene;
        if scene.adapt.is_none() {
            transaction.remove(ADAPT);
        }
        if !scene.has_history() {
            transaction.remove(HISTORY);
        }
        store.write_scene(&mut transaction)?;
        for link in &store.links {
            transaction.link(link)?;
        }
        let stored = states.into_iter();
        Ok(Self {
            store,
            transaction,
            stored: stored
                .filter_map(|state| Some((state.stage, state.stored?)))
                .collect(),
            changed: Vec::new(),
        })
    }

    /// Writes a stage.
    pub(super) fn write(&mut self, computed: &WaitingStage) -> Result<(), StoreError> {
        let scene = &self.store.input.scene;
        let stage = computed.output.stage();
        self.stored.retain(|(earlier, _)| *earlier != stage);
        let settings = &computed.record.settings;
        let record = GroupRecord {
            input_digest: input_digest(stage, settings, &self.stored),
            ..computed.record.clone()
        };
        if computed.output.is_kept_beside(self.store.assembly_file) {
            self.transaction.keep_beside(stage.group());
        }
        let stored = StoredGroup {
            digest: computed
                .output
                .write(&mut self.transaction, &record, scene)?,
            units: scene.units,
            record,
        };
        self.stored.push((stage, stored));
        self.changed.push(stage.group());
        Ok(())
    }

    /// Writes what a solve goes on from that is not done yet.
    pub(super) fn write_unfinished(
        &mut self,
        unfinished: Checkpoint<'_>,
    ) -> Result<(), StoreError> {
        let settings = self.store.settings(Stage::Solve);
        let digest = input_digest(Stage::Solve, &settings, &self.stored);
        let record = self.store.record(String::new(), 0.0, digest);
        let group = match unfinished {
            Checkpoint::Solve(_) => CHECKPOINT,
            Checkpoint::History(_) => {
                // An older solution belongs to other increments.
                self.transaction.remove(Stage::Solve.group());
                HISTORY
            }
        };
        let scene = &self.store.input.scene;
        self.transaction
            .write(group, &record, |writer| match unfinished {
                Checkpoint::Solve(state) => format::write_checkpoint(writer, state),
                Checkpoint::History(records) => format::write_history(writer, scene, records),
            })?;
        self.changed.push(group);
        Ok(())
    }
}

/// What a command puts back if it is refused midway.
#[derive(Debug, Default)]
pub(super) struct Rollback {
    /// The file before the first commit.
    savepoint: Option<Savepoint>,
    /// The file as the last commit left it; none before the first.
    last: Option<FileState>,
    stored: Vec<Group>,
    /// Files of assembled data that the run file has linked since the command began.
    linked: Vec<String>,
}

impl Rollback {
    /// Keeps the state of the file before the first commit, and the names of the files that the commit writes beside it.
    pub(super) fn before_commit(
        &mut self,
        file: &RunFile,
        beside: Vec<String>,
    ) -> Result<(), StoreError> {
        self.linked.extend(beside);
        if self.savepoint.is_none() {
            self.savepoint = Some(file.savepoint()?);
        }
        Ok(())
    }

    /// Notes what a commit stored.
    pub(super) fn after_commit(&mut self, file: &RunFile, changed: &[Group]) {
        self.last = Some(FileState::of(file.path()));
        self.stored.extend(changed);
        self.linked.extend(file.linked_names());
    }

    /// Keeps what the command stored, or puts the earlier state back.
    fn after(self, error: StageError, file: &RunFile) -> StageError {
        let Some(savepoint) = self.savepoint else {
            return error;
        };
        if error.is_of_machine() && !self.stored.is_empty() {
            return StageError::Partly {
                stored: self.stored,
                source: Box::new(error),
            };
        }
        let is_ours = self.last == Some(FileState::of(file.path()));
        if is_ours && !error.is_internal() {
            return savepoint.restore().map_or_else(Into::into, |()| error);
        }
        error
    }
}

impl Session {
    /// Does work that may store in several steps. If it is refused, the run file is as before; if
    /// the machine fails midway, for example because the disk is full, the stages stored by then
    /// stay and the error says so.
    ///
    /// # Errors
    /// Those of the work; [`StageError::Partly`] if something was stored.
    pub fn all_or_nothing<T>(
        &mut self,
        work: impl FnOnce(&mut Self) -> Result<T, StageError>,
    ) -> Result<T, StageError> {
        self.store.rollback = Some(Rollback {
            linked: self.store.file.linked_names(),
            ..Rollback::default()
        });
        let outcome = work(self);
        let file = &self.store.file;
        let mut rollback = self.store.rollback.take().unwrap_or_default();
        let linked = std::mem::take(&mut rollback.linked);
        let outcome = outcome.map_err(|error| rollback.after(error, file));
        file.remove_unlinked(linked);
        outcome
    }
}

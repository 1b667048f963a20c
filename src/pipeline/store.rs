//! The run file of a session: what of it is fresh for a scene, and how computed stages get into it.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use contact3d::{
    Checkpoint,
    history::StepRecord,
    mesh::RefinedLevel,
    scene::{Scene, SceneFile},
    solver::OuterState,
};
use runfile::{
    Group, GroupRecord, GroupWriter, Reader, RunFile, SharedGroup, StoreError, Transaction,
};

use super::{
    AssemblyFile, StageError, StageState, StageTiming, StoreWhen,
    adapt::{read_levels, refinement_in_force},
    commit::{Commit, Rollback, WaitingStage},
    freshness::{Freshness, is_left_by, states_from},
    settings::{refinement_digest, settings, start_digest},
    stages::StageOutput,
};
use crate::format::{self, CHECKPOINT, HISTORY, LAYOUT, SCENE, Stage};

/// Seconds of work that may wait to be stored in one commit: an interruption costs no more than that.
const SHORT_RUN: f64 = 10.0;

/// A locked run file, and what is asked of it.
#[derive(Debug)]
pub(super) struct Store {
    pub(super) file: RunFile,
    pub(super) input: SceneFile,
    /// The cuts between the first mesh of the scene and the one in force.
    pub(super) refinement: Vec<RefinedLevel>,
    /// The multipliers that a solve starts from, none for λ = 0; where `None`, which also is λ = 0, a stored solve stays fresh
    /// whatever it started from.
    pub(super) start: Option<Vec<f64>>,
    threads: usize,
    /// Where assembled data are kept.
    pub(super) assembly_file: AssemblyFile,
    /// The program that is to hold factors; `None` for this one.
    pub(super) engine: Option<String>,
    /// Digests of the stages that the stage at work builds on, as they were when it began.
    upstream: Vec<(Stage, String)>,
    /// Large stages of files beside the run file, which is linked to them with the next stage that is stored.
    pub(super) links: Vec<SharedGroup>,
    /// Stages that are computed but not yet stored.
    pub(super) pending: Vec<WaitingStage>,
    /// What the last commit of this process took.
    pub(super) last_store_seconds: f64,
    /// For a command that can be taken back.
    pub(super) rollback: Option<Rollback>,
}

impl Store {
    pub(super) fn new(file: RunFile, input: SceneFile, threads: usize) -> Result<Self, StoreError> {
        let reader = Reader::open_if_there(file.path(), LAYOUT)?;
        // Unreadable levels are made again.
        let levels = reader.and_then(|it| read_levels(&it, &input.scene).unwrap_or(None));
        Ok(Self {
            refinement: refinement_in_force(levels.as_ref(), &input.scene),
            file,
            input,
            start: None,
            threads,
            assembly_file: AssemblyFile::default(),
            engine: None,
            upstream: Vec::new(),
            links: Vec::new(),
            pending: Vec::new(),
            last_store_seconds: 0.0,
            rollback: None,
        })
    }

    pub(super) fn path(&self) -> &Path {
        self.file.path()
    }

    pub(super) fn reader(&self) -> Result<Reader, StoreError> {
        Reader::open(self.path(), LAYOUT)
    }

    /// The run file opened for reading; `None` in the place of a new one.
    pub(super) fn reader_if_there(&self) -> Result<Option<Reader>, StoreError> {
        Reader::open_if_there(self.path(), LAYOUT)
    }

    /// The settings of a stage in force, as TOML.
    pub(super) fn settings(&self, stage: Stage) -> String {
        let refinement = refinement_digest(&self.refinement);
        let start = self.start.as_deref().and_then(start_digest);
        let scene = &self.input.scene;
        settings(stage, scene, refinement.as_deref(), start.as_deref())
    }

    /// How a group was made.
    pub(super) fn record(
        &self,
        settings: String,
        seconds: f64,
        input_digest: String,
    ) -> GroupRecord {
        GroupRecord::ended(settings, input_digest, seconds, self.threads)
    }

    /// The state of every stage with respect to the scene, those that will be linked included; all missing in a new file.
    pub(super) fn states(&self) -> Result<Vec<StageState>, StoreError> {
        self.states_in(self.reader_if_there()?.as_ref())
    }

    pub(super) fn states_in(&self, reader: Option<&Reader>) -> Result<Vec<StageState>, StoreError> {
        let start = self.start.as_deref();
        let mut states = states_from(reader, &self.input.scene, &self.refinement, start)?;
        for state in &mut states {
            let mut links = self.links.iter();
            if let Some(link) = links.find(|link| link.group == state.stage.group()) {
                state.freshness = Freshness::Fresh;
                state.stored = Some(link.stored.clone());
            }
        }
        Ok(states)
    }

    /// Refuses to begin a stage on anything but fresh ones, stored or waiting, and remembers which of the stored ones these were.
    pub(super) fn require_fresh_before(&mut self, stage: Stage) -> Result<(), StageError> {
        let is_stored = |state: &StageState| {
            let mut pending = self.pending.iter();
            pending.all(|pending| pending.output.stage() != state.stage)
        };
        let (fresh, bad): (Vec<StageState>, Vec<StageState>) = self
            .states()?
            .into_iter()
            .filter(|state| state.stage < stage)
            .filter(is_stored)
            .partition(StageState::is_fresh);
        match bad.into_iter().next() {
            None => {
                let digest = |state: StageState| Some((state.stage, state.stored?.digest));
                self.upstream = fresh.into_iter().filter_map(digest).collect();
                Ok(())
            }
            // It was fresh when an earlier stage began.
            Some(state) if self.upstream.iter().any(|(known, _)| *known == state.stage) => {
                let file = self.path().to_owned();
                Err(StoreError::Changed { file }.into())
            }
            Some(state) => Err(StageError::NotReady {
                file: self.path().to_owned(),
                stage,
                upstream: state.stage,
                why: state.freshness.why(),
            }),
        }
    }

    /// Refuses to go on once the file holds other stages than those that the stage at work builds
    /// on: another program may have replaced or removed it meanwhile.
    pub(super) fn require_unchanged(&self) -> Result<(), StoreError> {
        self.require_upstream(&self.states()?)
    }

    pub(super) fn require_upstream(&self, states: &[StageState]) -> Result<(), StoreError> {
        let holds = |(stage, digest): &(Stage, String)| {
            let mut same = states.iter().filter(|state| state.stage == *stage);
            same.any(|state| matches!(&state.stored, Some(it) if it.digest == *digest))
        };
        if self.upstream.iter().all(holds) {
            Ok(())
        } else {
            let file = self.path().to_owned();
            Err(StoreError::Changed { file })
        }
    }

    /// Stores a stage just computed with the scene and what is pending, at once or together with
    /// the next one.
    pub(super) fn keep(
        &mut self,
        output: StageOutput,
        started: Instant,
        commit: StoreWhen,
    ) -> Result<StageTiming, StageError> {
        let stage = output.stage();
        let compute_seconds = started.elapsed().as_secs_f64();
        self.pending.push(WaitingStage {
            record: self.record(self.settings(stage), compute_seconds, String::new()),
            output,
        });
        let waiting: f64 = self.pending.iter().map(|it| it.record.seconds).sum();
        let is_due = match commit {
            StoreWhen::Manual => false,
            StoreWhen::Now => true,
            StoreWhen::Deferred => {
                Stage::ALL.last() == Some(&stage)
                    || waiting >= self.last_store_seconds.max(SHORT_RUN)
            }
        };
        if is_due {
            self.commit(None)?;
        }
        Ok(StageTiming {
            stage,
            compute_seconds,
            store_seconds: if is_due { self.last_store_seconds } else { 0.0 },
        })
    }

    /// Stores what waits, and what a solve goes on from that is not done yet.
    pub(super) fn commit(&mut self, unfinished: Option<Checkpoint<'_>>) -> Result<(), StageError> {
        let storing = Instant::now();
        let mut commit = Commit::begin(self)?;
        for waiting in &self.pending {
            commit.write(waiting)?;
        }
        if let Some(unfinished) = unfinished {
            commit.write_unfinished(unfinished)?;
        }
        let Commit {
            transaction,
            changed,
            ..
        } = commit;
        self.end(transaction, &changed)?;
        self.links.clear();
        self.pending.clear();
        self.last_store_seconds = storing.elapsed().as_secs_f64();
        Ok(())
    }

    /// Ends a change of the run file, which stored some groups.
    pub(super) fn end(
        &mut self,
        transaction: Transaction,
        changed: &[Group],
    ) -> Result<(), StoreError> {
        if let Some(rollback) = &mut self.rollback {
            rollback.before_commit(&self.file, transaction.names_beside())?;
        }
        let committed = transaction.commit();
        let is_stored = match &committed {
            Ok(()) => true,
            Err(error) => error.is_after_storing(),
        };
        if is_stored && let Some(rollback) = &mut self.rollback {
            rollback.after_commit(&self.file, changed);
        }
        committed
    }

    /// What a killed solve of the same problem left: successive approximations, or the increments of a load history. Damaged
    /// ones cost time only.
    pub(super) fn read_unfinished(
        &self,
    ) -> Result<(Option<OuterState>, Vec<StepRecord>), StageError> {
        let scene = &self.input.scene;
        if scene.has_history() {
            let reader = self.unfinished(HISTORY)?;
            let records = reader.and_then(|reader| format::read_history(&reader, scene).ok());
            return Ok((None, records.unwrap_or_default()));
        }
        let reader = self.unfinished(CHECKPOINT)?;
        let state = reader.and_then(|reader| format::read_checkpoint(&reader).ok());
        Ok((state, Vec::new()))
    }

    /// The file, where it holds a group that a solve of the same problem left.
    fn unfinished(&self, group: Group) -> Result<Option<Reader>, StageError> {
        let Some(reader) = self.reader_if_there()? else {
            return Ok(None);
        };
        let Some(left) = reader.group_record(group)? else {
            return Ok(None);
        };
        let (scene, refinement, start) =
            (&self.input.scene, &self.refinement, self.start.as_deref());
        let fits = is_left_by(
            scene,
            refinement,
            start.or(Some(&[])),
            &left,
            &self.states()?,
        );
        Ok(fits.then_some(reader))
    }

    /// Writes the scene.
    pub(super) fn write_scene(&self, transaction: &mut Transaction) -> Result<(), StoreError> {
        let record = self.record(String::new(), 0.0, String::new());
        transaction.write(SCENE, &record, |writer| {
            format::write_scene(writer, &self.input.scene)
        })?;
        Ok(())
    }
}

/// Stores a group with the scene that it was computed from, in one step.
pub(super) fn store_with_scene(
    file: &RunFile,
    scene: &Scene,
    group: Group,
    record: &GroupRecord,
    write: impl FnOnce(&mut GroupWriter<'_>) -> Result<(), StoreError>,
) -> Result<(), StageError> {
    let mut transaction = Transaction::begin(file)?;
    let of_scene = GroupRecord {
        settings: String::new(),
        input_digest: String::new(),
        seconds: 0.0,
        ..record.clone()
    };
    transaction.write(SCENE, &of_scene, |writer| {
        format::write_scene(writer, scene)
    })?;
    transaction.write(group, record, write)?;
    transaction.commit()?;
    Ok(())
}

/// What a commit takes before one is measured, in s.
pub(crate) const FIRST_COMMIT_SECONDS: f64 = 0.02;

/// At most one part in so many of the time goes into checkpoints.
const CHECKPOINT_SHARE: f64 = 20.0;

/// The checkpoints of one solve, adaptive run or sweep.
pub(crate) struct Checkpoints {
    last: Instant,
    /// What writing one takes.
    cost: f64,
}

impl Checkpoints {
    /// Of what begins now; `cost` is what writing one takes, in s.
    pub(crate) fn new(cost: f64) -> Self {
        Self {
            last: Instant::now(),
            cost,
        }
    }

    /// How long it takes until one is worth the time.
    pub(crate) fn due_in(&self) -> Duration {
        let interval = Duration::from_secs_f64(CHECKPOINT_SHARE * self.cost);
        interval.saturating_sub(self.last.elapsed())
    }

    /// Writes one if it is worth the time. A checkpoint that cannot be written is no reason to
    /// give up: storing what it is all about will say what is wrong.
    pub(crate) fn keep(&mut self, write: impl FnOnce() -> Result<(), StageError>) {
        if !self.due_in().is_zero() {
            return;
        }
        let started = Instant::now();
        let _ = write();
        self.cost = started.elapsed().as_secs_f64();
        self.last = Instant::now();
    }
}

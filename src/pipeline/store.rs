//! The run file of a session: what of it is fresh, and how computed stages get into it.

use std::{
    path::Path,
    sync::Arc,
    time::{Duration, Instant},
};

use contact3d::{history::StepRecord, scene::Scene, solver::OuterState};
use runfile::{
    Group, GroupRecord, GroupWriter, Home, Reader, RunFile, StoreError, StoredGroup, Transaction,
};

use super::{
    AssemblyFile, Commit, Freshness, Performed, StageError, StageState,
    change::{AfterWriting, BackgroundWrite, ComputedStage, Unfinished, Update, WriteResult},
    freshness::{StartedFrom, input_digest, states_from},
    session::Task,
    solve::StartFrom,
    stages::Output,
    undo::Undo,
};
use crate::format::{self, CHECKPOINT, HISTORY, LAYOUT, SCENE, Stage};

/// Seconds of work that may wait to be stored in one commit: an interruption costs no more than that.
const SHORT_RUN: f64 = 10.0;

/// A locked run file.
#[derive(Debug)]
pub(super) struct Store {
    /// What is written beside the stage at work; it ends before the lock does.
    ahead: Option<BackgroundWrite>,
    pub(super) file: RunFile,
    /// Where assembled data are kept.
    pub(super) assembly_file: AssemblyFile,
    /// Digests of the stages that the stage at work builds on, as they were when it began.
    upstream: Vec<(Stage, String)>,
    /// Stages that are computed but not yet stored for good.
    pending: Vec<Arc<ComputedStage>>,
    /// What the last commit of this process took.
    last_store_seconds: f64,
    /// The run file as it was before the command at work.
    pub(super) undo: Undo,
}

impl Store {
    pub(super) fn new(file: RunFile) -> Self {
        Self {
            ahead: None,
            file,
            assembly_file: AssemblyFile::default(),
            upstream: Vec::new(),
            pending: Vec::new(),
            last_store_seconds: 0.0,
            undo: Undo::default(),
        }
    }

    pub(super) fn path(&self) -> &Path {
        self.file.path()
    }

    pub(super) fn reader(&self) -> Result<Reader, StoreError> {
        Reader::open(self.path(), LAYOUT)
    }

    pub(super) fn last_store_seconds(&self) -> f64 {
        self.last_store_seconds
    }

    /// The state of every stage with respect to a task; all missing in a new file.
    pub(super) fn states(&self, task: &Task) -> Result<Vec<StageState>, StoreError> {
        match self.reader() {
            Ok(reader) => Ok(states_in(Some(&reader), task)),
            Err(StoreError::NotFound { .. }) => Ok(states_in(None, task)),
            Err(error) => Err(error),
        }
    }

    /// Refuses to begin a stage on anything but fresh ones, and remembers which these were.
    pub(super) fn require_fresh_before(
        &mut self,
        stage: Stage,
        task: &Task,
    ) -> Result<(), StageError> {
        let is_stored = |state: &StageState| {
            let mut pending = self.pending.iter();
            pending.all(|pending| pending.stage() != state.stage)
        };
        let (fresh, bad): (Vec<StageState>, Vec<StageState>) = self
            .states(task)?
            .into_iter()
            .filter(|state| state.stage < stage)
            .filter(is_stored)
            .partition(|state| state.freshness == Freshness::Fresh);
        match bad.into_iter().next() {
            None => {
                let digest = |state: StageState| Some((state.stage, state.stored?.digest));
                self.upstream = fresh.into_iter().filter_map(digest).collect();
                Ok(())
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
    pub(super) fn require_unchanged(&self, task: &Task) -> Result<(), StoreError> {
        self.require_upstream(&self.states(task)?)
    }

    fn require_upstream(&self, states: &[StageState]) -> Result<(), StoreError> {
        let holds = |(stage, digest): &(Stage, String)| {
            let mut stored = states
                .iter()
                .filter_map(|s| Some((s.stage, s.stored.as_ref()?)));
            stored.any(|(other, stored)| other == *stage && stored.digest == *digest)
        };
        if self.upstream.iter().all(holds) {
            Ok(())
        } else {
            Err(StoreError::Changed {
                file: self.path().to_owned(),
            })
        }
    }

    /// Stores a stage just computed with the scene and what is pending, at once or together with
    /// the next one.
    pub(super) fn keep(
        &mut self,
        output: Output,
        started: Instant,
        commit: Commit,
        task: &Task,
    ) -> Result<Performed, StageError> {
        let stage = output.stage();
        let seconds = started.elapsed().as_secs_f64();
        let is_last = output.is_last();
        let storing = Instant::now();
        self.pending.push(Arc::new(ComputedStage::new(
            output,
            seconds,
            self.assembly_file,
            task,
        )));
        match commit {
            Commit::Held => {}
            Commit::WithNextIfCheap if !is_last => self.store_beside(stage, task)?,
            Commit::Now | Commit::WithNextIfCheap => self.commit(task, None)?,
        }
        Ok(Performed {
            stage,
            compute_seconds: seconds,
            store_seconds: storing.elapsed().as_secs_f64(),
        })
    }

    /// Stores what waits while the next stage computes: for good where it took long, and otherwise as the beginning of the next
    /// commit, once the long stages before a solve are there. On one processor a stage that took long is stored at once.
    fn store_beside(&mut self, stage: Stage, task: &Task) -> Result<(), StageError> {
        let waiting = &self.pending[self.ahead.as_ref().map_or(0, BackgroundWrite::commits)..];
        let waiting: f64 = waiting.iter().map(|pending| pending.seconds()).sum();
        let is_long = waiting >= self.last_store_seconds.max(SHORT_RUN);
        if task.threads == 1 {
            return if is_long {
                self.commit(task, None)
            } else {
                Ok(())
            };
        }
        if is_long {
            self.settle()?;
            self.undo.before_commit(&self.file)?;
        } else if stage != Stage::Load || self.ahead.is_some() {
            return Ok(());
        }
        let change = self.begin(task)?;
        let then = if is_long {
            AfterWriting::Commit
        } else {
            AfterWriting::Wait
        };
        self.ahead = BackgroundWrite::new(change, self.pending.clone(), then);
        Ok(())
    }

    /// Stores what waits.
    pub(super) fn store_pending(&mut self, task: &Task) -> Result<(), StageError> {
        if self.pending.is_empty() {
            return Ok(());
        }
        self.commit(task, None)
    }

    /// Gives up what waits.
    pub(super) fn discard_pending(&mut self) {
        self.ahead = None;
        self.pending.clear();
    }

    /// Stores the state of an unfinished solve, with what is pending.
    pub(super) fn write_checkpoint(
        &mut self,
        task: &Task,
        state: &OuterState,
    ) -> Result<(), StageError> {
        self.commit(task, Some(Unfinished::Solve(state)))
    }

    /// Stores the increments of an unfinished load history, with what is pending.
    pub(super) fn write_history(
        &mut self,
        task: &Task,
        records: &[StepRecord],
    ) -> Result<(), StageError> {
        self.commit(task, Some(Unfinished::History(records)))
    }

    fn begin(&self, task: &Task) -> Result<Update, StageError> {
        let transaction = Transaction::begin(&self.file)?;
        let states = states_in(transaction.previous(), task);
        self.require_upstream(&states)?;
        Ok(Update::new(transaction, states, self.assembly_file, task)?)
    }

    /// Waits for what is written beside: a change that has begun, unless it is stored for good.
    pub(super) fn settle(&mut self) -> Result<Option<Update>, StageError> {
        let Some(ahead) = self.ahead.take() else {
            return Ok(None);
        };
        match ahead.join()? {
            WriteResult::Begun(change) => Ok(Some(*change)),
            WriteResult::Committed {
                changed,
                seconds,
                committed,
            } => {
                self.undo.after_commit(&self.file, &changed);
                self.pending.drain(..changed.len());
                self.last_store_seconds = seconds;
                committed.map(|()| None).map_err(StageError::from)
            }
        }
    }

    fn commit(
        &mut self,
        task: &Task,
        unfinished: Option<Unfinished<'_>>,
    ) -> Result<(), StageError> {
        let storing = Instant::now();
        let mut change = match self.settle()? {
            Some(begun) => begun,
            None => self.begin(task)?,
        };
        for pending in &self.pending[change.changed().len()..] {
            change.write(pending)?;
        }
        if let Some(unfinished) = unfinished {
            change.write_unfinished(unfinished, task)?;
        }
        let (transaction, changed) = change.into_parts();
        self.end(transaction, &changed)?;
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
        self.undo.before_commit(&self.file)?;
        let committed = transaction.commit();
        if !matches!(&committed, Err(error) if !error.is_after_storing()) {
            self.undo.after_commit(&self.file, changed);
        }
        committed
    }

    /// The state that a killed solve of the same problem left. A damaged one costs time only.
    pub(super) fn read_checkpoint(&self, task: &Task) -> Result<Option<OuterState>, StageError> {
        let reader = self.unfinished(CHECKPOINT, task)?;
        Ok(reader.and_then(|reader| format::read_checkpoint(&reader).ok()))
    }

    /// The increments that a killed solve of the same load history left. Damaged ones cost time only.
    pub(super) fn read_history(&self, task: &Task) -> Result<Vec<StepRecord>, StageError> {
        let reader = self.unfinished(HISTORY, task)?;
        let records =
            reader.and_then(|reader| format::read_history(&reader, &task.input.scene).ok());
        Ok(records.unwrap_or_default())
    }

    /// The file, where it holds a group that a solve of the same problem left.
    fn unfinished(&self, group: Group, task: &Task) -> Result<Option<Reader>, StageError> {
        let reader = match self.reader() {
            Err(StoreError::NotFound { .. }) => return Ok(None),
            opened => opened?,
        };
        let Ok(Some(left)) = reader.whole_group(group) else {
            return Ok(None);
        };
        let states = self.states(task)?.into_iter();
        let stored: Vec<(Stage, StoredGroup)> = states
            .filter_map(|state| Some((state.stage, state.stored?)))
            .collect();
        let fits = left.record.input_digest == input_digest_of(Stage::Solve, task, &stored);
        Ok(fits.then_some(reader))
    }
}

/// The states in a file that may not exist yet.
fn states_in(reader: Option<&Reader>, task: &Task) -> Vec<StageState> {
    let start = match &task.start {
        StartFrom::Any => StartedFrom::AsStored,
        StartFrom::Zero | StartFrom::Given { .. } => StartedFrom::Given(task.start.digest()),
    };
    states_from(reader, &task.input.scene, task.refinement.digest(), start)
}

/// The digest of what a stage is computed from, given what is stored of the stages before it.
pub(super) fn input_digest_of(
    stage: Stage,
    task: &Task,
    stored: &[(Stage, StoredGroup)],
) -> String {
    let upstream = stored.iter().filter(|(earlier, _)| *earlier < stage);
    let upstream: Vec<&StoredGroup> = upstream.map(|(_, stored)| stored).collect();
    input_digest(stage, &task.settings(stage), &upstream)
}

/// Writes the scene of a task.
pub(super) fn write_scene(transaction: &mut Transaction, task: &Task) -> Result<(), StoreError> {
    let record = task.record(String::new(), 0.0, String::new());
    write_group(transaction, SCENE, Home::RunFile, &record, |writer| {
        format::write_scene(writer, &task.input.scene)
    })?;
    Ok(())
}

/// Writes one group and returns its digest.
pub(super) fn write_group(
    transaction: &mut Transaction,
    group: Group,
    home: Home,
    record: &GroupRecord,
    write: impl FnOnce(&mut GroupWriter<'_>) -> Result<(), StoreError>,
) -> Result<String, StoreError> {
    let mut writer = transaction.group(group, home)?;
    write(&mut writer)?;
    writer.finish(record)
}

impl Task {
    pub(super) fn record(
        &self,
        settings: String,
        seconds: f64,
        input_digest: String,
    ) -> GroupRecord {
        GroupRecord::ended(settings, input_digest, seconds, self.threads)
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
    write_group(
        &mut transaction,
        format::SCENE,
        Home::RunFile,
        &of_scene,
        |writer| format::write_scene(writer, scene),
    )?;
    write_group(&mut transaction, group, Home::RunFile, record, write)?;
    transaction.commit()?;
    Ok(())
}

/// At most one part in so many of the time goes into checkpoints.
const SHARE: f64 = 20.0;

/// The checkpoints of one solve, or of one adaptive run.
pub(super) struct Checkpoints {
    last: Instant,
    /// What writing one takes.
    cost: f64,
}

impl Checkpoints {
    /// Of a solve that begins now; `cost` is what writing one takes, in s.
    pub(super) fn new(cost: f64) -> Self {
        Self {
            last: Instant::now(),
            cost,
        }
    }

    /// Writes one if it is worth the time. A checkpoint that cannot be written is no reason to
    /// give up a solve: storing the solution will say what is wrong.
    pub(super) fn keep(&mut self, write: impl FnOnce() -> Result<(), StageError>) {
        if self.last.elapsed() < Duration::from_secs_f64(SHARE * self.cost) {
            return;
        }
        let started = Instant::now();
        let _ = write();
        self.cost = started.elapsed().as_secs_f64();
        self.last = Instant::now();
    }
}

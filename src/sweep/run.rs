//! The cases of a sweep, run in parallel.

use std::{
    collections::{BTreeMap, VecDeque},
    fs::File,
    path::Path,
    sync::{
        Mutex, PoisonError,
        mpsc::{self, Receiver, RecvTimeoutError, Sender},
    },
    thread,
    time::Duration,
};

use contact3d::scene::Scene;
use runfile::{Reader, StoreError};

use super::{
    Plan,
    folder::{self, operator_turn},
    operators::Operators,
    summary,
};
use crate::{
    format::{self, LAYOUT, Stage},
    output::Folder,
    pipeline::{
        Checkpoints, FIRST_COMMIT_SECONDS, Session, StageError, StoreWhen, operator_settings,
        scene_bytes,
    },
    report::SolvedRun,
};

/// How a sweep is run.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Cases at work at the same time.
    pub jobs: usize,
    /// Threads of this process, as every run file records.
    pub threads: usize,
    /// Whether cases that failed before are tried again.
    pub retry_failed: bool,
    /// Whether every run file holds all its data itself.
    pub self_contained: bool,
    /// Bytes of memory for assembled problems; one is always held.
    pub memory: u64,
}

/// What became of one case.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// It was finished before.
    Kept,
    /// It was computed; the warnings of its solution.
    Computed(Vec<String>),
    /// It failed, now or before; the error.
    Failed(String),
    /// Another process is at work on it.
    Busy,
}

impl Event {
    /// It in a word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::Computed(_) => "computed",
            Self::Failed(_) => "failed",
            Self::Busy => "busy",
        }
    }
}

/// How a sweep ended.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Outcome {
    /// How many cases became what, by its word.
    pub counts: BTreeMap<&'static str, usize>,
    /// Finished cases, by their number in the plan, whose solve did not converge or whose mesh does not meet its target, with their status.
    pub not_converged: Vec<(usize, String)>,
    /// Warnings of the solutions computed, with the numbers of their cases in the plan.
    pub warnings: Vec<(usize, String)>,
}

/// Runs all cases that are not finished and writes the tables, also while cases end; `observe` sees every case by its index.
///
/// Cases run in threads of their own, not in rayon tasks: a case waits for others, and a rayon task
/// that waits may hold up the very work it waits for. Parallel loops inside a case share rayon's threads.
///
/// # Errors
/// A busy folder, or tables that cannot be written. Failed cases are recorded, not returned.
pub fn run(
    plan: &Plan,
    folder: &Path,
    options: &Options,
    observe: &dyn Fn(usize, &Event),
) -> Result<Outcome, StageError> {
    folder::refuse_others(plan, folder)?;
    let _folder = Folder::make(folder)?;
    let _lock = folder::lock(folder, File::try_lock)?;
    let write = || summary::write(plan, folder);
    let failed = |error| StageError::NotSummedUp(Box::new(error));
    if !folder.join(summary::SUMMARY_FILE).exists() {
        // The folder is this sweep's from the start, also if it is interrupted before its first table.
        write().map_err(failed)?;
    }
    let operators = Operators::new(needed(plan), options.memory);
    let queue = Mutex::new(chains(plan));
    let work = |ended: Sender<(usize, Event)>| {
        while let Some(chain) = next(&queue) {
            for index in chain {
                let event = attempt(plan, index, folder, options, &operators);
                operators.done(&operator_key(&plan.cases[index].scene.scene));
                let _ = ended.send((index, event));
            }
        }
    };
    let mut outcome = thread::scope(|scope| {
        let (ended, events) = mpsc::channel();
        let start = |_| {
            let (work, ended) = (&work, ended.clone());
            thread::Builder::new().spawn_scoped(scope, move || work(ended))
        };
        let started = (0..options.jobs.max(1)).map(start);
        match started.filter(Result::is_ok).count() {
            0 => work(ended),
            _ => drop(ended),
        }
        gather(&events, observe, || write().map(drop))
    });
    outcome.warnings.sort();
    outcome.not_converged = write().map_err(failed)?;
    Ok(outcome)
}

/// Counts the cases that end, and writes the tables of them where that costs no more than a twentieth of the time: a killed sweep
/// shows them.
fn gather(
    events: &Receiver<(usize, Event)>,
    observe: &dyn Fn(usize, &Event),
    write: impl Fn() -> Result<(), StageError>,
) -> Outcome {
    let mut tables = Checkpoints::new(FIRST_COMMIT_SECONDS);
    let mut outcome = Outcome::default();
    let mut wait = Duration::MAX;
    loop {
        match events.recv_timeout(wait) {
            Ok((index, event)) => {
                outcome.count(index, &event);
                observe(index, &event);
                wait = tables.due_in();
            }
            Err(RecvTimeoutError::Timeout) => {
                tables.keep(&write);
                wait = Duration::MAX;
            }
            Err(RecvTimeoutError::Disconnected) => return outcome,
        }
    }
}

/// Runs one case of a sweep, with the cases it starts from where they are not finished.
///
/// # Errors
/// A name that the plan does not have, a busy folder or run file, and whatever stops the case.
pub fn run_case(
    plan: &Plan,
    folder: &Path,
    id: &str,
    options: &Options,
) -> Result<Event, StageError> {
    let index = plan.find(id)?;
    let _folder = Folder::make(folder)?;
    let _lock = folder::lock(folder, File::try_lock_shared)?;
    let operators = Operators::new(BTreeMap::new(), options.memory);
    let mut chain = vec![index];
    while let Some(start) = chain.last().and_then(|&last| plan.cases[last].start) {
        chain.push(start);
    }
    let mut event = Event::Kept;
    for &index in chain.iter().rev() {
        event = attempt(plan, index, folder, options, &operators);
    }
    Ok(event)
}

/// Cases that must follow one another, those with a common operator next to each other.
fn chains(plan: &Plan) -> VecDeque<Vec<usize>> {
    let mut chains: Vec<Vec<usize>> = Vec::new();
    for (index, case) in plan.cases.iter().enumerate() {
        match (case.start, chains.last_mut()) {
            (Some(_), Some(chain)) => chain.push(index),
            _ => chains.push(vec![index]),
        }
    }
    let mut first_use = BTreeMap::new();
    for (index, case) in plan.cases.iter().enumerate() {
        let key = operator_key(&case.scene.scene);
        first_use.entry(key).or_insert(index);
    }
    let rank = |chain: &Vec<usize>| first_use[&operator_key(&plan.cases[chain[0]].scene.scene)];
    chains.sort_by_key(rank);
    chains.into()
}

/// For every operator the number of cases that use it, and its bytes.
fn needed(plan: &Plan) -> BTreeMap<String, (usize, u64)> {
    let mut needed = BTreeMap::new();
    for case in &plan.cases {
        let scene = &case.scene;
        let entry = needed
            .entry(operator_key(&scene.scene))
            .or_insert_with(|| (0, scene_bytes(scene)));
        entry.0 += 1;
    }
    needed
}

fn next(queue: &Mutex<VecDeque<Vec<usize>>>) -> Option<Vec<usize>> {
    let mut queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
    queue.pop_front()
}

fn attempt(
    plan: &Plan,
    index: usize,
    folder: &Path,
    options: &Options,
    operators: &Operators,
) -> Event {
    let file = plan.cases[index].file(folder);
    if let (false, Some(error)) = (options.retry_failed, folder::read_failure(&file)) {
        return Event::Failed(error);
    }
    match run_stale(plan, index, folder, options, operators) {
        Ok(event) => match folder::forget_failure(&file) {
            Ok(()) => event,
            Err(error) => Event::Failed(error.to_string()),
        },
        Err(StageError::Store(StoreError::Busy { .. })) => Event::Busy,
        // The case is not at fault, and the next run tries it again.
        Err(error) if error.is_of_machine() || error.is_of_other_programs() => {
            Event::Failed(error.with_help())
        }
        Err(error) => {
            let message = error.with_help();
            match folder::record_failure(&file, &message) {
                Ok(()) => Event::Failed(message),
                Err(unrecorded) => Event::Failed(format!("{message}; not recorded: {unrecorded}")),
            }
        }
    }
}

impl Outcome {
    fn count(&mut self, index: usize, event: &Event) {
        *self.counts.entry(event.word()).or_default() += 1;
        if let Event::Computed(warnings) = event {
            let warnings = warnings.iter().map(|words| (index, words.clone()));
            self.warnings.extend(warnings);
        }
    }

    /// How many cases became what a word says.
    pub fn count_of(&self, word: &str) -> usize {
        self.counts.get(word).copied().unwrap_or(0)
    }
}

/// What two cases must have in common to share an operator.
fn operator_key(scene: &Scene) -> String {
    let digest = blake3::hash(operator_settings(scene).as_bytes());
    digest.to_hex().to_string()
}

/// Runs what is not fresh of a case.
fn run_stale(
    plan: &Plan,
    index: usize,
    folder: &Path,
    options: &Options,
    operators: &Operators,
) -> Result<Event, StageError> {
    let case = &plan.cases[index];
    let mut session = Session::with_scene(&case.file(folder), case.scene.clone(), options.threads)?;
    if case.scene.scene.adapt.is_some() {
        let (_, performed) = session.adapt(None, &mut |_| {})?;
        if options.self_contained {
            session.embed_assembly()?;
        }
        return if performed.is_empty() {
            Ok(Event::Kept)
        } else {
            computed(&mut session)
        };
    }
    if let Some(start) = case.start {
        session.start_from(multiplier(&plan.cases[start].file(folder))?.unwrap_or_default());
    }
    let mut event = Event::Kept;
    if !session.is_done()? {
        let key = operator_key(&case.scene.scene);
        let outcome = operators
            .prepare(&key, |known| {
                let turn = operator_turn(folder, &key)?;
                let operator = session.prepare_operator(known);
                drop(turn);
                operator
            })
            .and_then(|()| compute(&mut session));
        operators.release(&key);
        outcome?;
        event = computed(&mut session)?;
    }
    if options.self_contained {
        session.embed_assembly()?;
    }
    Ok(event)
}

/// That a case was computed, with the warnings of its solution.
fn computed(session: &mut Session) -> Result<Event, StageError> {
    let results = session.results()?;
    let run = SolvedRun::new(session.scene(), &results);
    Ok(Event::Computed(run.cautions))
}

/// Loads, solution and report, each if it or an earlier one is not fresh.
fn compute(session: &mut Session) -> Result<(), StageError> {
    let commit = StoreWhen::Deferred;
    let mut stale = false;
    for state in session.states()? {
        stale |= !state.is_fresh();
        if !stale {
            continue;
        }
        session.perform(state.stage, commit, &mut |_| {})?;
    }
    Ok(())
}

/// The multipliers of a solved case; `None` if it has none or did not converge.
fn multiplier(run_file: &Path) -> Result<Option<Vec<f64>>, StageError> {
    let Ok(reader) = Reader::open(run_file, LAYOUT) else {
        return Ok(None);
    };
    if !matches!(reader.group_record(Stage::Post.group()), Ok(Some(_))) {
        return Ok(None);
    }
    let (status, multiplier) = format::read_multiplier(&reader)?;
    Ok(status
        .is_solved()
        .then_some(multiplier)
        .filter(|m| !m.is_empty()))
}

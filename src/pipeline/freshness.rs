//! Which stages are fresh, and stored results that contradict each other.
//!
//! Whether what a file says of its solution follows from its arrays: digests tell only that nothing was changed since they
//! were made.

use std::path::Path;

use contact3d::{
    adaptation::{Adaptation, AdaptiveStatus},
    mesh::RefinedLevel,
    post::{Certificate, ContactReport},
    scene::{Increment, Scene, SceneFile},
};
use runfile::{Reader, StoreError, StoredGroup};

use super::{
    StageError,
    adapt::{read_levels, refinement_in_force},
    read_results,
    settings::{refinement_digest, settings, start_digest},
};
use crate::format::{self, HISTORY, LAYOUT, Stage};

/// Whether a stored stage can be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Freshness {
    /// Never run.
    Missing,
    /// Computed from the present scene and the present upstream stages.
    Fresh,
    /// Computed from something else, for the stated reason.
    Stale(String),
}

impl Freshness {
    /// The state in one word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Missing => "missing",
            Self::Fresh => "fresh",
            Self::Stale(_) => "stale",
        }
    }

    /// What a message says of a stage that is not fresh.
    pub fn why(&self) -> String {
        match self {
            Self::Missing => "it is missing".into(),
            Self::Fresh => "it is fresh".into(),
            Self::Stale(why) => format!("it is stale: {why}"),
        }
    }
}

/// One stage of a run file.
#[derive(Debug, Clone)]
pub struct StageState {
    /// The stage.
    pub stage: Stage,
    /// Whether it can be used.
    pub freshness: Freshness,
    /// How it was run, if it was.
    pub stored: Option<StoredGroup>,
}

impl StageState {
    /// Whether it can be used.
    pub fn is_fresh(&self) -> bool {
        self.freshness == Freshness::Fresh
    }
}

/// A run file opened for reading, without a lock.
#[derive(Debug)]
pub struct OpenRun {
    /// The file.
    pub reader: Reader,
    /// The scene that it holds.
    pub input: SceneFile,
    /// Its stages, upstream first. A stage whose own file cannot be used is a state, not an error.
    pub states: Vec<StageState>,
    /// The levels that it holds for its scene, and how they stood.
    pub levels: Option<(Adaptation, AdaptiveStatus)>,
}

impl OpenRun {
    /// Opens a file.
    pub fn open(path: &Path) -> Result<Self, StageError> {
        Self::of(Reader::open(path, LAYOUT)?, path)
    }

    /// An open file at a path.
    pub fn of(reader: Reader, path: &Path) -> Result<Self, StageError> {
        let input = format::read_scene(&reader, path)?;
        let levels = read_levels(&reader, &input.scene)?;
        let refinement = refinement_in_force(levels.as_ref(), &input.scene);
        let states = states_from(Some(&reader), &input.scene, &refinement, None)?;
        Ok(Self {
            reader,
            input,
            states,
            levels,
        })
    }

    /// Whether a stage can be used.
    pub fn is_fresh(&self, stage: Stage) -> bool {
        let mut states = self.states.iter();
        states.any(|state| state.stage == stage && state.is_fresh())
    }

    /// The increments of its load history that an interrupted solve left, with which the next one begins.
    pub fn unfinished_increments(&self) -> Result<Vec<Increment>, StageError> {
        let (reader, scene) = (&self.reader, &self.input.scene);
        let left = match self.is_fresh(Stage::Solve) {
            true => None,
            false => reader.group_record(HISTORY)?,
        };
        let goes_on = |left: &StoredGroup| {
            let refinement = refinement_in_force(self.levels.as_ref(), scene);
            is_left_by(scene, &refinement, None, left, &self.states)
        };
        let n_left = match left.filter(goes_on) {
            Some(_) => format::n_increments(reader)?,
            None => 0,
        };
        Ok(scene.increments().into_iter().take(n_left).collect())
    }

    /// The first stage up to some that cannot be used.
    fn unusable(&self, upto: Stage) -> Option<&StageState> {
        let mut states = self.states.iter();
        states.find(|state| state.stage <= upto && !state.is_fresh())
    }

    /// Refuses a file whose stages up to some are not fresh.
    pub fn require_fresh(&self, upto: Stage, what: &str) -> Result<(), StageError> {
        self.unusable(upto).map_or(Ok(()), |state| {
            Err(StageError::Unfit {
                file: self.reader.path().to_owned(),
                reason: format!(
                    "expected a {what} file, but its `{}` cannot be used, {}; run `contact3d-pipe run` first",
                    state.stage.word(),
                    state.freshness.why()
                ),
            })
        })
    }
}

/// Digest of everything a stage is computed from: its settings and the digests of all upstream
/// stages among those that are stored.
pub(super) fn input_digest(
    stage: Stage,
    settings: &str,
    stored: &[(Stage, StoredGroup)],
) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(stage.word().as_bytes());
    hasher.update(settings.as_bytes());
    for (_, stored) in stored.iter().filter(|(earlier, _)| *earlier < stage) {
        hasher.update(stored.digest.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

/// The state of every stage of a file that may not exist yet with respect to a scene, with a solve that must have started from
/// certain multipliers; `None` for any.
pub(super) fn states_from(
    reader: Option<&Reader>,
    scene: &Scene,
    refinement: &[RefinedLevel],
    start: Option<&[f64]>,
) -> Result<Vec<StageState>, StoreError> {
    let refinement = refinement_digest(refinement);
    let mut states: Vec<StageState> = Vec::new();
    for stage in Stage::ALL {
        let stored = reader.map_or(Ok(None), |reader| reader.group_record(stage.group()));
        let (stored, freshness) = match stored {
            Ok(Some(stored)) => {
                let freshness = judge(stage, scene, refinement.as_deref(), start, &stored, &states);
                (Some(stored), freshness)
            }
            Ok(None) => (None, Freshness::Missing),
            Err(StoreError::Linked { problem, .. }) => {
                (None, Freshness::Stale(problem.to_string()))
            }
            Err(error) => return Err(error),
        };
        states.push(StageState {
            stage,
            freshness,
            stored,
        });
    }
    Ok(states)
}

/// Whether a group is what a killed solve of a scene left, with stages before it that are as they were. Stages that wait may replace those
/// of another problem, or of another level: then the stored ones are not fresh.
pub(super) fn is_left_by(
    scene: &Scene,
    refinement: &[RefinedLevel],
    start: Option<&[f64]>,
    left: &StoredGroup,
    states: &[StageState],
) -> bool {
    let before = states.partition_point(|state| state.stage < Stage::Solve);
    let refinement = refinement_digest(refinement);
    let (stage, refinement) = (Stage::Solve, refinement.as_deref());
    judge(stage, scene, refinement, start, left, &states[..before]) == Freshness::Fresh
}

fn judge(
    stage: Stage,
    scene: &Scene,
    refinement: Option<&str>,
    start: Option<&[f64]>,
    stored: &StoredGroup,
    upstream: &[StageState],
) -> Freshness {
    if let Some(bad) = upstream.iter().find(|state| !state.is_fresh()) {
        return Freshness::Stale(format!(
            "`{}` is {}",
            bad.stage.word(),
            bad.freshness.word()
        ));
    }
    let records = upstream.iter();
    let records: Vec<(Stage, StoredGroup)> = records
        .filter_map(|state| Some((state.stage, state.stored.clone()?)))
        .collect();
    let stored_start = stored_start(&stored.record.settings);
    let start = start.map_or_else(|| stored_start.clone(), start_digest);
    let with = |start: &Option<String>| {
        let start = start.as_deref();
        settings(stage, scene, refinement, start)
    };
    let settings_now = with(&start);
    if stored.record.input_digest == input_digest(stage, &settings_now, &records) {
        Freshness::Fresh
    } else if stored.record.settings == with(&stored_start)
        && stored.record.settings != settings_now
    {
        Freshness::Stale("it started from other multipliers".into())
    } else if stored.record.settings != settings_now {
        Freshness::Stale("its part of the scene has changed".into())
    } else {
        Freshness::Stale("an earlier stage was run again with another result".into())
    }
}

/// The digest of the multipliers that a solve with these settings started from.
fn stored_start(settings: &str) -> Option<String> {
    let table: toml::Table = settings.parse().ok()?;
    Some(table.get("beside")?.get("start")?.as_str()?.to_owned())
}

/// Difference of two figures of a certificate, each a share of its yardstick, that versions of the program may have by
/// summing in another order; figures of right answers lie below it.
const SUMMED: f64 = 1e-9;

/// The contradictions between the certificate that a file's arrays have, its status, and the certificate it holds, a sentence
/// each. None without a fresh solution.
pub fn contradictions(run_file: &Path) -> Result<Vec<String>, StageError> {
    let reader = Reader::open(run_file, LAYOUT)?;
    if reader.group_record(Stage::Solve.group())?.is_none() {
        return Ok(Vec::new());
    }
    let run = OpenRun::of(reader, run_file)?;
    if run.unusable(Stage::Solve).is_some() {
        return Ok(Vec::new());
    }
    let results = read_results(&run.reader, &run.input)?;
    let report = &results.report;
    let mut found: Vec<String> = against_status(&run.reader, report)?.into_iter().collect();
    if run.is_fresh(Stage::Post) {
        found.extend(against_stored(&run.reader, &report.certificate)?);
    }
    let named = |words: String| format!("{}: {words}", run_file.display());
    Ok(found.into_iter().map(named).collect())
}

/// What takes back the claim of a solve whose status says that it is solved.
fn against_status(reader: &Reader, report: &ContactReport) -> Result<Option<String>, StageError> {
    let (stored, _) = format::read_multiplier(reader)?;
    let failure = report
        .failed_check
        .filter(|_| stored.is_solved() && report.is_broken());
    Ok(failure.map(|failure| {
        format!(
            "/solve says {}, but its arrays are no solution: {failure}; run `contact3d-pipe solve` again",
            stored.word()
        )
    }))
}

fn against_stored(reader: &Reader, certificate: &Certificate) -> Result<Vec<String>, StageError> {
    let mut found = Vec::new();
    for (name, value) in certificate.figures() {
        let Some(stored) = format::read_certificate(reader, name)? else {
            continue;
        };
        let fits = stored.is_nan() && value.is_nan()
            || (stored - value).abs() <= SUMMED * (1.0 + value.abs());
        if !fits {
            found.push(format!(
                "/post/certificate/{name}: expected {value:.1e}, as the arrays of /solve have it, found {stored:.1e}; run `contact3d-pipe post` again"
            ));
        }
    }
    Ok(found)
}

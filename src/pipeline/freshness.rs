//! Whether what a run file holds is what a scene asks for.

use contact3d::scene::Scene;
use runfile::{Reader, StoreError, StoredGroup};

use super::{
    adapt::RefinementInForce,
    stages::{Chosen, settings},
};
use crate::format::{self, Stage};

/// Whether a stored stage can be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Freshness {
    /// Never run.
    Missing,
    /// Computed from the present scene and the present upstream stages.
    Fresh,
    /// Computed from something else, for the stated reason.
    Stale(String),
    /// Not what was written, for the stated reason.
    Damaged(String),
}

impl Freshness {
    /// The state in one word.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Missing => "missing",
            Self::Fresh => "fresh",
            Self::Stale(_) => "stale",
            Self::Damaged(_) => "damaged",
        }
    }

    /// What a message says of a stage that is not fresh.
    #[must_use]
    pub fn why(&self) -> String {
        match self {
            Self::Missing => "it is missing".into(),
            Self::Fresh => "it is fresh".into(),
            Self::Stale(why) => format!("it is stale: {why}"),
            Self::Damaged(why) => format!("it is damaged: {why}"),
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

/// The part of a scene that a stage depends on directly, as TOML, for the body's own mesh and a
/// solve that starts from λ = 0.
///
/// It goes into the stage's input digest: a key that is added to scenes must not show here while it
/// has its default, or every older file goes stale.
#[must_use]
pub fn stage_settings(stage: Stage, scene: &Scene) -> String {
    settings(stage, scene, Chosen::default())
}

/// What tells two scenes apart whose assembled problems differ in more than their loads.
#[must_use]
pub fn operator_settings(scene: &Scene) -> String {
    stage_settings(Stage::Mesh, scene) + &stage_settings(Stage::Assemble, scene)
}

/// Digest of everything a stage is computed from: its settings and the digests of all upstream
/// stages.
pub(super) fn input_digest(stage: Stage, settings: &str, upstream: &[&StoredGroup]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(stage.word().as_bytes());
    hasher.update(settings.as_bytes());
    for stored in upstream {
        hasher.update(stored.digest.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

/// The multipliers that a solve should have started from.
#[derive(Debug, Clone, Copy)]
pub(super) enum StartedFrom<'a> {
    /// Those that the stored solve names.
    AsStored,
    /// These, by their digest; `None` is λ = 0.
    Given(Option<&'a str>),
}

/// The state of every stage of a file with respect to a scene. A stage that is not what was
/// written, or whose own file cannot be used, is a state, not an error.
#[must_use]
pub fn states(reader: &Reader, scene: &Scene) -> Vec<StageState> {
    let refinement = RefinementInForce::stored(Some(reader), scene);
    states_from(
        Some(reader),
        scene,
        refinement.digest(),
        StartedFrom::AsStored,
    )
}

/// As [`states`], of a file that may not exist yet, with a solve that must have started from
/// certain multipliers.
pub(super) fn states_from(
    reader: Option<&Reader>,
    scene: &Scene,
    refinement: Option<&str>,
    start: StartedFrom<'_>,
) -> Vec<StageState> {
    let mut states: Vec<StageState> = Vec::new();
    for stage in Stage::ALL {
        let stored = reader.map_or(Ok(None), |reader| whole(reader, stage));
        let (stored, freshness) = match stored {
            Ok(Some(stored)) => {
                let freshness = judge(stage, scene, refinement, start, &stored, &states);
                (Some(stored), freshness)
            }
            Ok(None) => (None, Freshness::Missing),
            Err(StoreError::Linked { problem, .. }) => {
                (None, Freshness::Stale(problem.to_string()))
            }
            Err(StoreError::Older { .. }) => {
                let why = "an older version wrote it, in a form that cannot be gone on from";
                (None, Freshness::Stale(why.into()))
            }
            Err(error) => (None, Freshness::Damaged(error.to_string())),
        };
        states.push(StageState {
            stage,
            freshness,
            stored,
        });
    }
    states
}

/// A stage with all that belongs to it; the report has a second form for ParaView, the solution of a load history its increments.
fn whole(reader: &Reader, stage: Stage) -> Result<Option<StoredGroup>, StoreError> {
    let stored = reader.whole_group(stage.group())?;
    match stage {
        Stage::Post if stored.is_some() => format::check_vtkhdf(reader)?,
        Stage::Solve if stored.is_some() => format::check_history(reader)?,
        _ => {}
    }
    Ok(stored)
}

fn judge(
    stage: Stage,
    scene: &Scene,
    refinement: Option<&str>,
    start: StartedFrom<'_>,
    stored: &StoredGroup,
    upstream: &[StageState],
) -> Freshness {
    if let Some(bad) = upstream.iter().find(|s| s.freshness != Freshness::Fresh) {
        return Freshness::Stale(format!(
            "`{}` is {}",
            bad.stage.word(),
            bad.freshness.word()
        ));
    }
    let records: Vec<&StoredGroup> = upstream.iter().filter_map(|s| s.stored.as_ref()).collect();
    let stored_start = stored_start(&stored.record.settings);
    let start = match start {
        StartedFrom::AsStored => stored_start.as_deref(),
        StartedFrom::Given(start) => start,
    };
    let with = |start| settings(stage, scene, Chosen { refinement, start });
    let settings_now = with(start);
    if stored.record.input_digest == input_digest(stage, &settings_now, &records) {
        Freshness::Fresh
    } else if stored.record.settings == with(stored_start.as_deref())
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
    Some(table.get("start")?.as_str()?.to_owned())
}

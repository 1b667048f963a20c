use contact3d::scene::{Parameters, Scene};
use runfile::{Reader, StoreError, StoredGroup};
use serde::Serialize;

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

/// The part of the scene that each stage depends on directly.
#[derive(Serialize)]
#[serde(untagged)]
enum Settings<'a> {
    Mesh {
        body: &'a contact3d::scene::Body,
        clamp: &'a [contact3d::scene::Clamp],
        contact_face: Option<&'a str>,
        multipliers: Option<contact3d::scene::MultiplierSpace>,
        parts: Vec<&'a contact3d::scene::Part>,
    },
    Assemble {
        material: &'a contact3d::scene::Material,
        region: &'a [contact3d::scene::Region],
        axis_1: Option<&'a [contact3d::scene::Quantity; 3]>,
        angle: Option<&'a contact3d::scene::Quantity>,
        /// Whether T is assembled, and whether G is.
        friction: bool,
        friction_follows_slip: bool,
        assemble: &'a contact3d::scene::AssembleSettings,
        /// What the formulas here use.
        #[serde(skip_serializing_if = "Parameters::is_empty")]
        parameters: Parameters,
    },
    Load {
        traction: &'a [contact3d::scene::Traction],
        pressure: &'a [contact3d::scene::Pressure],
        body_force: Option<&'a contact3d::scene::BodyForce>,
        gap: Option<&'a contact3d::scene::Quantity>,
        /// What the formulas here use.
        #[serde(skip_serializing_if = "Parameters::is_empty")]
        parameters: Parameters,
    },
    Solve {
        /// Digest of the multipliers the solve started from; none for λ = 0.
        start: Option<&'a str>,
        friction: Option<&'a contact3d::scene::Friction>,
        solve: &'a contact3d::scene::SolveSettings,
        /// What the formulas here use.
        #[serde(skip_serializing_if = "Parameters::is_empty")]
        parameters: Parameters,
    },
    Post {
        friction: Option<&'a contact3d::scene::Friction>,
        /// What the formulas here use.
        #[serde(skip_serializing_if = "Parameters::is_empty")]
        parameters: Parameters,
    },
}

/// Whether a key is one of the axes of friction, which are part of T.
fn of_frame(key: &str) -> bool {
    ["contact.axis_1", "contact.angle"].contains(&key)
}

/// Whether a key is part of the law of friction.
fn of_friction(key: &str) -> bool {
    key.starts_with("friction.")
}

/// The settings of a stage as TOML; `start` names the multipliers that a solve starts from.
pub(super) fn settings(stage: Stage, scene: &Scene, start: Option<&str>) -> String {
    let settings = match stage {
        Stage::Mesh => Settings::Mesh {
            body: &scene.body,
            clamp: &scene.clamps,
            contact_face: scene.contact.as_ref().map(|c| c.face.as_str()),
            multipliers: scene.contact.as_ref().map(|c| c.multipliers),
            parts: scene.regions.iter().map(|region| &region.part).collect(),
        },
        Stage::Assemble => Settings::Assemble {
            material: &scene.material,
            region: &scene.regions,
            axis_1: scene.contact.as_ref().and_then(|c| c.axis_1.as_ref()),
            angle: scene.contact.as_ref().and_then(|c| c.angle.as_ref()),
            friction: scene.friction.is_some(),
            friction_follows_slip: scene
                .friction
                .as_ref()
                .and_then(contact3d::scene::Friction::law)
                .is_some_and(|law| law.depends_on_slip()),
            assemble: &scene.assemble,
            parameters: scene.parameters_used(of_frame),
        },
        Stage::Load => Settings::Load {
            traction: &scene.tractions,
            pressure: &scene.pressures,
            body_force: scene.body_force.as_ref(),
            gap: scene.contact.as_ref().map(|c| &c.gap),
            parameters: scene.parameters_used(|key| !of_frame(key) && !of_friction(key)),
        },
        Stage::Solve => Settings::Solve {
            start,
            friction: scene.friction.as_ref(),
            solve: &scene.solve,
            parameters: scene.parameters_used(of_friction),
        },
        Stage::Post => Settings::Post {
            friction: scene.friction.as_ref(),
            parameters: scene.parameters_used(of_friction),
        },
    };
    let text = toml::to_string(&settings).expect("settings hold only TOML types");
    text + &units_settings(scene)
}

/// The units as settings of every stage, since attributes speak them; nothing for those of a scene that names none,
/// whose stages keep the digests they had before units could be named.
fn units_settings(scene: &Scene) -> String {
    if scene.units.is_default() {
        return String::new();
    }
    let units = toml::to_string(&scene.units).expect("units are words");
    format!("\n[units]\n{units}")
}

/// The part of a scene that a stage depends on directly, as TOML, for a solve that starts from λ = 0.
///
/// It goes into the stage's input digest: a key that is added to scenes must not show here while it has its
/// default, or every older file goes stale.
#[must_use]
pub fn stage_settings(stage: Stage, scene: &Scene) -> String {
    settings(stage, scene, None)
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

/// The state of every stage of a file with respect to a scene. A stage that is not what was written,
/// or whose own file cannot be used, is a state, not an error.
#[must_use]
pub fn states(reader: &Reader, scene: &Scene) -> Vec<StageState> {
    states_from(Some(reader), scene, StartedFrom::AsStored)
}

/// As [`states`], of a file that may not exist yet, with a solve that must have started from certain multipliers.
pub(super) fn states_from(
    reader: Option<&Reader>,
    scene: &Scene,
    start: StartedFrom<'_>,
) -> Vec<StageState> {
    let mut states: Vec<StageState> = Vec::new();
    for stage in Stage::ALL {
        let stored = reader.map_or(Ok(None), |reader| whole(reader, stage));
        let (stored, freshness) = match stored {
            Ok(Some(stored)) => {
                let freshness = judge(stage, scene, start, &stored, &states);
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

/// A stage with all that belongs to it; the report has a second form for ParaView.
fn whole(reader: &Reader, stage: Stage) -> Result<Option<StoredGroup>, StoreError> {
    let stored = reader.whole_group(stage.group())?;
    if stage == Stage::Post && stored.is_some() {
        format::check_vtkhdf(reader)?;
    }
    Ok(stored)
}

fn judge(
    stage: Stage,
    scene: &Scene,
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
    let settings_now = settings(stage, scene, start);
    if stored.record.input_digest == input_digest(stage, &settings_now, &records) {
        Freshness::Fresh
    } else if stored.record.settings == settings(stage, scene, stored_start.as_deref())
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

//! The cases of a sweep, their names and their order.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use contact3d::scene::{SceneFile, to_toml};
use units::Units;

use super::{StageError, SweepError, SweepFile, axes::Steps, folder::relative};
use crate::{
    format::{scene_table, scene_text, set_key},
    output::Inputs,
    pipeline::mesh_files,
};

/// The table of a scene that names its units.
pub(super) const UNITS_KEY: &str = "units";

/// One scene of a sweep.
#[derive(Debug, Clone)]
pub struct Case {
    /// Digest of the full scene, and of the names of the cases it starts from.
    pub id: String,
    /// The values of the axes' keys.
    pub settings: Vec<(String, toml::Value)>,
    /// The scene.
    pub scene: SceneFile,
    /// The case whose multipliers this one starts from, by its index.
    pub start: Option<usize>,
}

/// All cases of a sweep, the last axis fastest.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The cases.
    pub cases: Vec<Case>,
    /// The keys of all axes.
    pub keys: Vec<String>,
    /// The units of all cases.
    pub units: Units,
    /// The files that the plan was read from: no output may replace one of them.
    pub inputs: Inputs,
    /// The sweep file.
    file: PathBuf,
}

impl Case {
    /// The name of the run file in the sweep's folder.
    #[must_use]
    pub fn file_name(&self) -> String {
        format!("{}.h5", self.id)
    }

    /// The case by its name and settings.
    #[must_use]
    pub fn in_words(&self) -> String {
        format!("case {} ({})", self.id, in_words(&self.settings))
    }

    /// The run file.
    #[must_use]
    pub fn file(&self, folder: &Path) -> PathBuf {
        folder.join(self.file_name())
    }
}

impl Plan {
    /// Expands a sweep file into its cases and validates the scene of each.
    ///
    /// # Errors
    /// A sweep or scene that cannot be read, an axis or a value that no scene can have, equal cases.
    pub fn read(path: &Path) -> Result<Self, StageError> {
        let sweep = SweepFile::read(path)?;
        let base = base_scene(&sweep, path)?;
        let table = scene_table(&base.scene);
        let axes = sweep.steps(path, &table)?;
        let keys: Vec<String> = axes.iter().flat_map(|axis| axis.keys.clone()).collect();
        refuse_twice(path, &keys, |index| keys[index].clone())?;
        refuse_units(path, &keys)?;
        let fastest = axes.last().map_or(1, |axis| axis.rows.len());
        let mut cases: Vec<Case> = Vec::new();
        for settings in product(&axes) {
            let index = cases.len();
            let label = format!("case {index} of {}", path.display());
            let scene = changed(&base, path, &label, &settings)?;
            let start = (sweep.warm_start && !index.is_multiple_of(fastest)).then(|| index - 1);
            let id = name(&scene, start.map(|before| cases[before].id.as_str()));
            cases.push(Case {
                id,
                settings,
                scene,
                start,
            });
        }
        let ids: Vec<String> = cases.iter().map(|case| case.id.clone()).collect();
        let settings = |index: usize| in_words(&cases[index].settings);
        refuse_twice(path, &ids, settings)?;
        let scene = path.parent().unwrap_or(Path::new("")).join(&sweep.scene);
        let meshes = cases.iter().flat_map(|case| mesh_files(&case.scene));
        Ok(Self {
            inputs: Inputs::of(meshes.chain([path.to_owned(), scene])),
            file: path.to_owned(),
            cases,
            keys,
            units: base.scene.units,
        })
    }

    /// The sweep file as seen from the folder of its cases, which need not be there yet.
    pub(super) fn sweep_file_from(&self, folder: &Path) -> String {
        let canonical = |path: &Path| {
            let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
            absolute.canonicalize().unwrap_or(absolute)
        };
        let file = relative(&canonical(folder), &canonical(&self.file));
        file.to_string_lossy().into_owned()
    }

    /// The case with a name.
    pub fn find(&self, id: &str) -> Result<usize, StageError> {
        let found = self.cases.iter().position(|case| case.id == id);
        found.ok_or_else(|| StageError::from(SweepError::NoSuchCase { id: id.to_owned() }))
    }

    /// The cases as JSON: name, run file, start, settings.
    #[must_use]
    pub fn json(&self, folder: &Path) -> serde_json::Value {
        let cases = self.cases.iter().map(|case| {
            serde_json::json!({
                "id": case.id,
                "file": case.file(folder),
                "start": case.start.map(|start| &self.cases[start].id),
                "settings": as_json(&case.settings),
            })
        });
        cases.collect()
    }
}

/// The scene with the keys that all cases share.
fn base_scene(sweep: &SweepFile, path: &Path) -> Result<SceneFile, StageError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let scene = SceneFile::read(&folder.join(&sweep.scene))?;
    let fixed = sweep.set.clone().into_iter().collect::<Vec<_>>();
    let label = format!("[set] of {}", path.display());
    changed(&scene, path, &label, &fixed)
}

/// A scene with other values at some keys; `file` says so, at the place that `label` names.
///
/// # Errors
/// A key that leads nowhere, a scene that does not validate.
pub fn changed(
    base: &SceneFile,
    file: &Path,
    label: &str,
    settings: &[(String, toml::Value)],
) -> Result<SceneFile, StageError> {
    if settings.is_empty() {
        return Ok(base.clone());
    }
    let mut table = scene_table(&base.scene);
    for (key, value) in settings {
        set_key(&mut table, key, value.clone()).map_err(|found| {
            StageError::from(SweepError::Axis {
                file: file.to_owned(),
                place: format!("{label}: {key}"),
                expected: "a key of the scene".into(),
                found,
            })
        })?;
    }
    let changes = format!("{label} ({})", in_words(settings));
    Ok(base.changed(&changes, &table.to_string())?)
}

/// Settings as a scene writes them, for messages.
pub(super) fn in_words(settings: &[(String, toml::Value)]) -> String {
    let words: Vec<String> = settings
        .iter()
        .map(|(key, value)| format!("{key} = {}", to_toml(value)))
        .collect();
    words.join(", ")
}

/// Settings as a JSON object.
pub(super) fn as_json(settings: &[(String, toml::Value)]) -> serde_json::Value {
    let pairs = settings.iter();
    let pairs = pairs.map(|(key, value)| (key.clone(), serde_json::json!(value)));
    pairs.collect::<serde_json::Map<_, _>>().into()
}

/// All combinations of the axes' steps.
fn product(axes: &[Steps]) -> Vec<Vec<(String, toml::Value)>> {
    let mut combinations = vec![Vec::new()];
    for axis in axes {
        let extended = combinations.iter().flat_map(|before: &Vec<_>| {
            axis.rows.iter().map(move |row| {
                let pairs = axis.keys.iter().cloned().zip(row.iter().cloned());
                before.iter().cloned().chain(pairs).collect()
            })
        });
        combinations = extended.collect();
    }
    combinations
}

fn name(scene: &SceneFile, start: Option<&str>) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(scene_text(&scene.scene).as_bytes());
    hasher.update(start.unwrap_or_default().as_bytes());
    let digest = hasher.finalize().to_hex();
    // Hexadecimal digits of a case's name: 64 bits tell the cases of a folder apart.
    digest[..16].to_owned()
}

/// Refuses an axis that changes units: nothing is converted, so its cases would have the same numbers, and a table
/// and its charts speak one system.
fn refuse_units(path: &Path, keys: &[String]) -> Result<(), StageError> {
    let names_units = |key: &&String| key.split('.').next() == Some(UNITS_KEY);
    match keys.iter().find(names_units) {
        None => Ok(()),
        Some(key) => Err(StageError::from(SweepError::Axis {
            file: path.to_owned(),
            place: key.clone(),
            expected: "the same units in all cases, named in the scene or under [set]".into(),
            found: "an axis over units, which are only words: nothing is converted".into(),
        })),
    }
}

/// Refuses equal names of keys or cases; `words` says what the one with a number is.
fn refuse_twice(
    path: &Path,
    names: &[String],
    words: impl Fn(usize) -> String,
) -> Result<(), StageError> {
    let mut seen = BTreeMap::new();
    for (index, name) in names.iter().enumerate() {
        if let Some(first) = seen.insert(name, index) {
            return Err(StageError::from(SweepError::Axis {
                file: path.to_owned(),
                place: words(index),
                expected: "every key on one axis, and every case once".into(),
                found: format!("it at numbers {first} and {index}"),
            }));
        }
    }
    Ok(())
}

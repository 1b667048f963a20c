//! Suites of hard cases: an index of scenes, checked one after the other, stored as one table; and the suite that is part of the program.

use std::{
    collections::BTreeMap,
    fs, io,
    path::{Path, PathBuf},
};

use contact3d::scene::{SceneFile, Source, require_regular};
use runfile::{GroupRecord, IfMissing, RunFile, Transaction};
use schemars::JsonSchema;
use serde::Deserialize;
use studies::{
    StudyStep,
    stability::{Check, Effort, Solutions},
};
use tempfile::TempDir;

use crate::{
    format::{STABILITY, STABILITY_LAYOUT, StabilityRow, scene_text, write_stability},
    output::Inputs,
    pipeline::StageError,
    sweep::{SweepError, changed_scene, read_index},
};

/// The index of a suite: families of cases, each a scene with some keys changed.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Index {
    #[serde(rename = "family")]
    families: Vec<SceneFamily>,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SceneFamily {
    name: String,
    /// Relative to the index.
    scene: PathBuf,
    /// Changes in all its cases.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    set: toml::Table,
    /// More changes in the coarse version.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    coarse: toml::Table,
    #[serde(rename = "case")]
    cases: Vec<Entry>,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    /// What the case shows and what is expected.
    shows: String,
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    set: toml::Table,
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    coarse: toml::Table,
    /// Left out of the coarse version.
    #[serde(default)]
    full_only: bool,
    /// Too large to be solved eight times.
    #[serde(default)]
    solve_only: bool,
    /// Known to have several solutions: algorithms may find different ones.
    #[serde(default)]
    several: bool,
    /// Why the case is known to fail.
    #[serde(default)]
    open: String,
}

/// A case of a suite.
#[derive(Debug, Clone)]
pub struct SuiteCase {
    /// Its name.
    pub name: String,
    /// What it is one of.
    pub family: String,
    /// What it shows and what is expected.
    pub shows: String,
    /// Why it is known to fail; empty when it is not.
    pub open: String,
    /// Its scene.
    pub scene: SceneFile,
    /// How much is checked.
    pub effort: Effort,
    /// Whether algorithms may find different solutions.
    pub solutions: Solutions,
}

/// Whether a file is the index of a suite rather than a scene; a pipe, which can be read only once,
/// is a scene.
pub fn is_index(path: &Path) -> bool {
    if require_regular(path).is_err() {
        return false;
    }
    let text = read_index(path, "read the suite").unwrap_or_default();
    let table: Result<toml::Table, _> = text.parse();
    table.is_ok_and(|table| table.contains_key("family"))
}

/// Reads the cases of an index, all of them or those on small meshes, for every day.
pub fn read(path: &Path, coarse: bool) -> Result<Vec<SuiteCase>, StageError> {
    let text = read_index(path, "read the suite")?;
    let name = path.display().to_string();
    let (index, _): (Index, _) = Source::read(&name, &text, "stability")?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut cases = Vec::new();
    for family in &index.families {
        let base = SceneFile::read(&folder.join(&family.scene))?;
        for entry in &family.cases {
            if entry.full_only && coarse {
                continue;
            }
            let mut changes = vec![&family.set, &entry.set];
            if coarse {
                changes.extend([&family.coarse, &entry.coarse]);
            }
            let changes: Vec<(String, toml::Value)> =
                changes.into_iter().flat_map(Clone::clone).collect();
            cases.push(SuiteCase {
                name: entry.name.clone(),
                family: family.name.clone(),
                shows: entry.shows.clone(),
                open: entry.open.clone(),
                scene: changed_scene(&base, path, &format!("`{}`", entry.name), &changes)?,
                effort: if entry.solve_only {
                    Effort::Solve
                } else {
                    Effort::Invariances
                },
                solutions: if entry.several {
                    Solutions::Several
                } else {
                    Solutions::One
                },
            });
        }
    }
    refuse_mixed_units(path, &cases)?;
    Ok(cases)
}

/// Refuses cases in different units: their table speaks one system.
fn refuse_mixed_units(path: &Path, cases: &[SuiteCase]) -> Result<(), StageError> {
    let units = |case: &SuiteCase| case.scene.scene.units;
    let other = cases.iter().find(|case| units(case) != units(&cases[0]));
    match other {
        None => Ok(()),
        Some(case) => Err(StageError::from(SweepError::Axis {
            file: path.to_owned(),
            place: case.name.clone(),
            expected: format!("the units of all cases before it, {}", units(&cases[0])),
            found: units(case).to_string(),
        })),
    }
}

impl SuiteCase {
    /// A scene as a case of its own.
    #[must_use]
    pub fn alone(scene: SceneFile) -> Self {
        Self {
            name: scene.scene.shown_title(),
            family: String::new(),
            shows: String::new(),
            open: String::new(),
            scene,
            effort: Effort::Invariances,
            solutions: Solutions::One,
        }
    }

    /// Checks the case; a scene without a discrete problem is an outcome too.
    #[must_use]
    pub fn check(&self, observe: &mut dyn FnMut(StudyStep)) -> StabilityRow {
        let scene = &self.scene.scene;
        let folder = &self.scene.folder;
        let check = Check::new(scene, folder, self.effort, self.solutions, observe);
        StabilityRow {
            name: self.name.clone(),
            family: self.family.clone(),
            shows: self.shows.clone(),
            scene: scene_text(scene),
            units: scene.units,
            open: self.open.clone(),
            outcome: check.map_err(|error| error.to_string()),
        }
    }
}

/// Claims the file of a table, new or existing, before anything is checked.
///
/// # Errors
/// A file that is an input, busy, foreign or unwritable.
pub fn claim(path: &Path, inputs: &Inputs) -> Result<RunFile, StageError> {
    inputs.refuse(path)?;
    Ok(RunFile::lock(path, STABILITY_LAYOUT, IfMissing::Create)?)
}

/// Stores the table in a file.
pub fn store(file: RunFile, rows: &[StabilityRow], threads: usize) -> Result<(), StageError> {
    let units = rows.first().map_or(STABILITY_LAYOUT.units, |row| row.units);
    let mut transaction = Transaction::begin(&file.in_units(units))?;
    let checks = rows.iter().filter_map(|row| row.outcome.as_ref().ok());
    let seconds = checks.map(|check| check.seconds).sum();
    let record = GroupRecord::ended(String::new(), String::new(), seconds, threads);
    transaction.write(STABILITY, &record, |writer| write_stability(writer, rows))?;
    Ok(transaction.commit()?)
}

/// Files of the suite with their contents, by their names in its folder.
macro_rules! files {
    ($($name:literal),+) => {
        &[$(($name, include_bytes!(concat!("../pipelines/hard/", $name)))),+]
    };
}

/// The index of the suite, and what it names.
const FILES: &[(&str, &[u8])] = files![
    "suite.toml",
    "brick.toml",
    "soft_block.toml",
    "faces.toml",
    "block.toml",
    "one_node.toml",
    "two_nodes.toml",
    "meshes/one_node.msh",
    "meshes/slivers.msh",
    "meshes/two_nodes.msh"
];

/// The name of the index in the folder that [`unpack`] makes.
pub const INDEX: &str = "suite.toml";

/// Puts the suite in a temporary folder, which is removed with the value returned.
pub fn unpack() -> io::Result<TempDir> {
    let folder = tempfile::Builder::new()
        .prefix("contact3d-pipe-")
        .tempdir()?;
    for (name, content) in FILES {
        let file = folder.path().join(name);
        fs::create_dir_all(file.parent().unwrap_or(Path::new("")))?;
        fs::write(file, content)?;
    }
    Ok(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
        let mut found = Vec::new();
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                let inner = files(&path).into_iter();
                found.extend(inner.map(|(file, content)| (format!("{name}/{file}"), content)));
            } else {
                found.push((name, fs::read(&path).unwrap()));
            }
        }
        found.sort();
        found
    }

    #[test]
    fn the_whole_suite_is_in_the_program_and_nothing_stays_behind() {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/hard");
        let folder = unpack().unwrap();
        assert_eq!(files(folder.path()), files(&source));
        let path = folder.path().to_owned();
        drop(folder);
        assert!(!path.exists());
    }
}

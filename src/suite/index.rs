//! The index of a suite of cases.

use std::path::{Path, PathBuf};

use contact3d::scene::{SceneFile, Source, require_regular};
use schemars::JsonSchema;
use serde::Deserialize;
use studies::stability::{Effort, Solutions};

use crate::{
    pipeline::StageError,
    sweep::{changed_scene, read_index},
};

/// Values of any kind at keys of a scene.
type Changes = std::collections::BTreeMap<String, serde_json::Value>;

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
    #[schemars(with = "Changes")]
    set: toml::Table,
    /// More changes in the coarse version.
    #[serde(default)]
    #[schemars(with = "Changes")]
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
    #[schemars(with = "Changes")]
    set: toml::Table,
    #[serde(default)]
    #[schemars(with = "Changes")]
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

/// Which version of a suite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SuiteVersion {
    /// Small meshes, for every day.
    Coarse,
    /// Everything.
    Full,
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

/// Reads the cases of an index.
pub fn read(path: &Path, version: SuiteVersion) -> Result<Vec<SuiteCase>, StageError> {
    let text = read_index(path, "read the suite")?;
    let name = path.display().to_string();
    let (index, _): (Index, _) = Source::read(&name, &text, "docs/validation/stability.md")?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut cases = Vec::new();
    for family in &index.families {
        let base = SceneFile::read(&folder.join(&family.scene))?;
        for entry in &family.cases {
            if entry.full_only && version == SuiteVersion::Coarse {
                continue;
            }
            let mut changes = vec![&family.set, &entry.set];
            if version == SuiteVersion::Coarse {
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
        Some(case) => Err(StageError::Axis {
            file: path.to_owned(),
            place: case.name.clone(),
            expected: format!("the units of all cases before it, {}", units(&cases[0])),
            found: units(case).to_string(),
        }),
    }
}

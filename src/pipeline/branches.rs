//! Paths of solutions in a key of a scene, followed and stored with it.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use contact3d::scene::{InvalidValue, Scene, SceneFile};
use runfile::{GroupRecord, IfMissing, Reader, RunFile, StoreError};
use studies::branches::{Branches, BranchesObserver, Family, ParameterRange};
use toml::Value;

use super::{
    SeriesFolder, StageError,
    mesh::pin_mesh_file,
    series_folder::{require_same_mesh, write_paths},
    store::store_with_scene,
};
use crate::format::{self, LAYOUT, get_key, set_key};

/// What is asked of `branches`.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchesTask {
    /// The key and its range.
    pub range: ParameterRange,
    /// Whether all solutions are searched for at both ends of the range.
    pub all: bool,
}

/// What `branches` found.
#[derive(Debug)]
pub struct Followed {
    /// The paths.
    pub branches: Branches,
    /// The series that ParaView plays, one file for each path; empty where none were asked for.
    pub series: Vec<PathBuf>,
}

/// Follows the solutions of a scene in one of its keys and stores them with it in a run file, new or existing; takes what the same
/// command stored before.
///
/// # Errors
/// A key that is not a number, a range through values that no problem can have, a scene without friction; a busy, foreign or
/// unreadable file.
pub fn follow_branches(
    path: &Path,
    mut input: SceneFile,
    task: &BranchesTask,
    series: Option<&SeriesFolder>,
    threads: usize,
    observe: &mut BranchesObserver<'_>,
) -> Result<Followed, StageError> {
    pin_mesh_file(&mut input)?;
    let table = table_of(&input.scene, &task.range.key)?;
    let scene_at = |value: f64| scene_at(&table, &task.range.key, value);
    let layout = LAYOUT.in_units(input.scene.units);
    let family = Family::new(task.range.clone(), &scene_at, &input.folder)?;
    if series.is_some() {
        let [first, second] = [task.range.from, task.range.to].map(|end| family.problem_at(end));
        require_same_mesh(first?.mesh(), second?.mesh(), &task.range.key)?;
    }
    let file = RunFile::lock(path, layout, IfMissing::Create)?;
    let started = Instant::now();
    let digest = branches_input(&input.scene, task);
    let branches = match stored(&file, layout, &digest) {
        Some(branches) => branches,
        None => {
            let branches = Branches::follow(&family, task.all, observe)?;
            let seconds = started.elapsed().as_secs_f64();
            let record = GroupRecord::ended(String::new(), digest, seconds, threads);
            store_with_scene(&file, &input.scene, format::BRANCHES, &record, |writer| {
                format::write_branches(writer, &branches)
            })?;
            branches
        }
    };
    let series = match series {
        None => Vec::new(),
        Some(folder) => {
            write_paths(folder, &family, &branches, threads).map_err(StageError::after_storing)?
        }
    };
    Ok(Followed { branches, series })
}

/// What the same command stored before; `None` where there is nothing that can be used.
fn stored(file: &RunFile, layout: runfile::Layout, digest: &str) -> Option<Branches> {
    let reader = Reader::open(file.path(), layout).ok()?;
    let stored: Result<_, StoreError> = reader.group_record(format::BRANCHES);
    let stored = stored.ok()??;
    let fits = stored.record.input_digest == digest;
    fits.then(|| format::read_branches(&reader).ok()).flatten()
}

/// Digest of what paths are followed for.
pub fn branches_input(scene: &Scene, task: &BranchesTask) -> String {
    let range = &task.range;
    let text = format!(
        "{}\n{} {:?} {:?} {}",
        format::scene_text(scene),
        range.key,
        range.from,
        range.to,
        task.all
    );
    blake3::hash(text.as_bytes()).to_hex().to_string()
}

/// The scene as a table in which the key holds a number, or nothing yet.
fn table_of(scene: &Scene, key: &str) -> Result<toml::Table, StageError> {
    let table = format::scene_table(scene);
    let found = match get_key(&table, key) {
        None | Some(Value::Float(_) | Value::Integer(_)) => return Ok(table),
        Some(Value::String(text)) => format!("the text {text:?}"),
        Some(Value::Boolean(flag)) => flag.to_string(),
        Some(Value::Array(_)) => "a list".to_owned(),
        Some(Value::Table(_)) => "a table of keys".to_owned(),
        Some(Value::Datetime(_)) => "a date".to_owned(),
    };
    Err(StageError::Setting(InvalidValue {
        key: key.to_owned(),
        expected: "a key whose value is a number".into(),
        found,
        help: "name a number, as traction.0.value.2, or use a parameter in the formula and name parameters.NAME".into(),
    }))
}

/// The scene with a value of the key.
fn scene_at(table: &toml::Table, key: &str, value: f64) -> Result<Scene, InvalidValue> {
    let mut table = table.clone();
    let invalid = |found: String| {
        InvalidValue {
        key: key.to_owned(),
        expected: "a scene that is valid at every value of the range".into(),
        found: format!("at {value}: {found}"),
        help: "docs/reference/scene.md lists the keys and their ranges; choose others with --parameter, --from and --to".into(),
    }
    };
    set_key(&mut table, key, Value::Float(value)).map_err(invalid)?;
    Scene::parse("the scene", &table.to_string()).map_err(|error| invalid(error.to_string()))
}

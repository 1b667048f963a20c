//! The studies: `accuracy` and `branches` measured for a scene, `bound` for its answer, each stored with it.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use contact3d::scene::{InvalidValue, Scene, SceneFile};
use runfile::{GroupRecord, IfMissing, Reader, RunFile, StoreError};
use studies::{
    StudyStep,
    accuracy::{Accuracy, AccuracySettings, MOST_UNKNOWNS, nested_bricks},
    bound::BoundParts,
    branches::{Branches, Family, ParameterRange},
};
use toml::Value;

use super::{
    SeriesFolder, StageError,
    mesh::pin_mesh_file,
    resources,
    results::read_bound,
    series_folder::{require_same_mesh, write_paths},
    store::store_with_scene,
};
use crate::format::{self, LAYOUT, get_key, set_key};

/// Measures the errors of solvers and meshes for a scene and stores them with it in a run file,
/// new or existing.
///
/// # Errors
/// A busy, foreign or unreadable file; a scene without a discrete problem.
pub fn measure_accuracy(
    path: &Path,
    mut input: SceneFile,
    settings: &AccuracySettings,
    threads: usize,
    observe: &mut dyn FnMut(StudyStep),
) -> Result<Accuracy, StageError> {
    pin_mesh_file(&mut input)?;
    let scene = &input.scene;
    let mut limits = *settings;
    match scene.as_brick() {
        None => {
            let most = settings.unknowns.unwrap_or(MOST_UNKNOWNS);
            limits.unknowns = Some(most.min(resources::unknowns_that_fit()));
        }
        Some(brick) => {
            if let Some(finest) = nested_bricks(scene, brick, settings)?.last() {
                let need = resources::need_of_finest(finest, scene.element());
                resources::admit(need, path)?;
            }
        }
    }
    let file = RunFile::lock(path, LAYOUT.in_units(scene.units), IfMissing::Create)?;
    let started = Instant::now();
    let measured = Accuracy::measure(scene, &input.folder, &limits, observe)?;
    let settings = toml::to_string(settings).expect("settings hold only TOML types");
    let seconds = started.elapsed().as_secs_f64();
    let record = GroupRecord::ended(settings, accuracy_input(scene), seconds, threads);
    store_with_scene(&file, scene, format::ACCURACY, &record, |writer| {
        format::write_accuracy(writer, &measured, scene)
    })?;
    Ok(measured)
}

/// Bounds the discretisation error of a solved run file and stores the bound in it; beside the bound the stored estimate, where there is
/// one.
///
/// # Errors
/// A busy, foreign or unreadable file; a file without a fresh answer; a scene whose error cannot be bounded.
pub fn bound_error(
    path: &Path,
    threads: usize,
) -> Result<(Scene, BoundParts, Option<f64>), StageError> {
    let file = RunFile::lock(path, LAYOUT, IfMissing::Refuse)?;
    let started = Instant::now();
    let (input, bound, estimate) = read_bound(path)?;
    let scene = &input.scene;
    let seconds = started.elapsed().as_secs_f64();
    let record = GroupRecord::ended(String::new(), accuracy_input(scene), seconds, threads);
    let file = file.in_units(scene.units);
    store_with_scene(&file, scene, format::BOUND, &record, |writer| {
        format::write_bound(writer, &bound)
    })?;
    Ok((input.scene, bound.relative(), estimate))
}

/// Digest of what studies are measured for.
pub fn accuracy_input(scene: &Scene) -> String {
    blake3::hash(format::scene_text(scene).as_bytes())
        .to_hex()
        .to_string()
}

/// What `branches` found.
#[derive(Debug)]
pub struct Followed {
    /// The paths.
    pub branches: Branches,
    /// The series that ParaView plays, one file for each path; empty where none were asked for.
    pub series: Vec<PathBuf>,
}

/// Follows the solutions of a scene in one of its keys over a range, with `all` every one that is found at its ends, and stores them with it
/// in a run file, new or existing; takes what the same command stored before.
///
/// # Errors
/// A key that is not a number, a range through values that no problem can have, a scene without friction; a busy, foreign or
/// unreadable file.
pub fn follow_branches(
    path: &Path,
    mut input: SceneFile,
    range: ParameterRange,
    all: bool,
    series: Option<&SeriesFolder>,
    threads: usize,
    observe: &mut dyn FnMut(&Branches, Option<usize>),
) -> Result<Followed, StageError> {
    pin_mesh_file(&mut input)?;
    let table = table_of(&input.scene, &range.key)?;
    let scene_at = |value: f64| scene_at(&table, &range.key, value);
    let layout = LAYOUT.in_units(input.scene.units);
    let family = Family::new(range.clone(), &scene_at, &input.folder)?;
    if series.is_some() {
        let [first, second] = [range.from, range.to].map(|end| family.problem_at(end));
        require_same_mesh(first?.mesh(), second?.mesh(), &range.key)?;
    }
    let file = RunFile::lock(path, layout, IfMissing::Create)?;
    let started = Instant::now();
    let digest = branches_input(&input.scene, &range, all);
    let branches = match stored(&file, layout, &digest) {
        Some(branches) => branches,
        None => {
            let branches = Branches::follow(&family, all, observe)?;
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
fn branches_input(scene: &Scene, range: &ParameterRange, all: bool) -> String {
    let text = format!(
        "{}\n{} {:?} {:?} {}",
        format::scene_text(scene),
        range.key,
        range.from,
        range.to,
        all
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
        help: "`contact3d-pipe help scene` lists the keys and their ranges; choose others with --parameter, --from and --to".into(),
    }
    };
    set_key(&mut table, key, Value::Float(value)).map_err(invalid)?;
    Scene::parse("the scene", &table.to_string()).map_err(|error| invalid(error.to_string()))
}

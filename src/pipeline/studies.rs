//! The studies `accuracy` and `bound`: measured for a scene or its answer and stored with it.

use std::{path::Path, time::Instant};

use contact3d::scene::{Scene, SceneFile};
use runfile::{GroupRecord, IfMissing, RunFile};
use studies::{
    StudyStep,
    accuracy::{Accuracy, AccuracySettings, nested_bricks},
    bound::RelativeBound,
};

use super::{
    StageError, mesh::pin_mesh_file, resources, results::read_bound, store::store_with_scene,
};
use crate::format::{self, LAYOUT};

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
    if let Some(brick) = scene.body.as_brick()
        && let Some(finest) = nested_bricks(scene, brick, settings)?.last()
    {
        let need = resources::need_of_finest(finest, scene.body.element);
        resources::admit(need, path)?;
    }
    let file = RunFile::lock(path, LAYOUT.in_units(scene.units), IfMissing::Create)?;
    let started = Instant::now();
    let measured = Accuracy::measure(scene, &input.folder, settings, observe)?;
    let settings = toml::to_string(settings).expect("settings hold only TOML types");
    let seconds = started.elapsed().as_secs_f64();
    let record = GroupRecord::ended(settings, accuracy_input(scene), seconds, threads);
    store_with_scene(&file, scene, format::ACCURACY, &record, |writer| {
        format::write_accuracy(writer, &measured)
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
) -> Result<(Scene, RelativeBound, Option<f64>), StageError> {
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

//! The ladders of `accuracy`: measured for a scene and stored with it.

use std::{path::Path, time::Instant};

use contact3d::scene::{Scene, SceneFile};
use runfile::{GroupRecord, IfMissing, RunFile};
use studies::accuracy::{Accuracy, AccuracyProgress, AccuracySettings, nested_bricks};

use super::{StageError, mesh::pin_mesh_file, resources, store::store_with_scene};
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
    observe: &mut dyn FnMut(AccuracyProgress),
) -> Result<Accuracy, StageError> {
    pin_mesh_file(&mut input)?;
    admit_finest(&input.scene, settings, path)?;
    let layout = LAYOUT.in_units(input.scene.units);
    let file = RunFile::lock(path, layout, IfMissing::Create)?;
    let started = Instant::now();
    let limited = AccuracySettings {
        memory: resources::available_memory().map(|bytes| bytes as f64),
        ..*settings
    };
    let accuracy = Accuracy::measure(&input.scene, &input.folder, &limited, observe)?;
    let stored = toml::to_string(settings).expect("settings hold only TOML types");
    let record = GroupRecord::ended(
        stored,
        accuracy_input(&input.scene),
        started.elapsed().as_secs_f64(),
        threads,
    );
    store_with_scene(&file, &input.scene, format::ACCURACY, &record, |writer| {
        format::write_accuracy(writer, &accuracy)
    })?;
    Ok(accuracy)
}

/// Refuses a finest mesh whose problem does not fit into memory, before the coarser ones take their
/// time.
fn admit_finest(
    scene: &Scene,
    settings: &AccuracySettings,
    run_file: &Path,
) -> Result<(), StageError> {
    let Some(brick) = scene.body.as_brick() else {
        return Ok(());
    };
    if let Some(finest) = nested_bricks(scene, brick, settings)?.last() {
        let need = resources::need_of_finest(finest, scene.body.element);
        resources::admit(need, run_file)?;
    }
    Ok(())
}

/// Digest of what the ladders are measured for.
#[must_use]
pub fn accuracy_input(scene: &Scene) -> String {
    blake3::hash(format::scene_text(scene).as_bytes())
        .to_hex()
        .to_string()
}

//! The theory of HKL section 3: measured for a scene and stored with it.

use std::{path::Path, time::Instant};

use contact3d::scene::{Scene, SceneFile};
use runfile::{GroupRecord, IfMissing, RunFile};
use studies::theory::{Theory, TheoryProgress, TheorySettings, theory_bricks};

use super::{
    StageError, accuracy_input,
    mesh::{pin, pin_mesh_file},
    resources,
    store::store_with_scene,
};
use crate::format::{self, LAYOUT};

/// Measures the theory for a scene and stores it with the scene in a run file, new or existing.
///
/// # Errors
/// A busy, foreign or unreadable file; a scene without a discrete problem, or one that the theory does not cover; a mesh that
/// does not fit into memory.
pub fn measure_theory(
    path: &Path,
    mut input: SceneFile,
    mut settings: TheorySettings,
    threads: usize,
    observe: &mut dyn FnMut(TheoryProgress),
) -> Result<Theory, StageError> {
    pin_mesh_file(&mut input)?;
    for file in &mut settings.meshes {
        pin(file, &input)?;
    }
    admit_finest(&input.scene, &settings, path)?;
    let layout = LAYOUT.in_units(input.scene.units);
    let file = RunFile::lock(path, layout, IfMissing::Create)?;
    let started = Instant::now();
    let theory = Theory::measure(&input.scene, &input.folder, &settings, observe)?;
    let record = GroupRecord::ended(
        toml::to_string(&settings).expect("settings hold only TOML types"),
        accuracy_input(&input.scene),
        started.elapsed().as_secs_f64(),
        threads,
    );
    store_with_scene(&file, &input.scene, format::THEORY, &record, |writer| {
        format::write_theory(writer, &theory)
    })?;
    Ok(theory)
}

/// Refuses a finest mesh whose problem does not fit into memory.
fn admit_finest(scene: &Scene, settings: &TheorySettings, path: &Path) -> Result<(), StageError> {
    let Some(brick) = scene.body.as_brick() else {
        return Ok(());
    };
    if let Some(finest) = theory_bricks(scene, brick, settings)?.last() {
        resources::admit(resources::need_of_theory(finest), path)?;
    }
    Ok(())
}

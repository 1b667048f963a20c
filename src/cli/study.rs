//! How `accuracy` and `branches` begin and end.

use std::path::{Path, PathBuf};

use contact3d::scene::SceneFile;
use serde_json::Value;
use units::Units;

use super::{
    arguments::{FigureArguments, Output, SceneArguments},
    override_scene, terminal,
};
use crate::{
    output::Inputs,
    pipeline::StageError,
    report::unit_words,
    views::{Drawing, PictureFolder},
};

/// The scene, the files that belong to it, and the folder for pictures where these are wanted; everything that is to be written is
/// looked at before anything is measured.
pub(super) fn begin(
    scene: &SceneArguments,
    run_file: &Path,
    figures: &FigureArguments,
    drawing: Drawing,
) -> Result<(SceneFile, Inputs, Option<PictureFolder>), StageError> {
    let (scene, inputs) = override_scene::read_with_inputs(scene)?;
    inputs.refuse(run_file)?;
    let pictures = figures.beside(run_file, drawing, inputs.clone())?;
    Ok((scene, inputs, pictures))
}

/// Draws into the folder, where one is wanted, says how many files came of it, and prints the results. These are stored by then.
pub(super) fn finish(
    output: &Output,
    pictures: Option<&PictureFolder>,
    units: Units,
    draw: impl FnOnce(&PictureFolder) -> Result<Vec<PathBuf>, StageError>,
    json: impl FnOnce() -> Value,
    text: impl FnOnce() -> String,
) -> Result<(), StageError> {
    if let Some(pictures) = pictures {
        let files = draw(pictures).map_err(StageError::after_storing)?;
        terminal::say_files(output, "figures", &files, pictures.path());
    }
    let with_units = || {
        let mut json = json();
        json["units"] = unit_words(units);
        json
    };
    terminal::print(output, with_units, text);
    Ok(())
}

//! How `accuracy`, `theory` and `branches` end: what was drawn, and the results for people or for programs.

use std::path::PathBuf;

use units::Units;

use super::{arguments::Output, terminal};
use crate::{pipeline::StageError, report::unit_words, views::PictureFolder};

/// Draws into the folder, where one is wanted, and says how many files came of it. The results are stored by then.
pub(super) fn draw(
    pictures: Option<&PictureFolder>,
    output: &Output,
    draw: impl FnOnce(&PictureFolder) -> Result<Vec<PathBuf>, StageError>,
) -> Result<(), StageError> {
    let Some(pictures) = pictures else {
        return Ok(());
    };
    let files = draw(pictures).map_err(StageError::after_storing)?;
    terminal::say_files(output, "figures", &files, pictures.path());
    Ok(())
}

/// Prints the results as they are asked for.
pub(super) fn print(
    output: &Output,
    units: Units,
    json: impl FnOnce() -> serde_json::Value,
    words: impl FnOnce() -> String,
) {
    if output.json {
        let mut json = json();
        json["units"] = unit_words(units);
        terminal::json(&json);
    } else if !output.quiet {
        terminal::result(&words());
    }
}

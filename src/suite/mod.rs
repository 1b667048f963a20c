//! Suites of hard cases: an index of scenes, checked one after the other, stored as one table.

mod builtin;
mod index;

use std::path::Path;

pub use builtin::{INDEX, unpack};
pub use index::{SuiteCase, SuiteVersion, is_index, read};

use contact3d::scene::SceneFile;
use runfile::{GroupRecord, Home, IfMissing, RunFile, Transaction};
use studies::{
    StudyStep,
    stability::{Check, Effort, Solutions},
};

use crate::{
    format::{STABILITY, STABILITY_LAYOUT, StabilityRow, scene_text, write_stability},
    output::Inputs,
    pipeline::StageError,
};

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
    transaction.write(STABILITY, Home::RunFile, &record, |writer| {
        write_stability(writer, rows)
    })?;
    Ok(transaction.commit()?)
}

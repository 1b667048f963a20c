//! Whether `/VTKHDF` shows the results that `/post` holds.

use runfile::{Reader, Stage, StoreError};

use super::post::VTKHDF_DIGEST;

/// Refuses a report whose form for ParaView is missing, altered, or that of another run. Does nothing without a
/// report.
///
/// Files of format 1.3 and older hold no digest of `/VTKHDF` in the report; there both must have been computed
/// from the same.
///
/// # Errors
/// Those of [`Reader::whole_stage`] for either; `Missing`, `Altered`.
pub fn check(reader: &Reader) -> Result<(), StoreError> {
    let Some(report) = reader.whole_stage(Stage::Post)? else {
        return Ok(());
    };
    let Some(grid) = reader.whole_stage(Stage::Vtk)? else {
        return Err(StoreError::Missing {
            file: reader.path().into(),
            dataset: format!("/{}", Stage::Vtk),
            stage: Stage::Post,
        });
    };
    let (expected, found) = match reader.has(VTKHDF_DIGEST) {
        true => (reader.read_text(VTKHDF_DIGEST)?, grid.digest),
        false => (report.record.input_digest, grid.record.input_digest),
    };
    match expected == found {
        true => Ok(()),
        false => Err(StoreError::Altered {
            file: reader.path().into(),
            dataset: format!("/{}", Stage::Vtk),
            expected,
            found,
        }),
    }
}

/// Everything that is wrong with the stages of a file, as [`Reader::problems`], and between `/VTKHDF` and the
/// report.
#[must_use]
pub fn problems(reader: &Reader) -> Vec<StoreError> {
    let mut problems = reader.problems();
    let is_whole = |stage| reader.whole_stage(stage).is_ok();
    // What is wrong with either by itself is among the problems already.
    if is_whole(Stage::Post) && is_whole(Stage::Vtk) {
        problems.extend(check(reader).err());
    }
    problems
}

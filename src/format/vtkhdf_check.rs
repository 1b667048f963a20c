//! Whether `/VTKHDF` shows the results that `/post` holds.

use runfile::{Reader, StoreError};

use super::{load_history, post, post::VTKHDF_DIGEST, solve, vtkhdf};

/// Refuses a report whose form for ParaView is missing, altered, or that of another run. Does
/// nothing without a report.
///
/// Files of format 1.3 and older hold no digest of `/VTKHDF` in the report; there both must have
/// been computed from the same.
///
/// # Errors
/// Those of [`Reader::whole_group`] for either; `Missing`, `Altered`, `Mismatch` of an attribute
/// that ParaView reads.
pub fn check(reader: &Reader) -> Result<(), StoreError> {
    let Some(report) = reader.whole_group(post::GROUP)? else {
        return Ok(());
    };
    let Some(grid) = reader.whole_group(vtkhdf::GROUP)? else {
        return Err(StoreError::Missing {
            file: reader.path().into(),
            dataset: format!("/{}", vtkhdf::GROUP),
            group: vtkhdf::GROUP,
        });
    };
    // No digest covers attributes; these are the same in every file.
    reader.require_ascii_attribute(vtkhdf::GROUP, "Type", vtkhdf::TYPE)?;
    reader.require_number_attribute(vtkhdf::GROUP, "Version", &vtkhdf::VERSION)?;
    let (expected, found) = match reader.has(VTKHDF_DIGEST) {
        true => (reader.read_text(VTKHDF_DIGEST)?, grid.digest),
        false => (report.record.input_digest, grid.record.input_digest),
    };
    match expected == found {
        true => Ok(()),
        false => Err(StoreError::Altered {
            file: reader.path().into(),
            dataset: format!("/{}", vtkhdf::GROUP),
            expected,
            found,
        }),
    }
}

/// Everything that is wrong with the stages of a file, as [`Reader::problems`], between `/VTKHDF` and the report, and between
/// `/history` and the solution.
#[must_use]
pub fn problems(reader: &Reader) -> Vec<StoreError> {
    let mut problems = reader.problems();
    let is_whole = |group| reader.whole_group(group).is_ok();
    if is_whole(solve::GROUP) && is_whole(load_history::GROUP) {
        problems.extend(load_history::check(reader).err());
    }
    // What is wrong with either by itself is among the problems already.
    if is_whole(post::GROUP) && is_whole(vtkhdf::GROUP) {
        problems.extend(check(reader).err());
    }
    problems
}

//! Whether groups of a file that show the same results belong together: `/VTKHDF` and `/post`, `/history` and `/solve`.

use runfile::{Group, Reader, StoreError, StoredGroup};

use super::{
    Stage, VTKHDF, increments,
    post::{self, VTKHDF_DIGEST},
    solve::HISTORY_DIGEST,
    vtkhdf,
};

/// Refuses a stage whose companion is missing, altered, or that of another run; as [`Reader::whole_group`] for both.
pub fn check_companion(reader: &Reader, stage: Stage) -> Result<(), StoreError> {
    match stage {
        Stage::Solve => check_history(reader),
        Stage::Post => check_vtkhdf(reader),
        _ => Ok(()),
    }
}

/// Refuses a report whose form for ParaView is missing, altered, or that of another run. Does
/// nothing without a report.
pub fn check_vtkhdf(reader: &Reader) -> Result<(), StoreError> {
    if reader.whole_group(post::GROUP)?.is_none() {
        return Ok(());
    }
    let grid = require(reader, VTKHDF)?;
    // No digest covers attributes; these are the same in every file.
    reader.require_ascii_attribute(VTKHDF, "Type", vtkhdf::TYPE)?;
    reader.require_number_attribute(VTKHDF, "Version", &vtkhdf::VERSION)?;
    let expected = reader.read_text(VTKHDF_DIGEST)?;
    require_same(reader, VTKHDF, expected, grid.digest)
}

/// Refuses a solution of a history whose `/history` is missing, altered, or that of another run.
fn check_history(reader: &Reader) -> Result<(), StoreError> {
    if !reader.has(HISTORY_DIGEST) {
        return Ok(());
    }
    let history = require(reader, increments::GROUP)?;
    let expected = reader.read_text(HISTORY_DIGEST)?;
    require_same(reader, increments::GROUP, expected, history.digest)
}

fn require(reader: &Reader, group: Group) -> Result<StoredGroup, StoreError> {
    let stored = reader.whole_group(group)?;
    stored.ok_or_else(|| StoreError::Missing {
        file: reader.path().into(),
        dataset: format!("/{group}"),
        group,
    })
}

fn require_same(
    reader: &Reader,
    group: Group,
    expected: String,
    found: String,
) -> Result<(), StoreError> {
    if expected == found {
        return Ok(());
    }
    Err(StoreError::Altered {
        file: reader.path().into(),
        dataset: format!("/{group}"),
        expected,
        found,
    })
}

/// Everything that is wrong with the stages of a file, as [`Reader::problems`], and between them and their companions.
pub fn problems(reader: &Reader) -> Vec<StoreError> {
    let mut problems = reader.problems();
    // What is wrong with either by itself is among the problems already.
    let is_whole = |group| reader.whole_group(group).is_ok();
    for stage in Stage::ALL {
        if is_whole(stage.group()) && stage.companion().is_some_and(is_whole) {
            problems.extend(check_companion(reader, stage).err());
        }
    }
    problems
}

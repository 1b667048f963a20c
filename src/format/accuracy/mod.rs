//! `/accuracy`: errors and costs of solvers and meshes.

mod ladder;
mod levels;
mod ways;

pub(super) use ladder::TABLE as RUNGS_TABLE;
pub(super) use levels::TABLE as LEVELS_TABLE;
pub(super) use ways::TABLE as WAYS_TABLE;

use contact3d::convergence::{Accuracy, Cost};
use runfile::{DatasetSpec, Group, GroupWriter, Kind, Reader, StoreError};
use units::Dimension;

use super::{FormatError, columns::Columns, read_index_vec};

/// Errors and costs of solvers and meshes; computed from the scene alone.
pub const GROUP: Group = Group::new("accuracy", "accuracy");

const ADVICE: &str = "/accuracy/advice";
const NO_CONTACT: &str = "absent without contact";

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(ADVICE, Kind::Text, &[], Dimension::Number, "What the ladders mean for this mesh, in one sentence.").volatile(),
];

/// Writes both ladders, the ways and their advice.
///
/// # Errors
/// HDF5 failures.
pub fn write(writer: &mut GroupWriter<'_>, accuracy: &Accuracy) -> Result<(), StoreError> {
    writer.write_text(ADVICE, &accuracy.advice().to_string())?;
    if let Some(ladder) = &accuracy.algebraic {
        ladder::write(writer, ladder)?;
    }
    if let Some(ladder) = &accuracy.discretisation {
        levels::write(writer, ladder)?;
    }
    if let Some(ways) = &accuracy.ways {
        ways::write(writer, ways)?;
    }
    Ok(())
}

/// Reads the sentence; `None` in a file without ladders.
///
/// # Errors
/// An altered dataset.
pub fn read_advice(reader: &Reader) -> Result<Option<String>, FormatError> {
    if !reader.has(ADVICE) {
        return Ok(None);
    }
    Ok(Some(reader.read_text(ADVICE)?))
}

/// Reads both ladders and the ways; orders and limits are computed again.
///
/// # Errors
/// Missing, altered or contradictory datasets.
pub fn read(reader: &Reader) -> Result<Accuracy, FormatError> {
    let algebraic = ladder::read(reader)?;
    let discretisation = levels::read(reader)?;
    Ok(Accuracy {
        algebraic,
        discretisation,
        ways: ways::read(reader)?,
    })
}

/// Writes seconds, repeats and peak memory; NaN and 0 for what was not run.
fn write_costs(
    writer: &mut GroupWriter<'_>,
    [seconds, repeats, peak]: [&str; 3],
    costs: &[Option<Cost>],
) -> Result<(), StoreError> {
    let mut columns = Columns::new(writer, costs);
    columns.numbers(seconds, |cost| cost.map_or(f64::NAN, |cost| cost.seconds))?;
    columns.counts(repeats, |cost| cost.map_or(0, |cost| cost.repeats))?;
    columns.numbers(peak, |cost| {
        cost.and_then(|cost| cost.peak_bytes).unwrap_or(f64::NAN)
    })
}

fn read_costs(
    reader: &Reader,
    [seconds, repeats, peak]: [&str; 3],
) -> Result<Vec<Cost>, FormatError> {
    let seconds: Vec<f64> = reader.read_vec(seconds)?;
    let repeats = read_index_vec(reader, repeats)?;
    let peaks: Vec<f64> = reader.read_vec(peak)?;
    let costs = (0..seconds.len()).map(|k| Cost {
        seconds: seconds[k],
        repeats: repeats[k],
        peak_bytes: Some(peaks[k]).filter(|bytes| !bytes.is_nan()),
    });
    Ok(costs.collect())
}

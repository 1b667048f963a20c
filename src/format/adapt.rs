//! `/adapt`: the levels of an adaptive mesh, and what the next one is made of.

use contact3d::{
    adaptation::{Adaptation, AdaptiveLevel, AdaptiveStatus},
    mesh::Refinement,
};
use runfile::{
    DatasetSpec, Extent, Extent::Named, Group, GroupWriter, Kind, Reader, StoreError, StoredEnum,
};
use units::Dimension;

use super::{
    FormatError, Stage,
    columns::Columns,
    enumeration::{read_member, stored_as},
    outcome::StoredStatus,
    read_finite_vec, read_index_vec,
};

/// The levels of an adaptive mesh.
pub const GROUP: Group = Group::new("adapt", Stage::Mesh.command());

stored_as! {
    /// How an adaptive computation stands, as stored.
    StoredAdaptiveStatus of AdaptiveStatus as "adaptive_status" {
        Refining = 0 => "refining",
        Met = 1 => "met",
        NotConverged = 2 => "not_converged",
        TooLarge = 3 => "too_large",
        Stalled = 4 => "stalled",
    }
}

const STATUS: &str = "/adapt/status";
const N_TETRAHEDRA: &str = "/adapt/levels/n_tetrahedra";
const N_FREE: &str = "/adapt/levels/n_free";
const N_MULTIPLIERS: &str = "/adapt/levels/n_multipliers";
const ESTIMATED_ERROR: &str = "/adapt/levels/estimated_error";
const STABILITY: &str = "/adapt/levels/stability";
const LEVEL_STATUS: &str = "/adapt/levels/status";
const SECONDS: &str = "/adapt/levels/seconds";
const CUTS: &str = "/adapt/cuts";
const N_CUTS: &str = "/adapt/n_cuts";
const START: &str = "/adapt/start";
const N_START: &str = "/adapt/n_start";

const LEVELS: &[Extent] = &[Named("n_adaptive_levels")];
const REFINEMENTS: &[Extent] = &[Named("n_refinements")];

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(STATUS, Kind::Enum(StoredAdaptiveStatus::SPEC), &[], Dimension::Number, "How the levels stand with the error that the scene wishes for."),
    GROUP.row(N_TETRAHEDRA, Kind::I64, LEVELS, Dimension::Number, "Tetrahedra."),
    GROUP.row(N_FREE, Kind::I64, LEVELS, Dimension::Number, "Free degrees of freedom."),
    GROUP.row(N_MULTIPLIERS, Kind::I64, LEVELS, Dimension::Number, "Multipliers."),
    GROUP.row(ESTIMATED_ERROR, Kind::F64, LEVELS, Dimension::Number, "Estimated discretisation error over |u|_A."),
    GROUP.row(STABILITY, Kind::F64, LEVELS, Dimension::Number, "Smallest eigenvalue of S scaled to a unit diagonal; NaN where S is not held."),
    GROUP.row(LEVEL_STATUS, Kind::Enum(StoredStatus::SPEC), LEVELS, Dimension::Number, "How the solve ended."),
    GROUP.row(SECONDS, Kind::F64, LEVELS, Dimension::Time, "Wall-clock time of mesh, assembly, solve and evaluation.").volatile(),
    GROUP.row(N_CUTS, Kind::I64, REFINEMENTS, Dimension::Number, "Tetrahedra of each level that was cut, the entries of `cuts` that are its own."),
    GROUP.row(CUTS, Kind::U8, &[Named("n_cut_tetrahedra")], Dimension::Number, "How often each tetrahedron of a level was to be cut in two to make the next one; level after level.").compressed(),
    GROUP.row(N_START, Kind::I64, REFINEMENTS, Dimension::Number, "Multipliers of each level that was made, the entries of `start` that are its own."),
    GROUP.row(START, Kind::F64, &[Named("n_start_multipliers")], Dimension::STRESS, "Multipliers that each refined level starts from; level after level.").symbol("lambda"),
];

/// Writes the levels done and the cuts that follow.
///
/// # Errors
/// HDF5 failures.
pub fn write(
    writer: &mut GroupWriter<'_>,
    adaptation: &Adaptation,
    status: AdaptiveStatus,
) -> Result<(), StoreError> {
    writer.write_enum(STATUS, &[StoredAdaptiveStatus::from(status)], &[])?;
    let mut columns = Columns::new(writer, &adaptation.levels);
    columns.counts(N_TETRAHEDRA, |level| level.n_tetrahedra)?;
    columns.counts(N_FREE, |level| level.n_free)?;
    columns.counts(N_MULTIPLIERS, |level| level.n_multipliers)?;
    columns.numbers(ESTIMATED_ERROR, |level| level.estimated_error)?;
    columns.numbers(STABILITY, |level| level.stability.unwrap_or(f64::NAN))?;
    columns.members(LEVEL_STATUS, |level| StoredStatus::from(level.status))?;
    columns.numbers(SECONDS, |level| level.seconds)?;
    let cuts = adaptation.refinement.levels();
    Columns::new(writer, cuts).counts(N_CUTS, Vec::len)?;
    let cuts = cuts.concat();
    writer.write(CUTS, &cuts, &[cuts.len()])?;
    Columns::new(writer, &adaptation.starts).counts(N_START, Vec::len)?;
    let start = adaptation.starts.concat();
    writer.write(START, &start, &[start.len()])
}

/// Reads the levels done, with how they stood.
///
/// # Errors
/// Missing or altered datasets.
pub fn read(reader: &Reader) -> Result<(Adaptation, AdaptiveStatus), FormatError> {
    let n_tetrahedra = read_index_vec(reader, N_TETRAHEDRA)?;
    let n_free = read_index_vec(reader, N_FREE)?;
    let n_multipliers = read_index_vec(reader, N_MULTIPLIERS)?;
    let estimated: Vec<f64> = reader.read_vec(ESTIMATED_ERROR)?;
    let stability: Vec<f64> = reader.read_vec(STABILITY)?;
    let statuses = reader.read_enum::<StoredStatus>(LEVEL_STATUS)?;
    let seconds: Vec<f64> = reader.read_vec(SECONDS)?;
    let levels = (0..estimated.len()).map(|k| AdaptiveLevel {
        n_tetrahedra: n_tetrahedra[k],
        n_free: n_free[k],
        n_multipliers: n_multipliers[k],
        estimated_error: estimated[k],
        stability: Some(stability[k]).filter(|value| !value.is_nan()),
        status: statuses[k].into(),
        seconds: seconds[k],
    });
    let cuts = divided(&read_index_vec(reader, N_CUTS)?, reader.read_vec(CUTS)?);
    let starts = divided(
        &read_index_vec(reader, N_START)?,
        read_finite_vec(reader, START)?,
    );
    let adaptation = Adaptation {
        levels: levels.collect(),
        refinement: Refinement::new(cuts),
        starts,
    };
    Ok((
        adaptation,
        read_member::<StoredAdaptiveStatus>(reader, STATUS)?.into(),
    ))
}

/// How the levels stand; `None` in a file without any.
pub(super) fn read_status(reader: &Reader) -> Result<Option<AdaptiveStatus>, FormatError> {
    match reader.has(STATUS) {
        true => Ok(Some(
            read_member::<StoredAdaptiveStatus>(reader, STATUS)?.into(),
        )),
        false => Ok(None),
    }
}

/// Consecutive parts of some lengths.
fn divided<T>(lengths: &[usize], mut values: Vec<T>) -> Vec<Vec<T>> {
    let part = |length: &usize| {
        let rest = values.split_off((*length).min(values.len()));
        std::mem::replace(&mut values, rest)
    };
    lengths.iter().map(part).collect()
}

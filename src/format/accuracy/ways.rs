//! `/accuracy/ways`: ways to accuracy.

use contact3d::convergence::{Cost, Forces, Reference, Way, WayKind, WayLevel, Ways};
use runfile::{
    DatasetSpec, Extent, Extent::Named, GroupWriter, Kind, Reader, StoreError, StoredEnum,
};
use units::Dimension;

use super::{GROUP, read_costs, write_costs};
use crate::format::axes;
use crate::format::{
    FormatError, columns::Columns, enumeration::stored_as, outcome::StoredStatus, read_index_vec,
    read_scalar,
};

stored_as! {
    /// A way to accuracy, as stored.
    StoredWay of WayKind as "way" {
        LinearUniform = 0 => "p1_uniform",
        QuadraticUniform = 1 => "p2_uniform",
        LinearAdaptive = 2 => "p1_adaptive",
        QuadraticAdaptive = 3 => "p2_adaptive",
        QuadraticGraded = 4 => "p2_graded",
        QuadraticGradedAdaptive = 5 => "p2_graded_adaptive",
    }
}

const WAY: &str = "/accuracy/ways/way";
const N_FREE: &str = "/accuracy/ways/unknowns";
const N_TETRAHEDRA: &str = "/accuracy/ways/tetrahedra";
const N_MULTIPLIERS: &str = "/accuracy/ways/multipliers";
const STATUS: &str = "/accuracy/ways/status";
const ESTIMATED_ERROR: &str = "/accuracy/ways/estimated_error";
const CONTACT_ERROR: &str = "/accuracy/ways/contact_error";
const ENERGY_ERROR: &str = "/accuracy/ways/energy_error";
const SECONDS: &str = "/accuracy/ways/seconds";
const REPEATS: &str = "/accuracy/ways/repeats";
const PEAK: &str = "/accuracy/ways/peak_memory";
const ADVICE: &str = "/accuracy/ways/advice";
const REFERENCE_ENERGY: &str = "/accuracy/ways/reference/potential_energy";
const REFERENCE_NORMAL: &str = "/accuracy/ways/reference/normal_force";
const REFERENCE_TANGENTIAL: &str = "/accuracy/ways/reference/tangential_force";

const NOT_ASKED: &str = "absent without --ways";
const NO_CONTACT: &str = "absent without --ways or contact";
const NO_FRICTION: &str = "absent without --ways or friction";
const ROWS: &[Extent] = &[Named("n_way_levels")];

/// A row of the ways; how many there are depends on what fits into the budget.
const fn level(path: &'static str, kind: Kind, meaning: &'static str) -> DatasetSpec {
    GROUP
        .row(path, kind, ROWS, Dimension::Number, meaning)
        .volatile()
        .optional(NOT_ASKED)
}

#[rustfmt::skip]
pub(in crate::format) const TABLE: &[DatasetSpec] = &[
    level(WAY, Kind::Enum(StoredWay::SPEC), "Way of each mesh, coarse to fine; the last row is the reference."),
    level(N_FREE, Kind::I64, "Free degrees of freedom."),
    level(N_TETRAHEDRA, Kind::I64, "Tetrahedra."),
    level(N_MULTIPLIERS, Kind::I64, "Multipliers."),
    level(STATUS, Kind::Enum(StoredStatus::SPEC), "How the solve ended."),
    level(ESTIMATED_ERROR, Kind::F64, "Error of u_h over |u_h|_A as its own report estimates it."),
    level(CONTACT_ERROR, Kind::F64, "The part of it that the multipliers are to blame for; 0 without contact."),
    level(ENERGY_ERROR, Kind::F64, "|u_h - u_r|_A / |u_r|_A with the reference u_r; NaN where its estimated error is more than half of that of u_h."),
    GROUP.row(SECONDS, Kind::F64, ROWS, Dimension::Time, "Median wall-clock time of mesh, assembly, solve and evaluation in memory; of an adaptive mesh with all coarser ones.").volatile().optional(NOT_ASKED),
    level(REPEATS, Kind::I64, "Runs the median is taken of."),
    GROUP.row(PEAK, Kind::F64, ROWS, Dimension::Memory, "Peak resident memory of the process meanwhile, NaN where unknown.").volatile().optional(NOT_ASKED),
    GROUP.row(ADVICE, Kind::Text, &[], Dimension::Number, "The cheapest way to 5, 2 and 1 per cent.").volatile().optional(NOT_ASKED),
    GROUP.row(REFERENCE_ENERGY, Kind::F64, &[], Dimension::Energy, "u.Au / 2 - l.u of the reference.").symbol("J").volatile().optional(NOT_ASKED),
    GROUP.row(REFERENCE_NORMAL, Kind::F64, &[], Dimension::FORCE, "Total normal contact force of the reference.").volatile().optional(NO_CONTACT),
    GROUP.row(REFERENCE_TANGENTIAL, Kind::F64, &[axes::FRICTION_AXES], Dimension::FORCE, "Its total tangential multiplier force along t1 and t2.").volatile().optional(NO_FRICTION),
];

/// Writes all ways and their reference.
pub(super) fn write(writer: &mut GroupWriter<'_>, ways: &Ways) -> Result<(), StoreError> {
    let reference = (ways.reference.kind, &ways.reference.level);
    let levels = ways
        .ways
        .iter()
        .flat_map(|way| way.levels.iter().map(|level| (way.kind, level)));
    let rows: Vec<(WayKind, &WayLevel)> = levels.chain([reference]).collect();
    let mut columns = Columns::new(writer, &rows);
    columns.members(WAY, |(kind, _)| StoredWay::from(*kind))?;
    columns.counts(N_FREE, |(_, level)| level.n_free)?;
    columns.counts(N_TETRAHEDRA, |(_, level)| level.n_tetrahedra)?;
    columns.counts(N_MULTIPLIERS, |(_, level)| level.n_multipliers)?;
    columns.members(STATUS, |(_, level)| StoredStatus::from(level.status))?;
    columns.numbers(ESTIMATED_ERROR, |(_, level)| level.estimated_error)?;
    columns.numbers(CONTACT_ERROR, |(_, level)| level.contact_error)?;
    columns.numbers(ENERGY_ERROR, |(_, level)| level.error.unwrap_or(f64::NAN))?;
    let costs: Vec<Option<Cost>> = rows.iter().map(|(_, level)| Some(level.cost)).collect();
    write_costs(writer, [SECONDS, REPEATS, PEAK], &costs)?;
    writer.write_text(ADVICE, &ways.advice().to_string())?;
    writer.write(REFERENCE_ENERGY, &[ways.reference.potential_energy], &[])?;
    if let Some(forces) = ways.reference.forces {
        writer.write(REFERENCE_NORMAL, &[forces.normal], &[])?;
        if let Some(pair) = forces.tangential {
            writer.write(REFERENCE_TANGENTIAL, &pair, &[2])?;
        }
    }
    Ok(())
}

/// The ways; `None` in a file without them.
pub(super) fn read(reader: &Reader) -> Result<Option<Ways>, FormatError> {
    if !reader.has(WAY) {
        return Ok(None);
    }
    let kinds = reader.read_enum::<StoredWay>(WAY)?;
    let n_free = read_index_vec(reader, N_FREE)?;
    let n_tetrahedra = read_index_vec(reader, N_TETRAHEDRA)?;
    let n_multipliers = read_index_vec(reader, N_MULTIPLIERS)?;
    let statuses = reader.read_enum::<StoredStatus>(STATUS)?;
    let estimated: Vec<f64> = reader.read_vec(ESTIMATED_ERROR)?;
    let contact: Vec<f64> = reader.read_vec(CONTACT_ERROR)?;
    let errors: Vec<f64> = reader.read_vec(ENERGY_ERROR)?;
    let costs = read_costs(reader, [SECONDS, REPEATS, PEAK])?;
    let level = |k: usize| WayLevel {
        n_free: n_free[k],
        n_tetrahedra: n_tetrahedra[k],
        n_multipliers: n_multipliers[k],
        status: statuses[k].into(),
        estimated_error: estimated[k],
        contact_error: contact[k],
        error: Some(errors[k]).filter(|error| !error.is_nan()),
        cost: costs[k],
    };
    let last = kinds.len().saturating_sub(1);
    let ways = WayKind::ALL.map(|kind| Way {
        kind,
        levels: (0..last)
            .filter(|k| WayKind::from(kinds[*k]) == kind)
            .map(level)
            .collect(),
    });
    Ok(Some(Ways {
        ways: ways.to_vec(),
        reference: Reference {
            kind: kinds[last].into(),
            level: level(last),
            potential_energy: read_scalar(reader, REFERENCE_ENERGY)?,
            forces: read_forces(reader)?,
        },
    }))
}

fn read_forces(reader: &Reader) -> Result<Option<Forces>, FormatError> {
    if !reader.has(REFERENCE_NORMAL) {
        return Ok(None);
    }
    let tangential = match reader.has(REFERENCE_TANGENTIAL) {
        true => {
            let pair: Vec<f64> = reader.read_vec(REFERENCE_TANGENTIAL)?;
            Some([pair[0], pair[1]])
        }
        false => None,
    };
    Ok(Some(Forces {
        normal: read_scalar(reader, REFERENCE_NORMAL)?,
        tangential,
    }))
}

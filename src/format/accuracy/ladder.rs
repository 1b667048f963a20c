//! `/accuracy/rungs`: the algebraic ladder.

use contact3d::{
    convergence::{AlgebraicLadder, Cost, LadderEntry, LadderMethod, LadderResult, Operator},
    solver::Status,
};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named},
    GroupWriter, Kind, Reader, StoreError, StoredEnum,
};
use units::Dimension;

use super::{GROUP, NO_CONTACT, read_costs, write_costs};
use crate::format::{
    FormatError,
    columns::Columns,
    enumeration::{read_member, stored_as},
    outcome::StoredStatus,
    read_index_vec, read_scalar,
};

stored_as! {
    /// A method of the ladder, as stored.
    StoredMethod of LadderMethod as "ladder_method" {
        FixedPrecision = 0 => "fixed_point_a",
        AdaptivePrecision = 1 => "fixed_point_b",
        Newton = 2 => "newton",
    }
}

stored_as! {
    /// How the dual operator is held, as stored.
    StoredOperator of Operator as "operator" {
        Implicit = 0 => "implicit",
        Explicit = 1 => "explicit",
    }
}

const REFERENCE_STATUS: &str = "/accuracy/reference_status";
const REFERENCE_ACCURACY: &str = "/accuracy/reference_accuracy";
const ASSEMBLY_SECONDS: &str = "/accuracy/assembly/seconds";
const ASSEMBLY_REPEATS: &str = "/accuracy/assembly/repeats";
const ASSEMBLY_PEAK: &str = "/accuracy/assembly/peak_memory";
const METHOD: &str = "/accuracy/rungs/method";
const OPERATOR: &str = "/accuracy/rungs/operator";
const EPSILON: &str = "/accuracy/rungs/epsilon";
const RUN: &str = "/accuracy/rungs/run";
const ENTRY_STATUS: &str = "/accuracy/rungs/status";
const ENERGY_ERROR: &str = "/accuracy/rungs/energy_error";
const MULTIPLIER_ERROR: &str = "/accuracy/rungs/multiplier_error";
const ENTRY_APPLICATIONS: &str = "/accuracy/rungs/actions";
const ENTRY_SECONDS: &str = "/accuracy/rungs/seconds";
const ENTRY_REPEATS: &str = "/accuracy/rungs/repeats";
const ENTRY_PEAK: &str = "/accuracy/rungs/peak_memory";
const RUNGS: &[Extent] = &[Named("n_rungs")];
const OF_OPERATORS: &[Extent] = &[Fixed(2)];

/// A row of the algebraic ladder.
const fn entry(
    path: &'static str,
    kind: Kind,
    dimension: Dimension,
    meaning: &'static str,
) -> DatasetSpec {
    GROUP
        .row(path, kind, RUNGS, dimension, meaning)
        .optional(NO_CONTACT)
}

#[rustfmt::skip]
pub(in crate::format) const TABLE: &[DatasetSpec] = &[
    GROUP.row(REFERENCE_STATUS, Kind::Enum(StoredStatus::SPEC), &[], Dimension::Number, "How the reference ended: Newton's method on the explicit operator to rounding.").optional(NO_CONTACT),
    GROUP.row(REFERENCE_ACCURACY, Kind::F64, &[], Dimension::Number, "Last relative residual of the reference.").optional(NO_CONTACT),
    GROUP.row(ASSEMBLY_SECONDS, Kind::F64, OF_OPERATORS, Dimension::Time, "Median wall-clock time of assembly with the implicit and the explicit operator.").volatile().optional(NO_CONTACT),
    GROUP.row(ASSEMBLY_REPEATS, Kind::I64, OF_OPERATORS, Dimension::Number, "Runs the median is taken of.").volatile().optional(NO_CONTACT),
    GROUP.row(ASSEMBLY_PEAK, Kind::F64, OF_OPERATORS, Dimension::Memory, "Peak resident memory of the process meanwhile, NaN where unknown.").volatile().optional(NO_CONTACT),
    entry(METHOD, Kind::Enum(StoredMethod::SPEC), Dimension::Number, "Method."),
    entry(OPERATOR, Kind::Enum(StoredOperator::SPEC), Dimension::Number, "How the dual operator is held."),
    entry(EPSILON, Kind::F64, Dimension::Number, "Accuracy asked for.").symbol("epsilon"),
    entry(RUN, Kind::U8, Dimension::Number, "1 where it was run; 0 where the budget did not suffice, and its results are NaN or 0.").volatile(),
    entry(ENTRY_STATUS, Kind::Enum(StoredStatus::SPEC), Dimension::Number, "How the solve ended.").volatile(),
    entry(ENERGY_ERROR, Kind::F64, Dimension::Number, "|u - u*|_A / |u*|_A with the reference u*.").volatile(),
    entry(MULTIPLIER_ERROR, Kind::F64, Dimension::Number, "|lambda - lambda*| / |lambda*| with the reference lambda*.").volatile(),
    entry(ENTRY_APPLICATIONS, Kind::I64, Dimension::Number, "Applications of the dual operator.").symbol("n_A").volatile(),
    entry(ENTRY_SECONDS, Kind::F64, Dimension::Time, "Median wall-clock time of the solve alone.").volatile(),
    entry(ENTRY_REPEATS, Kind::I64, Dimension::Number, "Runs the median is taken of.").volatile(),
    entry(ENTRY_PEAK, Kind::F64, Dimension::Memory, "Peak resident memory of the process meanwhile, NaN where unknown.").volatile(),
];

pub(super) fn write(
    writer: &mut GroupWriter<'_>,
    ladder: &AlgebraicLadder,
) -> Result<(), StoreError> {
    writer.write_enum(
        REFERENCE_STATUS,
        &[StoredStatus::from(ladder.reference_status)],
        &[],
    )?;
    writer.write(REFERENCE_ACCURACY, &[ladder.reference_accuracy], &[])?;
    write_costs(
        writer,
        [ASSEMBLY_SECONDS, ASSEMBLY_REPEATS, ASSEMBLY_PEAK],
        &ladder.assembly.map(Some),
    )?;
    let mut columns = Columns::new(writer, &ladder.entries);
    columns.members(METHOD, |entry| StoredMethod::from(entry.method))?;
    columns.members(OPERATOR, |entry| StoredOperator::from(entry.operator))?;
    columns.numbers(EPSILON, |entry| entry.epsilon)?;
    columns.flags(RUN, |entry| entry.result.is_some())?;
    let results: Vec<Option<LadderResult>> =
        ladder.entries.iter().map(|entry| entry.result).collect();
    let mut columns = Columns::new(writer, &results);
    columns.members(ENTRY_STATUS, |result| {
        let status = result.map_or(Status::MaxInnerApplications, |r| r.status);
        StoredStatus::from(status)
    })?;
    columns.numbers(ENERGY_ERROR, |r| r.map_or(f64::NAN, |r| r.energy_error))?;
    columns.numbers(MULTIPLIER_ERROR, |r| {
        r.map_or(f64::NAN, |r| r.multiplier_error)
    })?;
    columns.counts(ENTRY_APPLICATIONS, |r| r.map_or(0, |r| r.applications))?;
    let costs: Vec<Option<Cost>> = results.iter().map(|r| r.map(|r| r.cost)).collect();
    write_costs(writer, [ENTRY_SECONDS, ENTRY_REPEATS, ENTRY_PEAK], &costs)
}

/// The algebraic ladder; `None` in a file without it.
pub(super) fn read(reader: &Reader) -> Result<Option<AlgebraicLadder>, FormatError> {
    if !reader.has(REFERENCE_STATUS) {
        return Ok(None);
    }
    let methods = reader.read_enum::<StoredMethod>(METHOD)?;
    let operators = reader.read_enum::<StoredOperator>(OPERATOR)?;
    let epsilons: Vec<f64> = reader.read_vec(EPSILON)?;
    let runs: Vec<u8> = reader.read_vec(RUN)?;
    let statuses = reader.read_enum::<StoredStatus>(ENTRY_STATUS)?;
    let energy: Vec<f64> = reader.read_vec(ENERGY_ERROR)?;
    let multiplier: Vec<f64> = reader.read_vec(MULTIPLIER_ERROR)?;
    let applications = read_index_vec(reader, ENTRY_APPLICATIONS)?;
    let costs = read_costs(reader, [ENTRY_SECONDS, ENTRY_REPEATS, ENTRY_PEAK])?;
    let entries = (0..epsilons.len()).map(|k| LadderEntry {
        method: methods[k].into(),
        operator: operators[k].into(),
        epsilon: epsilons[k],
        result: (runs[k] != 0).then(|| LadderResult {
            status: statuses[k].into(),
            energy_error: energy[k],
            multiplier_error: multiplier[k],
            applications: applications[k],
            cost: costs[k],
        }),
    });
    let entries = entries.collect();
    let assembly = read_costs(reader, [ASSEMBLY_SECONDS, ASSEMBLY_REPEATS, ASSEMBLY_PEAK])?;
    Ok(Some(AlgebraicLadder {
        reference_status: read_member::<StoredStatus>(reader, REFERENCE_STATUS)?.into(),
        reference_accuracy: read_scalar(reader, REFERENCE_ACCURACY)?,
        assembly: [assembly[0], assembly[1]],
        entries,
    }))
}

//! `/accuracy`: errors and costs of solvers and meshes.

use super::{FormatError, read_index_vec, solve::StoredStatus};
use crate::{
    accuracy::{
        Accuracy, AlgebraicLadder, Cost, DiscretisationLadder, Forces, Level, Operator, Rung,
        RungMethod, RungResult,
    },
    solver::Status,
    store::{
        DatasetSpec, Extent,
        Extent::{Fixed, Named},
        Kind, Reader, Stage, StageWriter, StoreError, StoredEnum, stored_enum,
    },
};

stored_enum! {
    /// A method of the ladder, as stored.
    enum StoredMethod as "ladder_method" {
        FixedPrecision = 0 => "fixed_point_a",
        AdaptivePrecision = 1 => "fixed_point_b",
        Newton = 2 => "newton",
    }
}

stored_enum! {
    /// How the dual operator is held, as stored.
    enum StoredOperator as "operator" {
        Implicit = 0 => "implicit",
        Explicit = 1 => "explicit",
    }
}

const METHODS: [(StoredMethod, RungMethod); 3] = [
    (StoredMethod::FixedPrecision, RungMethod::FixedPrecision),
    (
        StoredMethod::AdaptivePrecision,
        RungMethod::AdaptivePrecision,
    ),
    (StoredMethod::Newton, RungMethod::Newton),
];

const OPERATORS: [(StoredOperator, Operator); 2] = [
    (StoredOperator::Implicit, Operator::Implicit),
    (StoredOperator::Explicit, Operator::Explicit),
];

const ADVICE: &str = "/accuracy/advice";
const REFERENCE_STATUS: &str = "/accuracy/reference_status";
const REFERENCE_ACCURACY: &str = "/accuracy/reference_accuracy";
const ASSEMBLY_SECONDS: &str = "/accuracy/assembly/seconds";
const ASSEMBLY_REPEATS: &str = "/accuracy/assembly/repeats";
const ASSEMBLY_PEAK: &str = "/accuracy/assembly/peak_memory";
const METHOD: &str = "/accuracy/rungs/method";
const OPERATOR: &str = "/accuracy/rungs/operator";
const EPSILON: &str = "/accuracy/rungs/epsilon";
const RUN: &str = "/accuracy/rungs/run";
const RUNG_STATUS: &str = "/accuracy/rungs/status";
const ENERGY_ERROR: &str = "/accuracy/rungs/energy_error";
const MULTIPLIER_ERROR: &str = "/accuracy/rungs/multiplier_error";
const RUNG_ACTIONS: &str = "/accuracy/rungs/actions";
const RUNG_SECONDS: &str = "/accuracy/rungs/seconds";
const RUNG_REPEATS: &str = "/accuracy/rungs/repeats";
const RUNG_PEAK: &str = "/accuracy/rungs/peak_memory";
const SCENE_N_DIV: &str = "/accuracy/scene_n_div";
const N_DIV: &str = "/accuracy/levels/n_div";
const CELLS: &str = "/accuracy/levels/cells";
const CELL_SIZE: &str = "/accuracy/levels/cell_size";
const N_FREE: &str = "/accuracy/levels/unknowns";
const N_MULTIPLIERS: &str = "/accuracy/levels/multipliers";
const LEVEL_STATUS: &str = "/accuracy/levels/status";
const LEVEL_ACTIONS: &str = "/accuracy/levels/actions";
const ENERGY_DIFFERENCE: &str = "/accuracy/levels/energy_difference";
const LEVEL_ENERGY_ERROR: &str = "/accuracy/levels/energy_error";
const POTENTIAL_ENERGY: &str = "/accuracy/levels/potential_energy";
const NORMAL_FORCE: &str = "/accuracy/levels/normal_force";
const TANGENTIAL_FORCE: &str = "/accuracy/levels/tangential_force";
const LEVEL_SECONDS: &str = "/accuracy/levels/seconds";
const LEVEL_REPEATS: &str = "/accuracy/levels/repeats";
const LEVEL_PEAK: &str = "/accuracy/levels/peak_memory";
const ENERGY_NORM_ORDER: &str = "/accuracy/order/energy_norm";
const POTENTIAL_ENERGY_ORDER: &str = "/accuracy/order/potential_energy";
const FORCE_ORDER: &str = "/accuracy/order/forces";
const POTENTIAL_ENERGY_LIMIT: &str = "/accuracy/limit/potential_energy";
const FORCE_LIMIT: &str = "/accuracy/limit/forces";

const NO_CONTACT: &str = "absent without contact";
const NO_FRICTION: &str = "absent without friction";
const NO_BRICK: &str = "absent for a mesh file, which has no finer meshes";
const RUNGS: &[Extent] = &[Named("n_rungs")];
const LEVELS: &[Extent] = &[Named("n_levels")];
const OF_OPERATORS: &[Extent] = &[Fixed(2)];

/// A row of the algebraic ladder.
const fn rung(
    path: &'static str,
    kind: Kind,
    unit: &'static str,
    meaning: &'static str,
) -> DatasetSpec {
    Stage::Accuracy
        .row(path, kind, RUNGS, unit, meaning)
        .optional(NO_CONTACT)
}

/// A row of the discretisation ladder.
const fn level(
    path: &'static str,
    kind: Kind,
    unit: &'static str,
    meaning: &'static str,
) -> DatasetSpec {
    Stage::Accuracy
        .row(path, kind, LEVELS, unit, meaning)
        .optional(NO_BRICK)
}

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    Stage::Accuracy.row(ADVICE, Kind::Text, &[], "1", "What the ladders mean for this mesh, in one sentence.").volatile(),
    Stage::Accuracy.row(REFERENCE_STATUS, Kind::Enum(StoredStatus::SPEC), &[], "1", "How the reference ended: Newton's method on the explicit operator to rounding.").optional(NO_CONTACT),
    Stage::Accuracy.row(REFERENCE_ACCURACY, Kind::F64, &[], "1", "Last relative residual of the reference.").optional(NO_CONTACT),
    Stage::Accuracy.row(ASSEMBLY_SECONDS, Kind::F64, OF_OPERATORS, "s", "Median wall-clock time of assembly with the implicit and the explicit operator.").volatile().optional(NO_CONTACT),
    Stage::Accuracy.row(ASSEMBLY_REPEATS, Kind::I64, OF_OPERATORS, "1", "Runs the median is taken of.").volatile().optional(NO_CONTACT),
    Stage::Accuracy.row(ASSEMBLY_PEAK, Kind::F64, OF_OPERATORS, "B", "Peak resident memory of the process meanwhile, NaN where unknown.").volatile().optional(NO_CONTACT),
    rung(METHOD, Kind::Enum(StoredMethod::SPEC), "1", "Method."),
    rung(OPERATOR, Kind::Enum(StoredOperator::SPEC), "1", "How the dual operator is held."),
    rung(EPSILON, Kind::F64, "1", "Accuracy asked for.").symbol("epsilon"),
    rung(RUN, Kind::U8, "1", "1 where it was run; 0 where the budget did not suffice, and its results are NaN or 0.").volatile(),
    rung(RUNG_STATUS, Kind::Enum(StoredStatus::SPEC), "1", "How the solve ended.").volatile(),
    rung(ENERGY_ERROR, Kind::F64, "1", "|u - u*|_A / |u*|_A with the reference u*.").volatile(),
    rung(MULTIPLIER_ERROR, Kind::F64, "1", "|lambda - lambda*| / |lambda*| with the reference lambda*.").volatile(),
    rung(RUNG_ACTIONS, Kind::I64, "1", "Actions of the dual operator.").symbol("n_A").volatile(),
    rung(RUNG_SECONDS, Kind::F64, "s", "Median wall-clock time of the solve alone.").volatile(),
    rung(RUNG_REPEATS, Kind::I64, "1", "Runs the median is taken of.").volatile(),
    rung(RUNG_PEAK, Kind::F64, "B", "Peak resident memory of the process meanwhile, NaN where unknown.").volatile(),
    Stage::Accuracy.row(SCENE_N_DIV, Kind::I64, &[], "1", "Smallest number of cells along an edge in the scene itself.").optional(NO_BRICK),
    level(N_DIV, Kind::I64, "1", "Smallest number of cells along an edge.").symbol("n_div"),
    Stage::Accuracy.row(CELLS, Kind::I64, &[Named("n_levels"), Fixed(3)], "1", "Cells along the edges.").optional(NO_BRICK),
    level(CELL_SIZE, Kind::F64, "m", "Cube root of the volume of a cell.").symbol("h"),
    level(N_FREE, Kind::I64, "1", "Free degrees of freedom."),
    level(N_MULTIPLIERS, Kind::I64, "1", "Multipliers."),
    level(LEVEL_STATUS, Kind::Enum(StoredStatus::SPEC), "1", "How the solve ended."),
    level(LEVEL_ACTIONS, Kind::I64, "1", "Actions of the dual operator.").symbol("n_A"),
    level(ENERGY_DIFFERENCE, Kind::F64, "1", "|u_h - u_f|_A / |u_f|_A with u_f of the finest mesh.").symbol("e_h"),
    level(LEVEL_ENERGY_ERROR, Kind::F64, "1", "|u_h - u|_A / |u_f|_A with the extrapolated limit of e_h^2; NaN where no order is observed."),
    level(POTENTIAL_ENERGY, Kind::F64, "J", "u.Au / 2 - l.u.").symbol("J"),
    level(NORMAL_FORCE, Kind::F64, "N", "Total normal contact force.").optional(NO_CONTACT),
    Stage::Accuracy.row(TANGENTIAL_FORCE, Kind::F64, &[Named("n_levels"), Fixed(2)], "N", "Total tangential multiplier force along t1 and t2.").optional(NO_FRICTION),
    level(LEVEL_SECONDS, Kind::F64, "s", "Median wall-clock time of mesh, assembly, solve and evaluation in memory.").volatile(),
    level(LEVEL_REPEATS, Kind::I64, "1", "Runs the median is taken of.").volatile(),
    level(LEVEL_PEAK, Kind::F64, "B", "Peak resident memory of the process meanwhile, NaN where unknown.").volatile(),
    level(ENERGY_NORM_ORDER, Kind::F64, "1", "Order of the energy-norm error observed from each level and the two before it; NaN where none is.").symbol("p"),
    level(POTENTIAL_ENERGY_ORDER, Kind::F64, "1", "Order of the potential energy, likewise."),
    Stage::Accuracy.row(FORCE_ORDER, Kind::F64, &[Named("n_levels"), Fixed(3)], "1", "Orders of the normal and the two tangential forces, likewise; NaN for forces the scene does not have.").optional(NO_CONTACT),
    Stage::Accuracy.row(POTENTIAL_ENERGY_LIMIT, Kind::F64, &[], "J", "Extrapolated potential energy; NaN where no order is observed.").optional(NO_BRICK),
    Stage::Accuracy.row(FORCE_LIMIT, Kind::F64, &[Fixed(3)], "N", "Extrapolated normal and tangential forces, likewise.").optional(NO_CONTACT),
];

/// Writes both ladders and their advice.
///
/// # Errors
/// HDF5 failures.
pub fn write(writer: &mut StageWriter<'_>, accuracy: &Accuracy) -> Result<(), StoreError> {
    writer.write_text(ADVICE, &accuracy.advice().to_string())?;
    if let Some(ladder) = &accuracy.algebraic {
        write_algebraic(writer, ladder)?;
    }
    if let Some(ladder) = &accuracy.discretisation {
        write_levels(writer, ladder)?;
        write_trends(writer, ladder)?;
    }
    Ok(())
}

fn write_algebraic(
    writer: &mut StageWriter<'_>,
    ladder: &AlgebraicLadder,
) -> Result<(), StoreError> {
    writer.write_enum(
        REFERENCE_STATUS,
        &[StoredStatus::of(ladder.reference_status)],
        &[],
    )?;
    writer.write(REFERENCE_ACCURACY, &[ladder.reference_accuracy], &[])?;
    write_costs(
        writer,
        [ASSEMBLY_SECONDS, ASSEMBLY_REPEATS, ASSEMBLY_PEAK],
        &ladder.assembly.map(Some),
    )?;
    let rungs = &ladder.rungs;
    let n = [rungs.len()];
    let methods = rungs.iter().map(|r| stored(&METHODS, r.method));
    writer.write_enum(METHOD, &methods.collect::<Vec<_>>(), &n)?;
    let operators = rungs.iter().map(|r| stored(&OPERATORS, r.operator));
    writer.write_enum(OPERATOR, &operators.collect::<Vec<_>>(), &n)?;
    let epsilons: Vec<f64> = rungs.iter().map(|rung| rung.epsilon).collect();
    writer.write(EPSILON, &epsilons, &n)?;
    let runs: Vec<u8> = rungs
        .iter()
        .map(|rung| u8::from(rung.result.is_some()))
        .collect();
    writer.write(RUN, &runs, &n)?;
    let results: Vec<Option<RungResult>> = rungs.iter().map(|rung| rung.result).collect();
    let statuses = results.iter().map(|result| {
        let status = result.map_or(Status::MaxInnerActions, |r| r.status);
        StoredStatus::of(status)
    });
    writer.write_enum(RUNG_STATUS, &statuses.collect::<Vec<_>>(), &n)?;
    let measured = |value: fn(RungResult) -> f64| -> Vec<f64> {
        results.iter().map(|r| r.map_or(f64::NAN, value)).collect()
    };
    writer.write(ENERGY_ERROR, &measured(|r| r.energy_error), &n)?;
    writer.write(MULTIPLIER_ERROR, &measured(|r| r.multiplier_error), &n)?;
    let actions: Vec<usize> = results.iter().map(|r| r.map_or(0, |r| r.actions)).collect();
    writer.write_indices(RUNG_ACTIONS, &actions, &n)?;
    let costs: Vec<Option<Cost>> = results.iter().map(|r| r.map(|r| r.cost)).collect();
    write_costs(writer, [RUNG_SECONDS, RUNG_REPEATS, RUNG_PEAK], &costs)
}

/// Writes seconds, repeats and peak memory; NaN and 0 for what was not run.
fn write_costs(
    writer: &mut StageWriter<'_>,
    [seconds, repeats, peak]: [&str; 3],
    costs: &[Option<Cost>],
) -> Result<(), StoreError> {
    let n = [costs.len()];
    let measured = |value: fn(Cost) -> f64| -> Vec<f64> {
        costs.iter().map(|c| c.map_or(f64::NAN, value)).collect()
    };
    writer.write(seconds, &measured(|cost| cost.seconds), &n)?;
    let counts: Vec<usize> = costs.iter().map(|c| c.map_or(0, |c| c.repeats)).collect();
    writer.write_indices(repeats, &counts, &n)?;
    let peaks = measured(|cost| cost.peak_bytes.unwrap_or(f64::NAN));
    writer.write(peak, &peaks, &n)
}

fn write_levels(
    writer: &mut StageWriter<'_>,
    ladder: &DiscretisationLadder,
) -> Result<(), StoreError> {
    let levels = &ladder.levels;
    let n = [levels.len()];
    writer.write_indices(SCENE_N_DIV, &[ladder.scene_n_div], &[])?;
    type Count = fn(&Level) -> usize;
    let counts: [(&str, Count); 4] = [
        (N_DIV, |l| l.n_div),
        (N_FREE, |l| l.n_free),
        (N_MULTIPLIERS, |l| l.n_multipliers),
        (LEVEL_ACTIONS, |l| l.actions),
    ];
    for (path, count) in counts {
        let values: Vec<usize> = levels.iter().map(count).collect();
        writer.write_indices(path, &values, &n)?;
    }
    let cells: Vec<usize> = levels.iter().flat_map(|level| level.cells).collect();
    writer.write_indices(CELLS, &cells, &[levels.len(), 3])?;
    let statuses = levels.iter().map(|level| StoredStatus::of(level.status));
    writer.write_enum(LEVEL_STATUS, &statuses.collect::<Vec<_>>(), &n)?;
    type Measure = fn(&Level) -> f64;
    let measures: [(&str, Measure); 4] = [
        (CELL_SIZE, |l| l.cell_size),
        (ENERGY_DIFFERENCE, |l| l.energy_difference),
        (LEVEL_ENERGY_ERROR, |l| l.energy_error.unwrap_or(f64::NAN)),
        (POTENTIAL_ENERGY, |l| l.potential_energy),
    ];
    for (path, measure) in measures {
        let values: Vec<f64> = levels.iter().map(measure).collect();
        writer.write(path, &values, &n)?;
    }
    let forces: Option<Vec<Forces>> = levels.iter().map(|level| level.forces).collect();
    if let Some(forces) = forces {
        let normal: Vec<f64> = forces.iter().map(|f| f.normal).collect();
        writer.write(NORMAL_FORCE, &normal, &n)?;
        let tangential: Option<Vec<[f64; 2]>> = forces.iter().map(|f| f.tangential).collect();
        if let Some(pairs) = tangential {
            writer.write(TANGENTIAL_FORCE, pairs.as_flattened(), &[levels.len(), 2])?;
        }
    }
    let costs: Vec<Option<Cost>> = levels.iter().map(|level| Some(level.cost)).collect();
    write_costs(writer, [LEVEL_SECONDS, LEVEL_REPEATS, LEVEL_PEAK], &costs)
}

fn write_trends(
    writer: &mut StageWriter<'_>,
    ladder: &DiscretisationLadder,
) -> Result<(), StoreError> {
    let n = ladder.levels.len();
    let known = |value: &Option<f64>| value.unwrap_or(f64::NAN);
    for (path, trend) in [
        (ENERGY_NORM_ORDER, &ladder.energy_norm),
        (POTENTIAL_ENERGY_ORDER, &ladder.potential_energy),
    ] {
        let orders: Vec<f64> = trend.orders.iter().map(known).collect();
        writer.write(path, &orders, &[n])?;
    }
    let limit = known(&ladder.potential_energy.limit);
    writer.write(POTENTIAL_ENERGY_LIMIT, &[limit], &[])?;
    if ladder.forces.is_empty() {
        return Ok(());
    }
    let component = |k: usize| ladder.forces.get(k);
    let order = |level: usize, k: usize| component(k).and_then(|t| t.orders[level]);
    let orders: Vec<f64> = (0..n)
        .flat_map(|level| (0..3).map(move |k| known(&order(level, k))))
        .collect();
    writer.write(FORCE_ORDER, &orders, &[n, 3])?;
    let limits: Vec<f64> = (0..3)
        .map(|k| known(&component(k).and_then(|trend| trend.limit)))
        .collect();
    writer.write(FORCE_LIMIT, &limits, &[3])
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

/// Reads both ladders; orders and limits are computed again.
///
/// # Errors
/// Missing, altered or contradictory datasets.
pub fn read(reader: &Reader) -> Result<Accuracy, FormatError> {
    let algebraic = match reader.has(REFERENCE_STATUS) {
        true => Some(read_algebraic(reader)?),
        false => None,
    };
    let discretisation = match reader.has(N_DIV) {
        true => Some(read_levels(reader)?),
        false => None,
    };
    Ok(Accuracy {
        algebraic,
        discretisation,
    })
}

fn read_algebraic(reader: &Reader) -> Result<AlgebraicLadder, FormatError> {
    let methods = reader.read_enum::<StoredMethod>(METHOD)?;
    let operators = reader.read_enum::<StoredOperator>(OPERATOR)?;
    let epsilons: Vec<f64> = reader.read_vec(EPSILON)?;
    let runs: Vec<u8> = reader.read_vec(RUN)?;
    let statuses = reader.read_enum::<StoredStatus>(RUNG_STATUS)?;
    let energy: Vec<f64> = reader.read_vec(ENERGY_ERROR)?;
    let multiplier: Vec<f64> = reader.read_vec(MULTIPLIER_ERROR)?;
    let actions = read_index_vec(reader, RUNG_ACTIONS)?;
    let costs = read_costs(reader, [RUNG_SECONDS, RUNG_REPEATS, RUNG_PEAK])?;
    let rungs = (0..epsilons.len()).map(|k| Rung {
        method: meant(&METHODS, methods[k]),
        operator: meant(&OPERATORS, operators[k]),
        epsilon: epsilons[k],
        result: (runs[k] != 0).then(|| RungResult {
            status: statuses[k].status(),
            energy_error: energy[k],
            multiplier_error: multiplier[k],
            actions: actions[k],
            cost: costs[k],
        }),
    });
    let rungs = rungs.collect();
    let assembly = read_costs(reader, [ASSEMBLY_SECONDS, ASSEMBLY_REPEATS, ASSEMBLY_PEAK])?;
    let status = reader.read_enum::<StoredStatus>(REFERENCE_STATUS)?;
    let accuracy: Vec<f64> = reader.read_vec(REFERENCE_ACCURACY)?;
    Ok(AlgebraicLadder {
        reference_status: status
            .first()
            .map_or(Status::NumericalError, |stored| stored.status()),
        reference_accuracy: accuracy.first().copied().unwrap_or(f64::NAN),
        assembly: [assembly[0], assembly[1]],
        rungs,
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

fn read_levels(reader: &Reader) -> Result<DiscretisationLadder, FormatError> {
    let n_div = read_index_vec(reader, N_DIV)?;
    let cells = read_index_vec(reader, CELLS)?;
    let cell_size: Vec<f64> = reader.read_vec(CELL_SIZE)?;
    let n_free = read_index_vec(reader, N_FREE)?;
    let n_multipliers = read_index_vec(reader, N_MULTIPLIERS)?;
    let statuses = reader.read_enum::<StoredStatus>(LEVEL_STATUS)?;
    let actions = read_index_vec(reader, LEVEL_ACTIONS)?;
    let difference: Vec<f64> = reader.read_vec(ENERGY_DIFFERENCE)?;
    let energies: Vec<f64> = reader.read_vec(POTENTIAL_ENERGY)?;
    let costs = read_costs(reader, [LEVEL_SECONDS, LEVEL_REPEATS, LEVEL_PEAK])?;
    let optional = |path| match reader.has(path) {
        true => reader.read_vec::<f64>(path).map(Some),
        false => Ok(None),
    };
    let normal = optional(NORMAL_FORCE)?;
    let tangential = optional(TANGENTIAL_FORCE)?;
    let forces = |k: usize| {
        Some(Forces {
            normal: normal.as_ref()?[k],
            tangential: tangential.as_ref().map(|t| [t[2 * k], t[2 * k + 1]]),
        })
    };
    let levels = (0..n_div.len()).map(|k| Level {
        n_div: n_div[k],
        cells: [cells[3 * k], cells[3 * k + 1], cells[3 * k + 2]],
        cell_size: cell_size[k],
        n_free: n_free[k],
        n_multipliers: n_multipliers[k],
        status: statuses[k].status(),
        actions: actions[k],
        energy_difference: difference[k],
        energy_error: None,
        potential_energy: energies[k],
        forces: forces(k),
        cost: costs[k],
    });
    let levels = levels.collect();
    let scene_n_div = read_index_vec(reader, SCENE_N_DIV)?;
    Ok(DiscretisationLadder::new(
        scene_n_div.first().copied().unwrap_or(0),
        levels,
    ))
}

/// The stored member of a value.
fn stored<S: Copy, T: PartialEq>(table: &[(S, T)], value: T) -> S {
    let row = table.iter().find(|(_, meaning)| *meaning == value);
    row.unwrap_or(&table[0]).0
}

/// The value of a stored member.
fn meant<S: PartialEq, T: Copy>(table: &[(S, T)], stored: S) -> T {
    let row = table.iter().find(|(member, _)| *member == stored);
    row.unwrap_or(&table[0]).1
}

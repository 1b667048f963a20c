//! `/accuracy`: errors and costs of solvers and meshes.

use contact3d::solver::Status;
use runfile::{
    Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Kind, Reader, StoreError,
};
use studies::accuracy::{
    Accuracy, AlgebraicLadder, DiscretisationLadder, Forces, LadderEntry, LadderMethod,
    LadderResult, Level, Operator, Reference, Way, WayKind, WayLevel, Ways,
};
use units::Dimension;

use super::{
    FormatError, extents,
    fields::{Table, fields, read_if_there, read_value, write_value},
    stored::stored_as,
};

/// Errors and costs of solvers and meshes; computed from the scene alone.
pub const GROUP: Group = Group::new("accuracy", "accuracy");

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

const ADVICE: &str = "/accuracy/advice";
const SCENE_N_DIV: &str = "/accuracy/scene_n_div";

const NO_CONTACT: &str = "absent without contact";
const NO_BRICK: &str = "absent for a mesh file, which has no finer meshes";
const NOT_ASKED: &str = "absent without --ways";
const NO_FORCES: &str = "absent without --ways or contact";
const RUNGS: &[Extent] = &[Named("n_rungs")];
const OF_OPERATORS: &[Extent] = &[Fixed(2)];
const LEVELS: &[Extent] = &[Named("n_levels")];
const WAY_LEVELS: &[Extent] = &[Named("n_way_levels")];

pub(super) const ACCURACY: Table<Accuracy> = fields! { Accuracy => GROUP;
    [|accuracy| accuracy.advice().to_string()] ADVICE, &[], Dimension::Number, "What the ladders mean for this mesh, in one sentence.".volatile();
};

pub(super) const ALGEBRAIC: Table<AlgebraicLadder> = fields! { AlgebraicLadder => GROUP;
    (reference_status) "/accuracy/reference_status", &[], Dimension::Number, "How the reference ended: Newton's method on the explicit operator to rounding.".optional(NO_CONTACT);
    (reference_accuracy) "/accuracy/reference_accuracy", &[], Dimension::Number, "Last relative residual of the reference.".optional(NO_CONTACT);
    (each k in assembly[k].seconds) "/accuracy/assembly/seconds", OF_OPERATORS, Dimension::Time, "Median wall-clock time of assembly with the implicit and the explicit operator.".volatile().optional(NO_CONTACT);
    (each k in assembly[k].repeats) "/accuracy/assembly/repeats", OF_OPERATORS, Dimension::Number, "Runs the median is taken of.".volatile().optional(NO_CONTACT);
    [|ladder| ladder.assembly.map(|cost| cost.peak_bytes.unwrap_or(f64::NAN)), |ladder, peaks: [f64; 2]| put_peaks(ladder, peaks)] "/accuracy/assembly/peak_memory", OF_OPERATORS, Dimension::Memory, "Peak resident memory of the process meanwhile, NaN where unknown.".volatile().optional(NO_CONTACT);
};

pub(super) const ENTRIES: Table<LadderEntry> = fields! { LadderEntry => GROUP;
    (method) "/accuracy/rungs/method", RUNGS, Dimension::Number, "Method.".optional(NO_CONTACT);
    (operator) "/accuracy/rungs/operator", RUNGS, Dimension::Number, "How the dual operator is held.".optional(NO_CONTACT);
    (epsilon) "/accuracy/rungs/epsilon", RUNGS, Dimension::Number, "Accuracy asked for.".symbol("epsilon").optional(NO_CONTACT);
    [|entry| entry.result.is_some(), |entry, is_run: bool| if !is_run { entry.result = None }] "/accuracy/rungs/run", RUNGS, Dimension::Number, "1 where it was run; 0 where the budget did not suffice, and its results are NaN or 0.".volatile().optional(NO_CONTACT);
    [|entry| entry.result.map_or(Status::MaxInnerApplications, |result| result.status), |entry, status| if let Some(result) = &mut entry.result { result.status = status }] "/accuracy/rungs/status", RUNGS, Dimension::Number, "How the solve ended.".volatile().optional(NO_CONTACT);
    (result?.energy_error) "/accuracy/rungs/energy_error", RUNGS, Dimension::Number, "|u - u*|_A / |u*|_A with the reference u*.".volatile().optional(NO_CONTACT);
    (result?.multiplier_error) "/accuracy/rungs/multiplier_error", RUNGS, Dimension::Number, "|lambda - lambda*| / |lambda*| with the reference lambda*.".volatile().optional(NO_CONTACT);
    (result?.applications) "/accuracy/rungs/actions", RUNGS, Dimension::Number, "Applications of the dual operator.".symbol("n_A").volatile().optional(NO_CONTACT);
    (result?.cost.seconds) "/accuracy/rungs/seconds", RUNGS, Dimension::Time, "Median wall-clock time of the solve alone.".volatile().optional(NO_CONTACT);
    (result?.cost.repeats) "/accuracy/rungs/repeats", RUNGS, Dimension::Number, "Runs the median is taken of.".volatile().optional(NO_CONTACT);
    [|entry| entry.result.and_then(|result| result.cost.peak_bytes).unwrap_or(f64::NAN), |entry, peak: f64| if let Some(result) = &mut entry.result { result.cost.peak_bytes = Some(peak).filter(|peak| !peak.is_nan()) }] "/accuracy/rungs/peak_memory", RUNGS, Dimension::Memory, "Peak resident memory of the process meanwhile, NaN where unknown.".volatile().optional(NO_CONTACT);
};

pub(super) const MESHES: Table<Level> = fields! { Level => GROUP;
    {Kind::I64} SCENE_N_DIV, &[], Dimension::Number, "Smallest number of cells along an edge in the scene itself.".optional(NO_BRICK);
    (n_div) "/accuracy/levels/n_div", LEVELS, Dimension::Number, "Smallest number of cells along an edge.".symbol("n_div").optional(NO_BRICK);
    (cells) "/accuracy/levels/cells", &[Named("n_levels"), extents::XYZ], Dimension::Number, "Cells along the edges.".optional(NO_BRICK);
    (cell_size) "/accuracy/levels/cell_size", LEVELS, Dimension::LENGTH, "Cube root of the mean volume of a cell.".symbol("h").optional(NO_BRICK);
    (n_free) "/accuracy/levels/unknowns", LEVELS, Dimension::Number, "Free degrees of freedom.".optional(NO_BRICK);
    (n_multipliers) "/accuracy/levels/multipliers", LEVELS, Dimension::Number, "Multipliers.".optional(NO_BRICK);
    (status) "/accuracy/levels/status", LEVELS, Dimension::Number, "How the solve ended.".optional(NO_BRICK);
    (applications) "/accuracy/levels/actions", LEVELS, Dimension::Number, "Applications of the dual operator.".symbol("n_A").optional(NO_BRICK);
    (energy_difference) "/accuracy/levels/energy_difference", LEVELS, Dimension::Number, "|u_h - u_f|_A / |u_f|_A with u_f of the finest mesh.".symbol("e_h").optional(NO_BRICK);
    [|level| level.energy_error.unwrap_or(f64::NAN)] "/accuracy/levels/energy_error", LEVELS, Dimension::Number, "|u_h - u|_A / |u_f|_A with the extrapolated limit of e_h^2; NaN where no order is observed.".optional(NO_BRICK);
    (estimated_error) "/accuracy/levels/estimated_error", LEVELS, Dimension::Number, "Error of u_h over |u_h|_A as its own report estimates it.".optional("absent for a mesh file, and in files before format 1.4").missing(|level| level.estimated_error = f64::NAN);
    (potential_energy) "/accuracy/levels/potential_energy", LEVELS, Dimension::Energy, "u.Au / 2 - l.u.".symbol("J").optional(NO_BRICK);
    (forces?.normal) "/accuracy/levels/normal_force", LEVELS, Dimension::FORCE, "Total normal contact force.".when((NO_CONTACT, |level| level.forces.is_some())).missing(|level| level.forces = None);
    (forces?.tangential) "/accuracy/levels/tangential_force", &[Named("n_levels"), extents::FRICTION_AXES], Dimension::FORCE, "Total tangential multiplier force along t1 and t2.".optional("absent without friction");
    (cost.seconds) "/accuracy/levels/seconds", LEVELS, Dimension::Time, "Median wall-clock time of mesh, assembly, solve and evaluation in memory.".volatile().optional(NO_BRICK);
    (cost.repeats) "/accuracy/levels/repeats", LEVELS, Dimension::Number, "Runs the median is taken of.".volatile().optional(NO_BRICK);
    (nan cost.peak_bytes) "/accuracy/levels/peak_memory", LEVELS, Dimension::Memory, "Peak resident memory of the process meanwhile, NaN where unknown.".volatile().optional(NO_BRICK);
};

/// Orders and limits, which reading computes again.
pub(super) const TRENDS: Table<DiscretisationLadder> = fields! { DiscretisationLadder => GROUP;
    [|ladder| numbers(&ladder.energy_norm.orders)] "/accuracy/order/energy_norm", LEVELS, Dimension::Number, "Order of the energy-norm error observed from each level and the two before it; NaN where none is.".symbol("p").optional(NO_BRICK);
    [|ladder| numbers(&ladder.potential_energy.orders)] "/accuracy/order/potential_energy", LEVELS, Dimension::Number, "Order of the potential energy, likewise.".optional(NO_BRICK);
    [force_orders] "/accuracy/order/forces", &[Named("n_levels"), extents::CONTACT_AXES], Dimension::Number, "Orders of the normal and the two tangential forces, likewise; NaN for forces the scene does not have.".optional(NO_CONTACT);
    [|ladder| ladder.potential_energy.limit.unwrap_or(f64::NAN)] "/accuracy/limit/potential_energy", &[], Dimension::Energy, "Extrapolated potential energy; NaN where no order is observed.".optional(NO_BRICK);
    [force_limits] "/accuracy/limit/forces", &[extents::CONTACT_AXES], Dimension::FORCE, "Extrapolated normal and tangential forces, likewise.".optional(NO_CONTACT);
};

/// The meshes of all ways, and the reference as the last row; how many there are depends on what fits into the budget.
pub(super) const OF_WAYS: Table<(WayKind, WayLevel)> = fields! { (WayKind, WayLevel) => GROUP;
    (0) "/accuracy/ways/way", WAY_LEVELS, Dimension::Number, "Way of each mesh, coarse to fine; the last row is the reference.".volatile().optional(NOT_ASKED);
    (1.n_free) "/accuracy/ways/unknowns", WAY_LEVELS, Dimension::Number, "Free degrees of freedom.".volatile().optional(NOT_ASKED);
    (1.n_tetrahedra) "/accuracy/ways/tetrahedra", WAY_LEVELS, Dimension::Number, "Tetrahedra.".volatile().optional(NOT_ASKED);
    (1.n_multipliers) "/accuracy/ways/multipliers", WAY_LEVELS, Dimension::Number, "Multipliers.".volatile().optional(NOT_ASKED);
    (1.status) "/accuracy/ways/status", WAY_LEVELS, Dimension::Number, "How the solve ended.".volatile().optional(NOT_ASKED);
    (1.estimated_error) "/accuracy/ways/estimated_error", WAY_LEVELS, Dimension::Number, "Error of u_h over |u_h|_A as its own report estimates it.".volatile().optional(NOT_ASKED);
    (1.contact_error) "/accuracy/ways/contact_error", WAY_LEVELS, Dimension::Number, "The part of it that the multipliers are to blame for; 0 without contact.".volatile().optional(NOT_ASKED);
    (nan 1.error) "/accuracy/ways/energy_error", WAY_LEVELS, Dimension::Number, "|u_h - u_r|_A / |u_r|_A with the reference u_r; NaN where its estimated error is more than half of that of u_h.".volatile().optional(NOT_ASKED);
    (1.cost.seconds) "/accuracy/ways/seconds", WAY_LEVELS, Dimension::Time, "Median wall-clock time of mesh, assembly, solve and evaluation in memory; of an adaptive mesh with all coarser ones.".volatile().optional(NOT_ASKED);
    (1.cost.repeats) "/accuracy/ways/repeats", WAY_LEVELS, Dimension::Number, "Runs the median is taken of.".volatile().optional(NOT_ASKED);
    (nan 1.cost.peak_bytes) "/accuracy/ways/peak_memory", WAY_LEVELS, Dimension::Memory, "Peak resident memory of the process meanwhile, NaN where unknown.".volatile().optional(NOT_ASKED);
};

pub(super) const WAYS: Table<Ways> = fields! { Ways => GROUP;
    [|ways| ways.advice().to_string()] "/accuracy/ways/advice", &[], Dimension::Number, "The cheapest way to 5, 2 and 1 per cent.".volatile().optional(NOT_ASKED);
    (reference.potential_energy) "/accuracy/ways/reference/potential_energy", &[], Dimension::Energy, "u.Au / 2 - l.u of the reference.".symbol("J").volatile().optional(NOT_ASKED);
    (reference.forces?.normal) "/accuracy/ways/reference/normal_force", &[], Dimension::FORCE, "Total normal contact force of the reference.".volatile().when((NO_FORCES, |ways| ways.reference.forces.is_some())).missing(|ways| ways.reference.forces = None);
    (reference.forces?.tangential) "/accuracy/ways/reference/tangential_force", &[extents::FRICTION_AXES], Dimension::FORCE, "Its total tangential multiplier force along t1 and t2.".volatile().optional("absent without --ways or friction");
};

fn put_peaks(ladder: &mut AlgebraicLadder, peaks: [f64; 2]) {
    for (cost, peak) in ladder.assembly.iter_mut().zip(peaks) {
        cost.peak_bytes = Some(peak).filter(|peak| !peak.is_nan());
    }
}

/// Numbers of which some are not known; these are NaN.
fn numbers(values: &[Option<f64>]) -> Vec<f64> {
    let values = values.iter().map(|value| value.unwrap_or(f64::NAN));
    values.collect()
}

/// Orders of the forces by levels; none without contact.
fn force_orders(ladder: &DiscretisationLadder) -> Vec<[f64; 3]> {
    let order = |level: usize, k: usize| ladder.forces.get(k).and_then(|trend| trend.orders[level]);
    let of_level = |level| std::array::from_fn(|k| order(level, k).unwrap_or(f64::NAN));
    let n = if ladder.forces.is_empty() {
        0
    } else {
        ladder.levels.len()
    };
    (0..n).map(of_level).collect()
}

/// Limits of the forces; none without contact.
fn force_limits(ladder: &DiscretisationLadder) -> Option<[f64; 3]> {
    let limit = |k: usize| ladder.forces.get(k).and_then(|trend| trend.limit);
    let limits = std::array::from_fn(|k| limit(k).unwrap_or(f64::NAN));
    Some(limits).filter(|_| !ladder.forces.is_empty())
}

/// Writes both ladders, the ways and their advice.
///
/// # Errors
/// HDF5 failures.
pub fn write(writer: &mut GroupWriter<'_>, accuracy: &Accuracy) -> Result<(), StoreError> {
    ACCURACY.write_one(writer, accuracy)?;
    if let Some(ladder) = &accuracy.algebraic {
        ALGEBRAIC.write_one(writer, ladder)?;
        ENTRIES.write_rows(writer, &ladder.entries)?;
    }
    if let Some(ladder) = &accuracy.discretisation {
        write_value(writer, SCENE_N_DIV, &ladder.scene_n_div)?;
        MESHES.write_rows(writer, &ladder.levels)?;
        TRENDS.write_one(writer, ladder)?;
    }
    if let Some(ways) = &accuracy.ways {
        let levels = ways
            .ways
            .iter()
            .flat_map(|way| way.levels.iter().map(|level| (way.kind, level.clone())));
        let reference = (ways.reference.kind, ways.reference.level.clone());
        let levels: Vec<(WayKind, WayLevel)> = levels.chain([reference]).collect();
        OF_WAYS.write_rows(writer, &levels)?;
        WAYS.write_one(writer, ways)?;
    }
    Ok(())
}

/// Reads the sentence; `None` in a file without ladders.
///
/// # Errors
/// An altered dataset.
pub fn read_advice(reader: &Reader) -> Result<Option<String>, FormatError> {
    read_if_there(reader, ADVICE)
}

/// Reads both ladders and the ways; orders and limits are computed again.
///
/// # Errors
/// Missing, altered or contradictory datasets.
pub fn read(reader: &Reader) -> Result<Accuracy, FormatError> {
    Ok(Accuracy {
        algebraic: ALGEBRAIC
            .is_there(reader)
            .then(|| read_algebraic(reader))
            .transpose()?,
        discretisation: MESHES
            .is_there(reader)
            .then(|| read_discretisation(reader))
            .transpose()?,
        ways: OF_WAYS
            .is_there(reader)
            .then(|| read_ways(reader))
            .transpose()?,
    })
}

fn read_algebraic(reader: &Reader) -> Result<AlgebraicLadder, FormatError> {
    let mut ladder = AlgebraicLadder::default();
    ALGEBRAIC.read_one(reader, &mut ladder, true)?;
    ladder.entries = ENTRIES.read_rows(reader, || LadderEntry {
        method: LadderMethod::Newton,
        operator: Operator::Explicit,
        epsilon: f64::NAN,
        result: Some(LadderResult::default()),
    })?;
    Ok(ladder)
}

fn read_discretisation(reader: &Reader) -> Result<DiscretisationLadder, FormatError> {
    let levels = MESHES.read_rows(reader, || Level {
        forces: Some(Forces::default()),
        ..Level::default()
    })?;
    let scene_n_div = read_value(reader, SCENE_N_DIV)?;
    Ok(DiscretisationLadder::new(scene_n_div, levels))
}

fn read_ways(reader: &Reader) -> Result<Ways, FormatError> {
    let blank = || (WayKind::LinearUniform, WayLevel::default());
    let mut levels = OF_WAYS.read_rows(reader, blank)?;
    let (kind, level) = levels.pop().unwrap_or_else(blank);
    let of_kind = |kind| {
        let levels = levels.iter().filter(|(other, _)| *other == kind);
        levels.map(|(_, level)| level.clone()).collect()
    };
    let mut ways = Ways {
        ways: WayKind::ALL
            .map(|kind| Way {
                kind,
                levels: of_kind(kind),
            })
            .to_vec(),
        reference: Reference {
            kind,
            level,
            potential_energy: f64::NAN,
            forces: Some(Forces::default()),
        },
    };
    WAYS.read_one(reader, &mut ways, true)?;
    Ok(ways)
}

//! `/accuracy`: errors and costs of solvers and meshes.

use contact3d::{
    post::StressConcentration,
    scene::{Functional, Scene},
    solver::Status,
};
use runfile::{
    Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Kind, Reader, StoreError,
};
use studies::accuracy::{
    Accuracy, AlgebraicStudy, DiscretisationStudy, Level, RunMethod, RunOperator, RunResult,
    SolverRun, Trend,
};
use units::Dimension;

use super::{
    FormatError, dimension_of_quantity, extents,
    fields::{Fields, each, fields, read_if_there, read_value, write_list, write_value},
    require,
    stored::stored_as,
};

/// Errors and costs of solvers and meshes; computed from the scene alone.
pub const GROUP: Group = Group::new("accuracy", "accuracy");

stored_as! {
    /// A method of the study, as stored.
    StoredMethod of RunMethod as "solver_run_method" {
        FixedPrecision = 0 => "fixed_point_a",
        AdaptivePrecision = 1 => "fixed_point_b",
        Newton = 2 => "newton",
    }
}

stored_as! {
    /// How the dual operator is held, as stored.
    StoredOperator of RunOperator as "operator" {
        Implicit = 0 => "implicit",
        Explicit = 1 => "explicit",
    }
}

const ADVICE: &str = "/accuracy/advice";
const SCENE_LEVEL: &str = "/accuracy/scene_level";
const QUANTITY: &str = "/accuracy/quantities/name";
const UNIT: &str = "/accuracy/quantities/unit";
const GROWS: &str = "/accuracy/quantities/concentration";

const NO_CONTACT: &str = "absent without contact";
const NO_BRICK: &str = "absent unless the body is one brick";
const SOLVES_AXIS: &[Extent] = &[Named("n_solves")];
const OF_OPERATORS: &[Extent] = &[Fixed(2)];
const LEVELS: &[Extent] = &[Named("n_levels")];
const QUANTITIES: &[Extent] = &[Named("n_accuracy_quantities")];
const OF_LEVELS: &[Extent] = &[Named("n_levels"), Named("n_accuracy_quantities")];

pub(super) const ACCURACY: Fields<Accuracy> = fields! { Accuracy => GROUP;
    {Kind::Text} ADVICE, &[], Dimension::Number, "What the studies mean for this mesh, in one sentence.".volatile();
};

pub(super) const ALGEBRAIC: Fields<AlgebraicStudy> = fields! { AlgebraicStudy => GROUP;
    (reference_status) "/accuracy/reference_status", &[], Dimension::Number, "How the reference ended: Newton's method on the explicit operator to rounding.".optional(NO_CONTACT);
    (reference_accuracy) "/accuracy/reference_accuracy", &[], Dimension::Number, "Last relative residual of the reference.".optional(NO_CONTACT);
    (each k in assembly[k].seconds) "/accuracy/assembly/seconds", OF_OPERATORS, Dimension::Time, "Median wall-clock time of assembly with the implicit and the explicit operator.".volatile().optional(NO_CONTACT);
    (each k in assembly[k].repeats) "/accuracy/assembly/repeats", OF_OPERATORS, Dimension::Number, "Runs the median is taken of.".volatile().optional(NO_CONTACT);
    (each k in assembly[k].peak_bytes) "/accuracy/assembly/peak_memory", OF_OPERATORS, Dimension::Memory, "Peak resident memory of the process meanwhile, NaN where unknown.".volatile().optional(NO_CONTACT);
};

pub(super) const SOLVES: Fields<SolverRun> = fields! { SolverRun => GROUP;
    (method) "/accuracy/solves/method", SOLVES_AXIS, Dimension::Number, "Method.".optional(NO_CONTACT);
    (operator) "/accuracy/solves/operator", SOLVES_AXIS, Dimension::Number, "How the dual operator is held.".optional(NO_CONTACT);
    (epsilon) "/accuracy/solves/epsilon", SOLVES_AXIS, Dimension::Number, "Accuracy asked for.".symbol("epsilon").optional(NO_CONTACT);
    [|entry| entry.result.is_some(), |entry, is_run: bool| if !is_run { entry.result = None }] "/accuracy/solves/run", SOLVES_AXIS, Dimension::Number, "1 where it was run; 0 where the budget did not suffice, and its results are NaN or 0.".volatile().optional(NO_CONTACT);
    [|entry| entry.result.map_or(Status::MaxOperatorApplications, |result| result.status), |entry, status| if let Some(result) = &mut entry.result { result.status = status }] "/accuracy/solves/status", SOLVES_AXIS, Dimension::Number, "How the solve ended.".volatile().optional(NO_CONTACT);
    (result?.energy_error) "/accuracy/solves/energy_error", SOLVES_AXIS, Dimension::Number, "|u - u*|_A / |u*|_A with the reference u*.".volatile().optional(NO_CONTACT);
    (result?.multiplier_error) "/accuracy/solves/multiplier_error", SOLVES_AXIS, Dimension::Number, "|lambda - lambda*| / |lambda*| with the reference lambda*.".volatile().optional(NO_CONTACT);
    (result?.applications) "/accuracy/solves/applications", SOLVES_AXIS, Dimension::Number, "Applications of the dual operator.".symbol("n_A").volatile().optional(NO_CONTACT);
    (result?.cost.seconds) "/accuracy/solves/seconds", SOLVES_AXIS, Dimension::Time, "Median wall-clock time of the solve alone.".volatile().optional(NO_CONTACT);
    (result?.cost.repeats) "/accuracy/solves/repeats", SOLVES_AXIS, Dimension::Number, "Runs the median is taken of.".volatile().optional(NO_CONTACT);
    (result?.cost.peak_bytes) "/accuracy/solves/peak_memory", SOLVES_AXIS, Dimension::Memory, "Peak resident memory of the process meanwhile, NaN where unknown.".volatile().optional(NO_CONTACT);
};

pub(super) const MESHES: Fields<Level> = fields! { Level => GROUP;
    {Kind::I64} SCENE_LEVEL, &[], Dimension::Number, "Which level is the mesh of the scene itself, from 0 on.";
    (cells) "/accuracy/levels/cells", &[Named("n_levels"), extents::XYZ], Dimension::Number, "Cells along the edges.".optional(NO_BRICK);
    (n_tetrahedra) "/accuracy/levels/tetrahedra", LEVELS, Dimension::Number, "Tetrahedra.";
    (size) "/accuracy/levels/size", LEVELS, Dimension::LENGTH, "Cube root of the mean volume of a cell, of a tetrahedron without cells.".symbol("h");
    (n_free) "/accuracy/levels/unknowns", LEVELS, Dimension::Number, "Free degrees of freedom.";
    (n_multipliers) "/accuracy/levels/multipliers", LEVELS, Dimension::Number, "Multipliers.";
    (status) "/accuracy/levels/status", LEVELS, Dimension::Number, "How the solve ended.";
    (applications) "/accuracy/levels/applications", LEVELS, Dimension::Number, "Applications of the dual operator.".symbol("n_A");
    (energy_difference) "/accuracy/levels/energy_difference", LEVELS, Dimension::Number, "|u_h - u_f|_A / |u_f|_A with u_f of the finest mesh.".symbol("e_h");
    [|level| level.energy_error.unwrap_or(f64::NAN)] "/accuracy/levels/energy_error", LEVELS, Dimension::Number, "|u_h - u|_A / |u_f|_A with the extrapolated limit of e_h^2; NaN where no order is observed.";
    (estimated_error) "/accuracy/levels/estimated_error", LEVELS, Dimension::Number, "Error of u_h over |u_h|_A as its own report estimates it.";
    (potential_energy) "/accuracy/levels/potential_energy", LEVELS, Dimension::Energy, "u.Au / 2 - l.u.".symbol("J");
    (quantities) "/accuracy/levels/quantities", OF_LEVELS, Dimension::Number, "Quantities of the solution, each in its own `unit`; NaN for one that the level does not have.".symbol("Q(u_h)");
    (cost.seconds) "/accuracy/levels/seconds", LEVELS, Dimension::Time, "Median wall-clock time of mesh, assembly, solve and evaluation in memory.".volatile();
    (cost.repeats) "/accuracy/levels/repeats", LEVELS, Dimension::Number, "Runs the median is taken of.".volatile();
    (cost.peak_bytes) "/accuracy/levels/peak_memory", LEVELS, Dimension::Memory, "Peak resident memory of the process meanwhile, NaN where unknown.".volatile();
};

/// Orders and limits, which reading computes again.
pub(super) const TRENDS: Fields<DiscretisationStudy> = fields! { DiscretisationStudy => GROUP;
    [|study| each(&study.quantities, text_of)] QUANTITY, QUANTITIES, Dimension::Number, "Quantities of the levels, as `adapt.of` has them.";
    {Kind::Text} UNIT, QUANTITIES, Dimension::Number, "The unit of each: of its values and its limit.";
    [|study| each(&study.quantities, |(_, trend)| trend.grows.map_or("", StressConcentration::word).to_owned())] GROWS, QUANTITIES, Dimension::Number, "Where a largest value grows with every finer mesh, as /post/largest_von_mises/concentration has it, so that it has no limit; empty where nothing tells so.";
    [|study| numbers(&study.energy_norm.orders)] "/accuracy/order/energy_norm", LEVELS, Dimension::Number, "Order of the energy-norm error observed from each level and the two before it; NaN where none is.".symbol("p");
    [|study| numbers(&study.potential_energy.orders)] "/accuracy/order/potential_energy", LEVELS, Dimension::Number, "Order of the potential energy, likewise.";
    [|study| each(&study.quantities, |(_, trend)| numbers(&trend.orders))] "/accuracy/order/quantities", &[Named("n_accuracy_quantities"), Named("n_levels")], Dimension::Number, "Order of each quantity, likewise.";
    [|study| study.potential_energy.limit.unwrap_or(f64::NAN)] "/accuracy/limit/potential_energy", &[], Dimension::Energy, "Extrapolated potential energy; NaN where no order is observed.";
    [|study| each(&study.quantities, |(_, trend)| trend.limit.unwrap_or(f64::NAN))] "/accuracy/limit/quantities", QUANTITIES, Dimension::Number, "Extrapolated quantities, each in its own `unit`, likewise.";
};

/// A quantity as `adapt.of` has it: a word, or a table with its box.
fn text_of((of, _): &(Functional, Trend)) -> String {
    let table = of.corners().and_then(|_| toml::Value::try_from(of).ok());
    table.map_or_else(|| of.word().to_owned(), |table| table.to_string())
}

/// Numbers of which some are not known; these are NaN.
fn numbers(values: &[Option<f64>]) -> Vec<f64> {
    let values = values.iter().map(|value| value.unwrap_or(f64::NAN));
    values.collect()
}

/// Writes both studies and their advice.
pub fn write(
    writer: &mut GroupWriter<'_>,
    accuracy: &Accuracy,
    scene: &Scene,
) -> Result<(), StoreError> {
    let advice = accuracy.advice(scene.element());
    write_value(writer, ADVICE, &advice.to_string())?;
    if let Some(study) = &accuracy.algebraic {
        ALGEBRAIC.write_one(writer, study)?;
        SOLVES.write_rows(writer, &study.entries)?;
    }
    let (study, units) = (&accuracy.discretisation, scene.units);
    let unit = |(of, _): &(Functional, _)| units.of(dimension_of_quantity(*of)).word().to_owned();
    write_value(writer, SCENE_LEVEL, &study.scene_level)?;
    write_list(
        writer,
        UNIT,
        &study.quantities.iter().map(unit).collect::<Vec<_>>(),
    )?;
    MESHES.write_rows(writer, &study.levels)?;
    TRENDS.write_one(writer, study)
}

/// Reads the sentence; `None` in a file without studies.
pub fn read_advice(reader: &Reader) -> Result<Option<String>, FormatError> {
    read_if_there(reader, ADVICE)
}

/// Reads both studies; orders and limits are computed again.
pub fn read(reader: &Reader) -> Result<Accuracy, FormatError> {
    Ok(Accuracy {
        algebraic: ALGEBRAIC
            .is_there(reader)
            .then(|| read_algebraic(reader))
            .transpose()?,
        discretisation: read_discretisation(reader)?,
    })
}

fn read_algebraic(reader: &Reader) -> Result<AlgebraicStudy, FormatError> {
    let mut study = AlgebraicStudy::default();
    ALGEBRAIC.read_one(reader, &mut study, true)?;
    study.entries = SOLVES.read_rows(reader, || SolverRun {
        method: RunMethod::Newton,
        operator: RunOperator::Explicit,
        epsilon: f64::NAN,
        result: Some(RunResult::default()),
    })?;
    Ok(study)
}

fn read_discretisation(reader: &Reader) -> Result<DiscretisationStudy, FormatError> {
    let words: Vec<String> = read_value(reader, QUANTITY)?;
    let quantities = words.iter().map(|word| {
        let named = Functional::NAMED.into_iter().find(|it| it.word() == word);
        let table = || word.parse::<toml::Value>().ok()?.try_into().ok();
        named.or_else(table).ok_or_else(|| {
            let reason = format!("expected a quantity of an answer, found {word:?}");
            FormatError::inconsistent(QUANTITY, reason)
        })
    });
    let quantities = quantities.collect::<Result<Vec<Functional>, _>>()?;
    let mut levels = MESHES.read_rows(reader, Level::default)?;
    let grows: Vec<String> = read_value(reader, GROWS)?;
    if let Some(finest) = levels.last_mut() {
        let grows = grows.iter().map(|word| StressConcentration::named(word));
        finest.grows = grows.collect();
    }
    let scene_level: usize = read_value(reader, SCENE_LEVEL)?;
    let has_all = |level: &Level| level.quantities.len() == quantities.len();
    let fits = scene_level < levels.len() && levels.iter().all(has_all);
    require(fits, SCENE_LEVEL, || {
        "expected one of the levels, and of each a value of every quantity".to_owned()
    })?;
    Ok(DiscretisationStudy::new(scene_level, levels, quantities))
}

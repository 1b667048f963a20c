//! `/solve/quantities` and `/history/quantities`: quantities of the answer and of increments, and the errors that the mesh makes of them.

use contact3d::{
    history::StepRecord,
    post::FunctionalEstimate,
    scene::{Functional, Scene},
};
use runfile::{Extent, Extent::Fixed, Extent::Named, GroupWriter, Kind, Reader, StoreError};
use units::{Dimension, Units};

use super::{
    FormatError, extents,
    fields::{Fields, each, fields, put_each, read_if_there, write_value},
    increments, require, solve,
};

pub(super) const NAME: &str = "/solve/quantities/name";
pub(super) const UNIT: &str = "/solve/quantities/unit";
pub(super) const VALUE: &str = "/solve/quantities/value";
pub(super) const RANGE: &str = "/solve/quantities/range";
const BOX: &str = "/solve/quantities/box";
const INDICATOR: &str = "/solve/quantities/indicator";
const HISTORY_NAME: &str = "/history/quantities/name";
const HISTORY_UNIT: &str = "/history/quantities/unit";
const HISTORY_INDICATOR: &str = "/history/quantities/indicator";

const ROWS: &[Extent] = &[Named("n_quantities")];
const COLUMNS: &[Extent] = &[Named("n_history_quantities")];
const CELLS: &[Extent] = &[Named("n_increments"), Named("n_history_quantities")];
const MISSING: &str = "absent in a load history that asks for no error, where nothing is deformed, or where the estimated error of the displacement is above a half; areas alone where the dual operator is not dense";
const NO_TARGET: &str = "absent unless the mesh is refined for a quantity";
const NO_ERROR: &str = "absent unless the scene asks for an error";

pub(super) const FIELDS: Fields<FunctionalEstimate> = fields! { FunctionalEstimate => solve::GROUP;
    [|it| it.functional.word().to_owned()] NAME, ROWS, Dimension::Number, "Quantities of the answer, as `adapt.of` names them.".optional(MISSING);
    {Kind::Text} UNIT, ROWS, Dimension::Number, "The unit of each: of its value, signed_error and range.".optional(MISSING);
    (value) VALUE, ROWS, Dimension::Number, "Their values, each in its own `unit`.".symbol("Q(u_h)").optional(MISSING);
    (signed_error) "/solve/quantities/signed_error", ROWS, Dimension::Number, "Estimated Q(u) - Q(u_h) with its sign; of areas and the largest pressure or stress, whose estimates have none, the error bar.".optional(MISSING);
    (range) RANGE, &[Named("n_quantities"), Fixed(2)], Dimension::Number, "Where the quantity of the body lies by the estimate: smallest and largest value.".optional(MISSING);
    [corners, put_corners] BOX, &[Named("n_quantities"), Fixed(2), extents::XYZ], Dimension::LENGTH, "Opposite corners of the box that a mean is over, or of the pane of the largest pressure; twice the place of the largest stress; NaN for what has no place.".optional(MISSING);
    (kinks) "/solve/quantities/kinks", ROWS, Dimension::Number, "Panes at a kink of the contact conditions, where the estimate is that of one side.".optional(MISSING);
    {Kind::F64} INDICATOR, &[Named("n_tetrahedra")], Dimension::Number, "What each tetrahedron contributes to the error of the quantity that the mesh is refined for, in its unit.".optional(NO_TARGET);
};

/// The quantities of one increment, all that some increment has; NaN for one that is zero or has no estimate there.
pub(super) const OF_INCREMENTS: Fields<Vec<FunctionalEstimate>> = fields! { Vec<FunctionalEstimate> => increments::GROUP;
    {Kind::Text} HISTORY_NAME, COLUMNS, Dimension::Number, "Quantities of the increments, as `adapt.of` names them.".optional(NO_ERROR);
    {Kind::Text} HISTORY_UNIT, COLUMNS, Dimension::Number, "The unit of each: of its value, signed_error and range.".optional(NO_ERROR);
    [|row| each(row, |it| it.value), |row, values| put_each(row, values, |it, value| it.value = value)] "/history/quantities/value", CELLS, Dimension::Number, "Their values, each in its own `unit`; NaN where one is zero or has no estimate.".symbol("Q(u_h)").optional(NO_ERROR);
    [|row| each(row, |it| it.signed_error), |row, errors| put_each(row, errors, |it, error| it.signed_error = error)] "/history/quantities/signed_error", CELLS, Dimension::Number, "Estimated Q(u) - Q(u_h) with its sign, given the increments before; of areas and the largest pressure, whose estimates have none, the error bar.".optional(NO_ERROR);
    [|row| each(row, |it| it.range), |row, ranges| put_each(row, ranges, |it, range| it.range = range)] "/history/quantities/range", &[Named("n_increments"), Named("n_history_quantities"), Fixed(2)], Dimension::Number, "Where the quantity of the body lies by the estimate: smallest and largest value.".optional(NO_ERROR);
    [|row| each(row, corners), |row, boxes| put_each(row, boxes, put_corners)] "/history/quantities/box", &[Named("n_increments"), Named("n_history_quantities"), Fixed(2), extents::XYZ], Dimension::LENGTH, "Opposite corners of the box that a mean is over; NaN for what is no mean.".optional(NO_ERROR);
    [|row| each(row, |it| it.kinks), |row, kinks| put_each(row, kinks, |it, kinks| it.kinks = kinks)] "/history/quantities/kinks", CELLS, Dimension::Number, "Panes at a kink of the contact conditions, where the estimate is that of one side.".optional(NO_ERROR);
    {Kind::F64} HISTORY_INDICATOR, &[Named("n_increments"), Named("n_tetrahedra")], Dimension::Number, "What each tetrahedron contributes to the error of the quantity that the mesh is refined for, in its unit.".optional(NO_TARGET);
};

fn corners(it: &FunctionalEstimate) -> [[f64; 3]; 2] {
    it.corners.unwrap_or([[f64::NAN; 3]; 2])
}

fn put_corners(it: &mut FunctionalEstimate, corners: [[f64; 3]; 2]) {
    let is_there = corners.as_flattened().iter().all(|x| x.is_finite());
    it.corners = is_there.then_some(corners);
}

/// A quantity that has no estimate.
fn unknown(functional: Functional) -> FunctionalEstimate {
    FunctionalEstimate {
        functional,
        value: f64::NAN,
        signed_error: f64::NAN,
        range: [f64::NAN; 2],
        corners: None,
        kinks: 0,
        indicator: Vec::new(),
    }
}

/// What a quantity is measured in.
pub fn dimension(functional: Functional) -> Dimension {
    match functional {
        Functional::NormalForce | Functional::TangentialForce => Dimension::FORCE,
        Functional::LargestPressure
        | Functional::LargestVonMises
        | Functional::MeanPressure { .. } => Dimension::STRESS,
        Functional::ContactArea | Functional::StickArea => Dimension::AREA,
        Functional::PeakDisplacement | Functional::MeanDisplacement { .. } => Dimension::LENGTH,
        Functional::StrainEnergy | Functional::Dissipation => Dimension::Energy,
    }
}

/// Writes the quantities with their units; nothing where there are none.
pub fn write(
    writer: &mut GroupWriter<'_>,
    found: &[FunctionalEstimate],
    units: Units,
) -> Result<(), StoreError> {
    if found.is_empty() {
        return Ok(());
    }
    let unit = |it: &FunctionalEstimate| units.of(dimension(it.functional)).word().to_owned();
    write_value(writer, UNIT, &found.iter().map(unit).collect::<Vec<_>>())?;
    FIELDS.write_rows(writer, found)?;
    match found.iter().find(|it| !it.indicator.is_empty()) {
        Some(wanted) => write_value(writer, INDICATOR, &wanted.indicator),
        None => Ok(()),
    }
}

/// Reads the quantities of a scene, which are numbers where it is solved; none from files without them.
pub fn read(
    reader: &Reader,
    scene: &Scene,
    is_solved: bool,
) -> Result<Vec<FunctionalEstimate>, FormatError> {
    let Some(names) = read_if_there::<Vec<String>>(reader, NAME)? else {
        return Ok(Vec::new());
    };
    let wanted = scene.adapt.and_then(|adapt| adapt.of);
    let mut found = FIELDS.read_rows(reader, || unknown(Functional::NormalForce))?;
    for (it, name) in found.iter_mut().zip(&names) {
        it.functional = named(scene, name, NAME)?;
        require(
            it.functional.has_place() == it.corners.is_some(),
            BOX,
            || format!("expected a box where {name} has a place, and none elsewhere"),
        )?;
        // Bars of what has no bound are infinite.
        let figures = [it.value, it.signed_error, it.range[0], it.range[1]];
        let is_known = !figures.iter().any(|x| x.is_nan());
        require(is_known || !is_solved, RANGE, || {
            format!("expected a value, an error and a range of {name}, found NaN")
        })?;
        if Some(it.functional) == wanted {
            it.indicator = read_if_there(reader, INDICATOR)?.unwrap_or_default();
        }
    }
    Ok(found)
}

/// Writes the quantities of all increments with their units; nothing where there are none.
pub(super) fn write_of_increments(
    writer: &mut GroupWriter<'_>,
    scene: &Scene,
    records: &[StepRecord],
) -> Result<(), StoreError> {
    let wanted = scene.adapt.and_then(|adapt| adapt.of);
    let is_there = |name: &Functional| records.iter().any(|it| it.quantity(*name).is_some());
    let others = wanted.filter(|wanted| !Functional::NAMED.contains(wanted));
    let names = Functional::NAMED.into_iter().chain(others);
    let names: Vec<Functional> = names.filter(is_there).collect();
    if names.is_empty() {
        return Ok(());
    }
    let words = names.iter().map(|name| name.word().to_owned());
    write_value(writer, HISTORY_NAME, &words.collect::<Vec<_>>())?;
    let unit = |name: &Functional| scene.units.of(dimension(*name)).word().to_owned();
    write_value(
        writer,
        HISTORY_UNIT,
        &names.iter().map(unit).collect::<Vec<_>>(),
    )?;
    if let Some(wanted) = wanted.filter(|wanted| names.contains(wanted)) {
        let indicator = |record: &StepRecord| match record.quantity(wanted) {
            Some(it) => it.indicator.clone(),
            None => vec![0.0; record.error_energy.len()],
        };
        let indicators: Vec<Vec<f64>> = records.iter().map(indicator).collect();
        write_value(writer, HISTORY_INDICATOR, &indicators)?;
    }
    let row = |record: &StepRecord| -> Vec<FunctionalEstimate> {
        let found = |name: &Functional| record.quantity(*name).cloned();
        let known = names
            .iter()
            .map(|name| found(name).unwrap_or(unknown(*name)));
        known.collect()
    };
    let rows: Vec<_> = records.iter().map(row).collect();
    OF_INCREMENTS.write_rows(writer, &rows)
}

/// Puts the quantities into the increments; none in files without them.
pub(super) fn read_of_increments(
    reader: &Reader,
    scene: &Scene,
    records: &mut [StepRecord],
) -> Result<(), FormatError> {
    let Some(words) = read_if_there::<Vec<String>>(reader, HISTORY_NAME)? else {
        return Ok(());
    };
    let names = words.iter().map(|word| named(scene, word, HISTORY_NAME));
    let names: Vec<Functional> = names.collect::<Result<_, _>>()?;
    let blank = || names.iter().copied().map(unknown).collect();
    let rows = OF_INCREMENTS.read_rows(reader, blank)?;
    for (record, row) in records.iter_mut().zip(rows) {
        record.quantities = row;
        record.quantities.retain(|it| !it.value.is_nan());
    }
    let indicators: Option<Vec<Vec<f64>>> = read_if_there(reader, HISTORY_INDICATOR)?;
    let wanted = scene.adapt.and_then(|adapt| adapt.of);
    for (record, indicator) in records.iter_mut().zip(indicators.unwrap_or_default()) {
        let mut quantities = record.quantities.iter_mut();
        if let Some(it) = quantities.find(|it| Some(it.functional) == wanted) {
            it.indicator = indicator;
        }
    }
    Ok(())
}

/// The quantity that a word in a dataset names, one with a box that of the scene.
fn named(scene: &Scene, word: &str, dataset: &'static str) -> Result<Functional, FormatError> {
    let wanted = scene.adapt.and_then(|adapt| adapt.of);
    let mut known = Functional::NAMED.into_iter().chain(wanted);
    let found = known.find(|it| it.word() == word);
    found.ok_or_else(|| {
        let reason = format!("expected a quantity of the scene, found {word:?}");
        FormatError::inconsistent(dataset, reason)
    })
}

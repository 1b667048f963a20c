//! `/history/quantities`: quantities of the increments of a history and the errors that the mesh makes of them.

use contact3d::{history::StepRecord, post::FunctionalEstimate, scene::Functional, scene::Scene};
use runfile::{Extent, Extent::Fixed, Extent::Named, GroupWriter, Kind, Reader, StoreError};
use units::{Dimension, Units};

use super::{
    FormatError, extents,
    fields::{Fields, fields, read_if_there, write_value},
    functionals::{dimension, named},
    increments::GROUP,
};

const NAME: &str = "/history/quantities/name";
const UNIT: &str = "/history/quantities/unit";

const QUANTITIES: Extent = Named("n_history_quantities");
const COLUMNS: &[Extent] = &[QUANTITIES];
const ROWS: &[Extent] = &[Named("n_increments"), QUANTITIES];
const MISSING: &str = "absent unless the scene asks for an error";

/// The quantities of one increment, one entry each; NaN for one that is zero or has no estimate there.
#[derive(Default)]
pub(super) struct QuantityRow {
    value: Vec<f64>,
    error: Vec<f64>,
    range: Vec<[f64; 2]>,
    corners: Vec<[[f64; 3]; 2]>,
    kinks: Vec<usize>,
    indicator: Vec<f64>,
}

pub(super) const FIELDS: Fields<QuantityRow> = fields! { QuantityRow => GROUP;
    {Kind::Text} NAME, COLUMNS, Dimension::Number, "Quantities of the increments, as `adapt.of` names them.".optional(MISSING);
    {Kind::Text} UNIT, COLUMNS, Dimension::Number, "The unit of each: of its value, error and range.".optional(MISSING);
    (value) "/history/quantities/value", ROWS, Dimension::Number, "Their values, each in its own `unit`; NaN where one is zero or has no estimate.".symbol("Q(u_h)").optional(MISSING);
    (error) "/history/quantities/error", ROWS, Dimension::Number, "Estimated Q(u) - Q(u_h) with its sign, given the increments before; of areas the larger distance to an end of the range.".optional(MISSING);
    (range) "/history/quantities/range", &[Named("n_increments"), QUANTITIES, Fixed(2)], Dimension::Number, "Where the quantity of the body lies by the estimate: smallest and largest value.".optional(MISSING);
    (corners) "/history/quantities/box", &[Named("n_increments"), QUANTITIES, Fixed(2), extents::XYZ], Dimension::LENGTH, "Opposite corners of the box that a mean is over; NaN for what is no mean.".optional(MISSING);
    (kinks) "/history/quantities/kinks", ROWS, Dimension::Number, "Panes at a kink of the contact conditions, where the estimate is that of one side.".optional(MISSING);
    (indicator) "/history/quantities/indicator", &[Named("n_increments"), Named("n_tetrahedra")], Dimension::Number, "What each tetrahedron contributes to the error of the quantity that the mesh is refined for, in its unit.".optional("absent unless the mesh is refined for a quantity");
};

impl QuantityRow {
    fn new(record: &StepRecord, names: &[Functional], wanted: Option<Functional>) -> Self {
        let mut row = Self::default();
        for name in names {
            let found = record.quantity(*name);
            let corners = found.and_then(|it| it.corners);
            row.value.push(found.map_or(f64::NAN, |it| it.value));
            row.error.push(found.map_or(f64::NAN, |it| it.error));
            row.range.push(found.map_or([f64::NAN; 2], |it| it.range));
            row.corners.push(corners.unwrap_or([[f64::NAN; 3]; 2]));
            row.kinks.push(found.map_or(0, |it| it.kinks));
        }
        if let Some(wanted) = wanted.filter(|wanted| names.contains(wanted)) {
            let shares = record.quantity(wanted).map(|it| it.indicator.clone());
            row.indicator = shares.unwrap_or_else(|| vec![0.0; record.von_mises.len()]);
        }
        row
    }

    /// The quantities that the increment has.
    fn quantities(
        self,
        names: &[Functional],
        wanted: Option<Functional>,
    ) -> Vec<FunctionalEstimate> {
        let has_value = |k: &usize| !self.value[*k].is_nan();
        let estimate = |k: usize| FunctionalEstimate {
            functional: names[k],
            value: self.value[k],
            error: self.error[k],
            range: self.range[k],
            corners: Some(self.corners[k]).filter(|corners| !corners[0][0].is_nan()),
            kinks: self.kinks[k],
            indicator: if Some(names[k]) == wanted {
                self.indicator.clone()
            } else {
                Vec::new()
            },
        };
        (0..names.len()).filter(has_value).map(estimate).collect()
    }
}

/// Writes the quantities of all increments with their units; nothing where there are none.
pub(super) fn write(
    writer: &mut GroupWriter<'_>,
    scene: &Scene,
    records: &[StepRecord],
    units: Units,
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
    write_value(writer, NAME, &words.collect::<Vec<_>>())?;
    let each = names
        .iter()
        .map(|name| units.of(dimension(*name)).word().to_owned());
    write_value(writer, UNIT, &each.collect::<Vec<_>>())?;
    let rows = records
        .iter()
        .map(|it| QuantityRow::new(it, &names, wanted));
    FIELDS.write_rows(writer, &rows.collect::<Vec<_>>())
}

/// Puts the quantities into the increments; none in files without them.
pub(super) fn read(
    reader: &Reader,
    scene: &Scene,
    records: &mut [StepRecord],
) -> Result<(), FormatError> {
    let Some(words) = read_if_there::<Vec<String>>(reader, NAME)? else {
        return Ok(());
    };
    let names: Vec<Functional> = words
        .iter()
        .map(|word| named(scene, word, NAME))
        .collect::<Result<_, _>>()?;
    let wanted = scene.adapt.and_then(|adapt| adapt.of);
    let rows = FIELDS.read_rows(reader, QuantityRow::default)?;
    for (record, row) in records.iter_mut().zip(rows) {
        record.quantities = row.quantities(&names, wanted);
    }
    Ok(())
}

//! `/solve/quantities`: quantities of the answer and the errors that the mesh makes of them.

use contact3d::{
    post::FunctionalEstimate,
    scene::{Functional, Scene},
};
use runfile::{Extent, Extent::Fixed, Extent::Named, GroupWriter, Kind, Reader, StoreError};
use units::{Dimension, Units};

use super::{
    FormatError, extents,
    fields::{Fields, fields, read_if_there, write_value},
    solve::GROUP,
};

const NAME: &str = "/solve/quantities/name";
const UNIT: &str = "/solve/quantities/unit";
const BOX: &str = "/solve/quantities/box";
const INDICATOR: &str = "/solve/quantities/indicator";

const ROWS: &[Extent] = &[Named("n_quantities")];
const MISSING: &str = "absent in a load history that asks for no error, where nothing is deformed, or where the estimated error of the displacement is above a half; areas alone where the dual operator is not dense";

pub(super) const FIELDS: Fields<FunctionalEstimate> = fields! { FunctionalEstimate => GROUP;
    [|it| it.functional.word().to_owned()] NAME, ROWS, Dimension::Number, "Quantities of the answer, as `adapt.of` names them.".optional(MISSING);
    {Kind::Text} UNIT, ROWS, Dimension::Number, "The unit of each: of its value, error and range.".optional(MISSING);
    (value) "/solve/quantities/value", ROWS, Dimension::Number, "Their values, each in its own `unit`.".symbol("Q(u_h)").optional(MISSING);
    (error) "/solve/quantities/error", ROWS, Dimension::Number, "Estimated Q(u) - Q(u_h) with its sign; of areas the larger distance to an end of the range.".optional(MISSING);
    (range) "/solve/quantities/range", &[Named("n_quantities"), Fixed(2)], Dimension::Number, "Where the quantity of the body lies by the estimate: smallest and largest value.".optional(MISSING);
    [|it| it.corners.unwrap_or([[f64::NAN; 3]; 2]), |it, corners: [[f64; 3]; 2]| it.corners = Some(corners).filter(|corners| corners.as_flattened().iter().all(|x| x.is_finite()))] BOX, &[Named("n_quantities"), Fixed(2), extents::XYZ], Dimension::LENGTH, "Opposite corners of the box that a mean is over, or of the pane of the largest pressure; NaN for what has no place.".optional(MISSING);
    (kinks) "/solve/quantities/kinks", ROWS, Dimension::Number, "Panes at a kink of the contact conditions, where the estimate is that of one side.".optional(MISSING);
    {Kind::F64} INDICATOR, &[Named("n_tetrahedra")], Dimension::Number, "What each tetrahedron contributes to the error of the quantity that the mesh is refined for, in its unit.".optional("absent unless the mesh is refined for a quantity");
};

/// What a quantity is measured in.
pub fn dimension(functional: Functional) -> Dimension {
    match functional {
        Functional::NormalForce | Functional::TangentialForce => Dimension::FORCE,
        Functional::LargestPressure | Functional::MeanPressure { .. } => Dimension::STRESS,
        Functional::ContactArea | Functional::StickArea => Dimension::AREA,
        Functional::LargestDisplacement | Functional::MeanDisplacement { .. } => Dimension::LENGTH,
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

/// Reads the quantities of a scene; none from files without them.
pub fn read(reader: &Reader, scene: &Scene) -> Result<Vec<FunctionalEstimate>, FormatError> {
    let Some(names) = read_if_there::<Vec<String>>(reader, NAME)? else {
        return Ok(Vec::new());
    };
    let wanted = scene.adapt.and_then(|adapt| adapt.of);
    let mut found = FIELDS.read_rows(reader, || FunctionalEstimate {
        functional: Functional::NormalForce,
        value: 0.0,
        error: 0.0,
        range: [0.0; 2],
        corners: None,
        kinks: 0,
        indicator: Vec::new(),
    })?;
    for (it, name) in found.iter_mut().zip(&names) {
        it.functional = named(scene, name, NAME)?;
        if it.functional.has_place() != it.corners.is_some() {
            return Err(FormatError::Inconsistent {
                dataset: BOX,
                reason: format!("expected a box where {name} has a place, and none elsewhere"),
            });
        }
        if Some(it.functional) == wanted {
            it.indicator = read_if_there(reader, INDICATOR)?.unwrap_or_default();
        }
    }
    Ok(found)
}

/// The quantity of a scene that a word in a dataset names.
pub(super) fn named(
    scene: &Scene,
    word: &str,
    dataset: &'static str,
) -> Result<Functional, FormatError> {
    let wanted = scene.adapt.and_then(|adapt| adapt.of);
    let mut known = Functional::NAMED.into_iter().chain(wanted);
    let found = known.find(|it| it.word() == word);
    found.ok_or_else(|| FormatError::Inconsistent {
        dataset,
        reason: format!("expected a quantity of the scene, found {word:?}"),
    })
}

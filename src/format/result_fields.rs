//! The fields of results, each described once: what has its values, how they follow from a state, its dimension and its words. `/VTKHDF`
//! and the 3D view go by this list, and Python reads what `/VTKHDF` has.

use contact3d::{
    history::StepRecord,
    post::{ContactReport, PaneState, Zone},
};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named},
    Group, Kind,
};
use units::Dimension;

use super::Stage;

/// The same results as ParaView reads them.
pub const VTKHDF: Group = Group::new("VTKHDF", Stage::Post.command());

pub(super) const STEPS: &[Extent] = &[Named("n_series_steps")];
pub(super) const ONLY_IN_SERIES: &str = "only in a series";

/// What has the values of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldPlace {
    /// Nodes of the mesh.
    Nodes,
    /// Nodes of each material.
    MaterialNodes,
    /// Tetrahedra.
    Tetrahedra,
    /// Panes of the contact faces, or nodes with multipliers.
    Panes,
}

/// What a value is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldShape {
    /// A number.
    Scalar,
    /// A vector along x, y, z.
    Vector,
    /// A vector along t₁ and t₂ of its pane.
    Tangential,
    /// A symmetric tensor: xx, yy, zz, xy, yz, xz, the order of VTK.
    Tensor,
    /// 0 open, 1 stick, 2 slip.
    Zone,
}

/// What the 3D view makes of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldView {
    /// Colours of the body, and numbers beside it.
    Colours,
    /// Numbers beside it.
    Numbers,
    /// Nothing.
    Hidden,
}

/// A field of results.
pub struct ResultField {
    /// Its name in files, in the address of the 3D view and in Python.
    pub name: &'static str,
    /// Its name for people.
    pub words: &'static str,
    /// What its values are measured in.
    pub dimension: Dimension,
    /// What has values.
    pub place: FieldPlace,
    /// What these are.
    pub shape: FieldShape,
    /// What the 3D view makes of them.
    pub view: FieldView,
    /// Value after value of a state; `None` where the scene has no such field.
    pub values: fn(&ResultState<'_>) -> Option<Vec<f64>>,
    /// Its datasets in `/VTKHDF`, each with the one that says where the values of steps begin.
    rows: &'static [DatasetSpec],
}

impl FieldShape {
    /// Numbers of a value.
    pub const fn components(self) -> usize {
        match self {
            Self::Scalar | Self::Zone => 1,
            Self::Tangential => 2,
            Self::Vector => 3,
            Self::Tensor => 6,
        }
    }
}

/// The datasets of a field: of panes on contact triangles, of nodal multipliers on points.
macro_rules! rows {
    (Nodes, $($field:tt)+) => { &rows!(@ "PointData" "n_point_values" "." [] $($field)+) };
    (MaterialNodes, $($field:tt)+) => { rows!(Nodes, $($field)+) };
    (Tetrahedra, $($field:tt)+) => {
        &rows!(@ "CellData" "n_cell_values" "; NaN on contact triangles." [] $($field)+)
    };
    (Panes, $name:literal, $shape:expr, $dimension:expr, $meaning:literal, $why:expr) => {
        &rows!(
            @ "CellData" "n_cell_values" "; NaN on tetrahedra."
            [rows!(@ "PointData" "n_point_values" "; NaN where no multiplier is." []
                $name, $shape, $dimension, $meaning, Some(WITH_NODAL_MULTIPLIERS))]
            $name, $shape, $dimension, $meaning, Some(WITH_PANES)
        )
    };
    (@ $place:literal $count:literal $ending:literal [] $name:literal, $shape:expr, $dimension:expr, $meaning:literal, $why:expr) => {
        [
            field_row(
                concat!("/VTKHDF/", $place, "/", $name),
                match $shape.components() {
                    1 => &[Named($count)],
                    6 => &[Named($count), Fixed(6)],
                    _ => &[Named($count), Fixed(3)],
                },
                $dimension,
                concat!($meaning, $ending),
                $why,
            ),
            offsets_row(concat!("/VTKHDF/Steps/", $place, "Offsets/", $name)),
        ]
    };
    (@ $place:literal $count:literal $ending:literal [$more:expr] $($field:tt)+) => {{
        let [first, second] = rows!(@ $place $count $ending [] $($field)+);
        let [third, fourth] = $more;
        // Most values are NaN; those of other fields hardly shrink.
        [first.compressed(), second, third.compressed(), fourth]
    }};
}

/// Declares fields, one a line: name, place, shape, use in the 3D view, dimension, words, meaning, why it may be missing, values.
macro_rules! result_fields {
    ($($name:literal, $place:ident, $shape:ident, $view:ident, $dimension:expr, $words:literal, $meaning:literal, $why:expr, $values:expr;)+) => {
        &[$(ResultField {
            name: $name,
            words: $words,
            dimension: $dimension,
            place: FieldPlace::$place,
            shape: FieldShape::$shape,
            view: FieldView::$view,
            values: $values,
            rows: rows!($place, $name, FieldShape::$shape, $dimension, $meaning, $why),
        }),+]
    };
}

const WITH_PANES: &str = "only with panes, where the scene has the effect";
const WITH_NODAL_MULTIPLIERS: &str = "only with nodal multipliers, where the scene has the effect";
const WITH_STRESS: Option<&str> = Some("absent with a load history");
const AT_REST: Option<&str> = Some("absent for a body at rest, and with a load history");

/// All fields.
#[rustfmt::skip]
pub const RESULT_FIELDS: &[ResultField] = result_fields! {
    "displacement", Nodes, Vector, Colours, Dimension::LENGTH, "displacement", "Displacement; warp by this vector", None, |state| Some(state.displacement.as_flattened().to_vec());
    "von_mises", MaterialNodes, Scalar, Colours, Dimension::STRESS, "von Mises stress", "Von Mises stress", None, |state| Some(state.von_mises.to_vec());
    "stress", MaterialNodes, Tensor, Hidden, Dimension::STRESS, "stress", "Stress xx, yy, zz, xy, yz, xz, the order of VTK", WITH_STRESS, |state| Some(state.stress?.iter().flat_map(|s| [0, 1, 2, 5, 3, 4].map(|c| s[c])).collect());
    "error_indicator", Tetrahedra, Scalar, Hidden, Dimension::Number, "share in the error", "Share in the estimated discretisation error", AT_REST, |state| state.error.clone();
    "contact_pressure", Panes, Scalar, Colours, Dimension::STRESS, "contact pressure", "Contact pressure", None, |state| of_panes(state, |pane| Some([pane.pressure]));
    "friction_stress", Panes, Tangential, Colours, Dimension::STRESS, "friction stress", "Tangential contact stress on the body", None, |state| of_panes(state, |pane| pane.friction_stress);
    "contact_zone", Panes, Zone, Colours, Dimension::Number, "zone", "0 open, 1 stick, 2 slip", None, |state| of_panes(state, |pane| Some([f64::from(pane.zone as u8)]));
    "contact_gap", Panes, Scalar, Numbers, Dimension::LENGTH, "gap", "Gap d - u_nu", None, |state| of_panes(state, |pane| Some([pane.gap]));
    "friction_1", Panes, Scalar, Numbers, Dimension::Number, "coefficient of friction F1", "Coefficient F_1", None, |state| of_panes(state, |pane| Some([pane.coefficients?[0]]));
    "friction_2", Panes, Scalar, Numbers, Dimension::Number, "F2", "Coefficient F_2", None, |state| of_panes(state, |pane| Some([pane.coefficients?[1]]));
};

/// The rows of all fields.
pub(super) const TABLE: &[DatasetSpec] = &joined::<{ count(RESULT_FIELDS) }>(RESULT_FIELDS);

const fn count(fields: &[ResultField]) -> usize {
    let (mut total, mut k) = (0, 0);
    while k < fields.len() {
        total += fields[k].rows.len();
        k += 1;
    }
    total
}

const fn joined<const N: usize>(fields: &[ResultField]) -> [DatasetSpec; N] {
    let mut all = [fields[0].rows[0]; N];
    let (mut total, mut k) = (0, 0);
    while k < fields.len() {
        let mut row = 0;
        while row < fields[k].rows.len() {
            all[total] = fields[k].rows[row];
            (total, row) = (total + 1, row + 1);
        }
        k += 1;
    }
    all
}

const fn field_row(
    path: &'static str,
    extents: &'static [Extent],
    dimension: Dimension,
    meaning: &'static str,
    missing: Option<&'static str>,
) -> DatasetSpec {
    let row = VTKHDF.row(path, Kind::F64, extents, dimension, meaning);
    match missing {
        None => row,
        Some(why) => row.optional(why),
    }
}

/// Where the values of each step begin in the dataset of a field.
pub(super) const fn offsets_row(path: &'static str) -> DatasetSpec {
    let meaning = "Where the values of each step begin.";
    let row = VTKHDF.row(path, Kind::I64, STEPS, Dimension::Number, meaning);
    row.optional(ONLY_IN_SERIES)
}

/// Results at one time.
#[derive(Debug)]
pub struct ResultState<'a> {
    displacement: &'a [[f64; 3]],
    von_mises: &'a [f64],
    /// Voigt stress; `None` where it is not kept.
    stress: Option<&'a [[f64; 6]]>,
    /// Share of each tetrahedron in the estimated error; `None` where it is not kept.
    error: Option<Vec<f64>>,
    panes: Vec<PaneValues>,
}

#[derive(Debug)]
struct PaneValues {
    pressure: f64,
    /// Mean gap d − u_ν.
    gap: f64,
    zone: Zone,
    /// σ_t; `None` without friction.
    friction_stress: Option<[f64; 2]>,
    /// (F₁, F₂); `None` without Coulomb's law.
    coefficients: Option<[f64; 2]>,
}

/// The values of all panes, NaN on those without; `None` where no pane has one.
fn of_panes<const K: usize>(
    state: &ResultState<'_>,
    value: impl Fn(&PaneValues) -> Option<[f64; K]>,
) -> Option<Vec<f64>> {
    let values: Vec<Option<[f64; K]>> = state.panes.iter().map(value).collect();
    let all = values
        .iter()
        .flat_map(|value| value.unwrap_or([f64::NAN; K]));
    values.iter().any(Option::is_some).then(|| all.collect())
}

impl<'a> From<&'a ContactReport> for ResultState<'a> {
    fn from(report: &'a ContactReport) -> Self {
        let error = &report.discretisation_error;
        let share = |indicator: &f64| match error.displacement {
            0.0 => 0.0,
            displacement => indicator / displacement,
        };
        let pane = |pane: &PaneState| PaneValues {
            pressure: 0.0 - pane.normal_stress,
            gap: pane.gap,
            zone: pane.zone,
            friction_stress: pane.friction.map(|friction| friction.stress),
            coefficients: pane
                .friction
                .and_then(|friction| friction.coulomb)
                .map(|coulomb| coulomb.coefficients),
        };
        Self {
            displacement: &report.displacement,
            von_mises: &report.von_mises,
            stress: Some(&report.nodal_stress),
            error: Some(error.indicator.iter().map(share).collect()),
            panes: report.panes.iter().map(pane).collect(),
        }
    }
}

impl<'a> ResultState<'a> {
    /// That of an increment, with its share in the error over the largest norm of the history in √J.
    pub fn of_increment(record: &'a StepRecord, norm: f64) -> Self {
        let squares = record.error_energy.iter();
        let shares = squares.map(|square| match *square {
            0.0 => 0.0,
            square => square.sqrt() / norm,
        });
        let (normal, tangential) = record.multiplier.split_at(record.panes.len());
        let pairs: &[[f64; 2]] = tangential.as_chunks().0;
        let panes = record.panes.iter().enumerate();
        let panes = panes.map(|(k, pane)| PaneValues {
            pressure: normal[k],
            gap: pane.gap,
            zone: pane.zone,
            friction_stress: pairs.get(k).map(|pair| pair.map(|stress| 0.0 - stress)),
            coefficients: Some(pane.coefficients).filter(|f| !f[0].is_nan()),
        });
        Self {
            displacement: &record.displacement,
            von_mises: &record.von_mises,
            stress: None,
            error: (!record.error_energy.is_empty()).then(|| shares.collect()),
            panes: panes.collect(),
        }
    }
}

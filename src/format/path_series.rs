//! The points of one path of `branches`, as a series that ParaView plays.

use contact3d::{
    branches::{Path, PathPoint},
    mesh::Mesh,
};
use runfile::{DatasetSpec, GroupWriter, Kind, StoreError};
use units::Dimension;

use super::{
    vtkhdf::GROUP,
    vtkhdf_series::{STEPS, Series},
};

const ONLY: &str = "only in the series of a path";

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row("/VTKHDF/FieldData/parameter", Kind::F64, STEPS, Dimension::Number, "The parameter of each step, in the unit of its key.").optional(ONLY),
    GROUP.row("/VTKHDF/FieldData/determinant_sign", Kind::F64, STEPS, Dimension::Number, "Sign of the determinant of Newton's matrix; 0 at folds.").optional(ONLY),
    GROUP.row("/VTKHDF/FieldData/spectral_radius", Kind::F64, STEPS, Dimension::Number, "Spectral radius of the derivative of the mapping Psi; NaN where it has none.").optional(ONLY),
    GROUP.row("/VTKHDF/Steps/FieldDataOffsets/parameter", Kind::I64, STEPS, Dimension::Number, "Which value belongs to each step.").optional(ONLY),
    GROUP.row("/VTKHDF/Steps/FieldDataOffsets/determinant_sign", Kind::I64, STEPS, Dimension::Number, "Which value belongs to each step.").optional(ONLY),
    GROUP.row("/VTKHDF/Steps/FieldDataOffsets/spectral_radius", Kind::I64, STEPS, Dimension::Number, "Which value belongs to each step.").optional(ONLY),
];

/// Begins the series of a path with what is known of its points.
///
/// Its time is the parameter where that grows all along the path; elsewhere it is the number of the point, since players need
/// times that grow.
///
/// # Errors
/// HDF5 failures.
pub fn begin<'w, 't>(
    writer: &'w mut GroupWriter<'t>,
    mesh: &'w Mesh,
    path: &Path,
) -> Result<Series<'w, 't>, StoreError> {
    type Measure = fn(&PathPoint) -> f64;
    let measures: [(&str, Measure); 3] = [
        ("parameter", |point| point.parameter),
        ("determinant_sign", |point| f64::from(point.determinant)),
        ("spectral_radius", |point| point.spectral_radius),
    ];
    let n = path.points.len();
    for (name, measure) in measures {
        let values: Vec<f64> = path.points.iter().map(measure).collect();
        writer.write(&format!("/VTKHDF/FieldData/{name}"), &values, &[n])?;
        let offsets: Vec<usize> = (0..n).collect();
        let path = format!("/VTKHDF/Steps/FieldDataOffsets/{name}");
        writer.write_indices(&path, &offsets, &[n])?;
    }
    let parameters: Vec<f64> = path.points.iter().map(|point| point.parameter).collect();
    let times = match parameters.is_sorted_by(|a, b| a < b) {
        true => parameters,
        false => (1..=n).map(|number| number as f64).collect(),
    };
    Series::begin(writer, mesh, &times)
}

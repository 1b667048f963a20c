//! Cases of a sweep that share a mesh, as a series that ParaView plays.

use runfile::{DatasetSpec, Extent, Extent::Named, GroupWriter, Kind, Reader, StoreError};
use units::Dimension;

use super::{
    vtkhdf::GROUP,
    vtkhdf_once::copy_normals,
    vtkhdf_series::{STEPS, Series},
    vtkhdf_stored::{copy_grid, last_fields},
};

const ONLY: &str = "only in the series of a sweep";
const CASE: &str = "/VTKHDF/FieldData/case";
const SETTING: &str = "/VTKHDF/FieldData/setting";
const SETTINGS: &[Extent] = &[Named("n_series_steps"), Named("n_keys")];

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(CASE, Kind::F64, STEPS, Dimension::Number, "Row of each step in /cases of summary.h5, from 0.").optional(ONLY),
    GROUP.row(SETTING, Kind::F64, SETTINGS, Dimension::Number, "Values of the keys that the settings of the group list; NaN where a value is no number.").optional(ONLY),
    GROUP.row("/VTKHDF/Steps/FieldDataOffsets/case", Kind::I64, STEPS, Dimension::Number, "Which value belongs to each step.").optional(ONLY),
    GROUP.row("/VTKHDF/Steps/FieldDataOffsets/setting", Kind::I64, STEPS, Dimension::Number, "Which row belongs to each step.").optional(ONLY),
];

/// A case of such a series.
#[derive(Debug, Clone)]
pub struct SeriesCase {
    /// Its row in the table of the sweep.
    pub row: usize,
    /// The time at which players show it.
    pub time: f64,
    /// The values of the keys; NaN for what is no number.
    pub settings: Vec<f64>,
}

/// Begins the series of some cases on the grid of one of them.
///
/// # Errors
/// HDF5 failures, a run file without what ParaView reads.
pub fn begin<'w, 't>(
    writer: &'w mut GroupWriter<'t>,
    grid: &Reader,
    cases: &[SeriesCase],
) -> Result<Series<'w, 't>, StoreError> {
    copy_grid(writer, grid)?;
    let n = cases.len();
    copy_normals(writer, grid, n)?;
    let rows: Vec<f64> = cases.iter().map(|case| case.row as f64).collect();
    writer.write(CASE, &rows, &[n])?;
    let settings: Vec<f64> = cases
        .iter()
        .flat_map(|case| case.settings.clone())
        .collect();
    writer.write(SETTING, &settings, &[n, settings.len() / n.max(1)])?;
    let offsets: Vec<usize> = (0..n).collect();
    for name in ["case", "setting"] {
        let path = format!("/VTKHDF/Steps/FieldDataOffsets/{name}");
        writer.write_indices(&path, &offsets, &[n])?;
    }
    let times: Vec<f64> = cases.iter().map(|case| case.time).collect();
    Series::on_grid(writer, &times)
}

/// Writes the fields of the next case.
///
/// # Errors
/// HDF5 failures, a run file with other fields.
pub fn step(series: &mut Series<'_, '_>, case: &Reader) -> Result<(), StoreError> {
    series.append(&last_fields(case)?)
}

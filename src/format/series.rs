//! `/VTKHDF/Steps`: results on one mesh, one after the other, as a series that ParaView plays (VTKHDF 2.0): the increments of a
//! history, the points of a path, the cases of a sweep.
//!
//! The grid is stored once. The values of all steps follow each other in the arrays that hold one step without a series, and
//! `Steps` says where each step begins.

use contact3d::{
    contact::ContactFrame,
    mesh::{MaterialNodes, Mesh},
};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named},
    GroupWriter, Kind, Layout, Reader, StoreError,
};
use studies::branches::{Path, PathPoint};
use units::Dimension;

use super::{
    extents,
    fields::{write_list, write_value},
    result_fields::{self, ONLY_IN_SERIES, ResultState, STEPS, VTKHDF},
    stored::Stored,
    vtkhdf::{
        self, CONNECTIVITY, GridArray, N_CELLS, N_CONNECTIVITY, N_POINTS, NORMAL, OFFSETS, POINTS,
        TYPE, TYPES, VERSION, grid_arrays, write_grid, write_normals, write_once,
    },
};

const VALUES: &str = "/VTKHDF/Steps/Values";
const PARTS: &str = "/VTKHDF/Steps/NumberOfParts";
const PART_OFFSETS: &str = "/VTKHDF/Steps/PartOffsets";
const POINT_OFFSETS: &str = "/VTKHDF/Steps/PointOffsets";
const CELL_OFFSETS: &str = "/VTKHDF/Steps/CellOffsets";
const CONNECTIVITY_OFFSETS: &str = "/VTKHDF/Steps/ConnectivityIdOffsets";

const OF_PATH: &str = "only in the series of a path";
const OF_SWEEP: &str = "only in the series of a sweep";
const STEPS_AND_ONE: &[Extent] = &[Named("n_series_steps"), Fixed(1)];
const SETTINGS: &[Extent] = &[Named("n_series_steps"), Named("n_keys")];

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    VTKHDF.row(VALUES, Kind::F64, STEPS, Dimension::Number, "Time of each step, as players show it.").optional(ONLY_IN_SERIES),
    VTKHDF.row(PARTS, Kind::I64, STEPS, Dimension::Number, "Parts of the grid at each step: one.").optional(ONLY_IN_SERIES),
    VTKHDF.row(PART_OFFSETS, Kind::I64, STEPS, Dimension::Number, "The part of each step: the first.").optional(ONLY_IN_SERIES),
    VTKHDF.row(POINT_OFFSETS, Kind::I64, STEPS, Dimension::Number, "Where the points of each step begin: the grid stays.").optional(ONLY_IN_SERIES),
    VTKHDF.row(CELL_OFFSETS, Kind::I64, STEPS_AND_ONE, Dimension::Number, "Where the cells of each step begin: the grid stays.").optional(ONLY_IN_SERIES),
    VTKHDF.row(CONNECTIVITY_OFFSETS, Kind::I64, STEPS_AND_ONE, Dimension::Number, "Where Connectivity of each step begins: the grid stays.").optional(ONLY_IN_SERIES),
];

#[rustfmt::skip]
const OF_PATHS: &[DatasetSpec] = &[
    VTKHDF.row("/VTKHDF/FieldData/parameter", Kind::F64, STEPS, Dimension::Number, "The parameter of each step, in the unit of its key.").optional(OF_PATH),
    VTKHDF.row("/VTKHDF/FieldData/determinant_sign", Kind::F64, STEPS, Dimension::Number, "Sign of the determinant of Newton's matrix; 0 at folds.").optional(OF_PATH),
    VTKHDF.row("/VTKHDF/FieldData/spectral_radius", Kind::F64, STEPS, Dimension::Number, "Spectral radius of the derivative of the mapping Psi; NaN where it has none.").optional(OF_PATH),
    VTKHDF.row("/VTKHDF/Steps/FieldDataOffsets/parameter", Kind::I64, STEPS, Dimension::Number, "Which value belongs to each step.").optional(OF_PATH),
    VTKHDF.row("/VTKHDF/Steps/FieldDataOffsets/determinant_sign", Kind::I64, STEPS, Dimension::Number, "Which value belongs to each step.").optional(OF_PATH),
    VTKHDF.row("/VTKHDF/Steps/FieldDataOffsets/spectral_radius", Kind::I64, STEPS, Dimension::Number, "Which value belongs to each step.").optional(OF_PATH),
];

#[rustfmt::skip]
const OF_SWEEPS: &[DatasetSpec] = &[
    VTKHDF.row("/VTKHDF/FieldData/case", Kind::F64, STEPS, Dimension::Number, "Row of each step in /cases of summary.h5, from 0.").optional(OF_SWEEP),
    VTKHDF.row("/VTKHDF/FieldData/setting", Kind::F64, SETTINGS, Dimension::Number, "Values of the keys that the settings of the group list; NaN where a value is no number.").optional(OF_SWEEP),
    VTKHDF.row("/VTKHDF/Steps/FieldDataOffsets/case", Kind::I64, STEPS, Dimension::Number, "Which value belongs to each step.").optional(OF_SWEEP),
    VTKHDF.row("/VTKHDF/Steps/FieldDataOffsets/setting", Kind::I64, STEPS, Dimension::Number, "Which row belongs to each step.").optional(OF_SWEEP),
];

/// Every dataset of a file that holds what ParaView opens and nothing else: a copy of what a run file has, the points of a path,
/// the cases of a sweep.
pub const SERIES_LAYOUT: Layout = Layout {
    filetype: "contact3d-pipe series",
    linked_filetype: "contact3d-pipe series stage",
    groups: &[VTKHDF],
    tables: &[
        vtkhdf::TABLE,
        result_fields::TABLE,
        vtkhdf::ONCE,
        TABLE,
        OF_PATHS,
        OF_SWEEPS,
    ],
    extents: extents::OF_SERIES,
    ..super::LAYOUT
};

/// A series that is being written, step by step; its fields are written at the end.
pub struct GridSeries<'w, 't> {
    writer: &'w mut GroupWriter<'t>,
    n_steps: usize,
    /// The fields of all steps so far.
    arrays: Vec<GridArray>,
}

impl<'w, 't> GridSeries<'w, 't> {
    /// Writes the grid and the time of each step, in ascending order.
    pub fn begin(
        writer: &'w mut GroupWriter<'t>,
        mesh: &Mesh,
        times: &[f64],
    ) -> Result<Self, StoreError> {
        write_grid(writer, mesh, &MaterialNodes::new(mesh))?;
        write_normals(writer, mesh, Some(times.len()))?;
        Self::on_grid(writer, times)
    }

    /// Writes the time of each step, in ascending order, of a series whose grid is written.
    pub(super) fn on_grid(
        writer: &'w mut GroupWriter<'t>,
        times: &[f64],
    ) -> Result<Self, StoreError> {
        let n_steps = times.len();
        write_list(writer, VALUES, times)?;
        let number = i64::try_from(n_steps).unwrap_or(i64::MAX);
        writer.write_inner_attribute("Steps", "NSteps", number)?;
        write_value(writer, PARTS, &vec![1_usize; n_steps])?;
        for path in [PART_OFFSETS, POINT_OFFSETS] {
            write_value(writer, path, &vec![0_usize; n_steps])?;
        }
        for path in [CELL_OFFSETS, CONNECTIVITY_OFFSETS] {
            write_value(writer, path, &vec![[0_usize]; n_steps])?;
        }
        Ok(Self {
            writer,
            n_steps,
            arrays: Vec::new(),
        })
    }

    /// Adds the next step, with the frame of its contact face.
    pub fn step(&mut self, mesh: &Mesh, state: &ResultState<'_>, frame: Option<&ContactFrame>) {
        self.append(grid_arrays(mesh, &MaterialNodes::new(mesh), state, frame));
    }

    /// Adds the fields of the next step, the same ones in each.
    pub(super) fn append(&mut self, fields: Vec<GridArray>) {
        if self.arrays.is_empty() {
            self.arrays = fields;
            return;
        }
        for (array, field) in self.arrays.iter_mut().zip(fields) {
            array.values.extend(field.values);
        }
    }

    /// Ends the series.
    ///
    /// # Errors
    /// HDF5 failures; a step more or less than there are times.
    pub fn finish(self) -> Result<(), StoreError> {
        for field in &self.arrays {
            let rows = field.rows();
            self.writer
                .write(&field.path, &field.values, &field.shape())?;
            let kind_and_name = field.path.trim_start_matches("/VTKHDF/").split_once('/');
            if let Some((kind, name)) = kind_and_name {
                let path = format!("/VTKHDF/Steps/{kind}Offsets/{name}");
                let steps = 0..self.n_steps;
                let offsets = steps.map(|step| step * (rows / self.n_steps));
                write_value(self.writer, &path, &offsets.collect::<Vec<usize>>())?;
            }
        }
        Ok(())
    }
}

/// Writes the values of all steps that are no fields, and that each step has its own.
fn write_of_steps<V: Stored>(
    writer: &mut GroupWriter<'_>,
    name: &str,
    values: &[V],
) -> Result<(), StoreError> {
    write_list(writer, &format!("/VTKHDF/FieldData/{name}"), values)?;
    let offsets: Vec<usize> = (0..values.len()).collect();
    let path = format!("/VTKHDF/Steps/FieldDataOffsets/{name}");
    write_value(writer, &path, &offsets)
}

/// Begins the series of a path with what is known of its points.
///
/// Its time is the parameter where that grows all along the path; elsewhere it is the number of the point, since players need
/// times that grow.
pub fn begin_path_series<'w, 't>(
    writer: &'w mut GroupWriter<'t>,
    mesh: &'w Mesh,
    path: &Path,
) -> Result<GridSeries<'w, 't>, StoreError> {
    let of_points = |measure: fn(&PathPoint) -> f64| path.points.iter().map(measure).collect();
    let parameters: Vec<f64> = of_points(|point| point.parameter);
    let signs: Vec<f64> = of_points(|point| f64::from(point.determinant));
    let radii: Vec<f64> = of_points(|point| point.spectral_radius);
    write_of_steps(writer, "parameter", &parameters)?;
    write_of_steps(writer, "determinant_sign", &signs)?;
    write_of_steps(writer, "spectral_radius", &radii)?;
    let times = if parameters.is_sorted_by(|a, b| a < b) {
        parameters
    } else {
        (1..=parameters.len()).map(|number| number as f64).collect()
    };
    GridSeries::begin(writer, mesh, &times)
}

/// A case of a series of cases that share a mesh.
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
pub fn begin_sweep_series<'w, 't>(
    writer: &'w mut GroupWriter<'t>,
    grid: &Reader,
    cases: &[SeriesCase],
) -> Result<GridSeries<'w, 't>, StoreError> {
    copy_grid(writer, grid)?;
    if grid.has(NORMAL) {
        let normals: Vec<f64> = grid.read_vec(NORMAL)?;
        write_once(writer, normals.as_chunks().0, Some(cases.len()))?;
    }
    let rows: Vec<f64> = cases.iter().map(|case| case.row as f64).collect();
    write_of_steps(writer, "case", &rows)?;
    let settings: Vec<Vec<f64>> = cases.iter().map(|case| case.settings.clone()).collect();
    write_of_steps(writer, "setting", &settings)?;
    let times: Vec<f64> = cases.iter().map(|case| case.time).collect();
    GridSeries::on_grid(writer, &times)
}

/// Writes the fields of the next case.
pub fn step_sweep_series(series: &mut GridSeries<'_, '_>, case: &Reader) -> Result<(), StoreError> {
    series.append(last_fields(case)?);
    Ok(())
}

/// The fields that a file has on its points and cells, those that each step of a series has of its own.
pub fn field_paths(reader: &Reader) -> Vec<&'static str> {
    let on_grid = |path: &&str| {
        path.starts_with("/VTKHDF/PointData/") || path.starts_with("/VTKHDF/CellData/")
    };
    let rows = result_fields::TABLE.iter().chain(vtkhdf::TABLE);
    let paths = rows.map(|row| row.path);
    paths
        .filter(on_grid)
        .filter(|path| reader.has(path))
        .collect()
}

/// The values of these fields, at the last time where the file is a series itself.
fn last_fields(reader: &Reader) -> Result<Vec<GridArray>, StoreError> {
    let steps = if reader.has(VALUES) {
        reader.read_vec::<f64>(VALUES)?.len()
    } else {
        1
    };
    let field = |path: &str| {
        let values = reader.read::<f64>(path)?;
        let components = values.shape().get(1).copied().unwrap_or(1);
        let mut values = values.into_raw_vec_and_offset().0;
        let last = values.len() / steps.max(1);
        values.drain(..values.len() - last);
        Ok(GridArray {
            path: path.to_owned(),
            components,
            values,
        })
    };
    field_paths(reader).into_iter().map(field).collect()
}

/// Writes the grid of another file.
fn copy_grid(writer: &mut GroupWriter<'_>, reader: &Reader) -> Result<(), StoreError> {
    writer.write_ascii_attribute("Type", TYPE)?;
    writer.write_number_attribute("Version", &VERSION)?;
    for path in [N_POINTS, N_CELLS, N_CONNECTIVITY, CONNECTIVITY, OFFSETS] {
        write_value(writer, path, &reader.read_vec::<i64>(path)?)?;
    }
    let points = reader.read_vec::<f64>(POINTS)?;
    writer.write(POINTS, &points, &[points.len() / 3, 3])?;
    write_value(writer, TYPES, &reader.read_vec::<u8>(TYPES)?)
}

//! `/VTKHDF/Steps`: results on one mesh, one after the other, as a series that ParaView plays (VTKHDF 2.0).
//!
//! The grid is stored once. The values of all steps follow each other in the arrays that hold one step without a series, and
//! `Steps` says where each step begins.

use contact3d::{contact::ContactFrame, mesh::Mesh};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named},
    GroupWriter, Kind, Piecewise, StoreError,
};
use units::Dimension;

use super::{
    vtkhdf::{Field, GROUP, GridValues, fields, write_grid},
    vtkhdf_once,
};

pub(super) const VALUES: &str = "/VTKHDF/Steps/Values";
const PARTS: &str = "/VTKHDF/Steps/NumberOfParts";
const PART_OFFSETS: &str = "/VTKHDF/Steps/PartOffsets";
const POINT_OFFSETS: &str = "/VTKHDF/Steps/PointOffsets";
const CELL_OFFSETS: &str = "/VTKHDF/Steps/CellOffsets";
const CONNECTIVITY_OFFSETS: &str = "/VTKHDF/Steps/ConnectivityIdOffsets";

const ONLY: &str = "only in a series";
pub(super) const STEPS: &[Extent] = &[Named("n_series_steps")];
const STEPS_AND_ONE: &[Extent] = &[Named("n_series_steps"), Fixed(1)];

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(VALUES, Kind::F64, STEPS, Dimension::Number, "Time of each step, as players show it.").optional(ONLY),
    GROUP.row(PARTS, Kind::I64, STEPS, Dimension::Number, "Parts of the grid at each step: one.").optional(ONLY),
    GROUP.row(PART_OFFSETS, Kind::I64, STEPS, Dimension::Number, "The part of each step: the first.").optional(ONLY),
    GROUP.row(POINT_OFFSETS, Kind::I64, STEPS, Dimension::Number, "Where the points of each step begin: the grid stays.").optional(ONLY),
    GROUP.row(CELL_OFFSETS, Kind::I64, STEPS_AND_ONE, Dimension::Number, "Where the cells of each step begin: the grid stays.").optional(ONLY),
    GROUP.row(CONNECTIVITY_OFFSETS, Kind::I64, STEPS_AND_ONE, Dimension::Number, "Where Connectivity of each step begins: the grid stays.").optional(ONLY),
    offsets_row("/VTKHDF/Steps/PointDataOffsets/displacement"),
    offsets_row("/VTKHDF/Steps/CellDataOffsets/von_mises"),
    offsets_row("/VTKHDF/Steps/CellDataOffsets/error_indicator"),
    offsets_row("/VTKHDF/Steps/CellDataOffsets/contact_face"),
    offsets_row("/VTKHDF/Steps/CellDataOffsets/contact_normal_stress"),
    offsets_row("/VTKHDF/Steps/PointDataOffsets/contact_normal_stress"),
    offsets_row("/VTKHDF/Steps/CellDataOffsets/contact_gap"),
    offsets_row("/VTKHDF/Steps/PointDataOffsets/contact_gap"),
    offsets_row("/VTKHDF/Steps/CellDataOffsets/contact_zone"),
    offsets_row("/VTKHDF/Steps/PointDataOffsets/contact_zone"),
    offsets_row("/VTKHDF/Steps/CellDataOffsets/contact_tangential_stress"),
    offsets_row("/VTKHDF/Steps/PointDataOffsets/contact_tangential_stress"),
    offsets_row("/VTKHDF/Steps/CellDataOffsets/friction_1"),
    offsets_row("/VTKHDF/Steps/PointDataOffsets/friction_1"),
    offsets_row("/VTKHDF/Steps/CellDataOffsets/friction_2"),
    offsets_row("/VTKHDF/Steps/PointDataOffsets/friction_2"),
];

pub(super) const fn offsets_row(path: &'static str) -> DatasetSpec {
    let meaning = "Where the values of each step begin.";
    GROUP
        .row(path, Kind::I64, STEPS, Dimension::Number, meaning)
        .optional(ONLY)
}

/// A series that is being written, step by step, so that the values of one are in memory at a time.
pub struct Series<'w, 't> {
    writer: &'w mut GroupWriter<'t>,
    n_steps: usize,
    arrays: Vec<Piecewise<f64>>,
}

impl<'w, 't> Series<'w, 't> {
    /// Writes the grid and the time of each step, in ascending order.
    ///
    /// # Errors
    /// HDF5 failures.
    pub fn begin(
        writer: &'w mut GroupWriter<'t>,
        mesh: &Mesh,
        times: &[f64],
    ) -> Result<Self, StoreError> {
        write_grid(writer, mesh)?;
        vtkhdf_once::write_normals(writer, mesh, Some(times.len()))?;
        Self::on_grid(writer, times)
    }

    /// Writes the time of each step, in ascending order, of a series whose grid is written.
    pub(super) fn on_grid(
        writer: &'w mut GroupWriter<'t>,
        times: &[f64],
    ) -> Result<Self, StoreError> {
        let n_steps = times.len();
        writer.write(VALUES, times, &[n_steps])?;
        let number = i64::try_from(n_steps).unwrap_or(i64::MAX);
        writer.write_inner_attribute("Steps", "NSteps", number)?;
        writer.write_indices(PARTS, &vec![1; n_steps], &[n_steps])?;
        for path in [PART_OFFSETS, POINT_OFFSETS] {
            writer.write_indices(path, &vec![0; n_steps], &[n_steps])?;
        }
        for path in [CELL_OFFSETS, CONNECTIVITY_OFFSETS] {
            writer.write_indices(path, &vec![0; n_steps], &[n_steps, 1])?;
        }
        Ok(Self {
            writer,
            n_steps,
            arrays: Vec::new(),
        })
    }

    /// Writes the next step, with the frame of its contact face.
    ///
    /// # Errors
    /// HDF5 failures; a step more than there are times.
    pub fn step(
        &mut self,
        mesh: &Mesh,
        shown: &GridValues<'_>,
        frame: Option<&ContactFrame>,
    ) -> Result<(), StoreError> {
        self.append(&fields(mesh, shown, frame))
    }

    /// Writes the fields of the next step, the same ones in each.
    pub(super) fn append(&mut self, fields: &[Field]) -> Result<(), StoreError> {
        if self.arrays.is_empty() {
            for field in fields {
                let array = self.writer.begin(&field.path, &field.shape(self.n_steps))?;
                self.arrays.push(array);
                self.write_offsets(field)?;
            }
        }
        for (array, field) in self.arrays.iter_mut().zip(fields) {
            self.writer.append(array, &field.values)?;
        }
        Ok(())
    }

    fn write_offsets(&mut self, field: &Field) -> Result<(), StoreError> {
        let Some((kind, name)) = field.path.trim_start_matches("/VTKHDF/").split_once('/') else {
            return Ok(());
        };
        let path = format!("/VTKHDF/Steps/{kind}Offsets/{name}");
        let offsets: Vec<usize> = (0..self.n_steps).map(|step| step * field.rows()).collect();
        self.writer.write_indices(&path, &offsets, &[self.n_steps])
    }

    /// Ends the series.
    ///
    /// # Errors
    /// HDF5 failures; a step less than there are times.
    pub fn finish(self) -> Result<(), StoreError> {
        let Self { writer, arrays, .. } = self;
        arrays.into_iter().try_for_each(|array| writer.end(array))
    }
}

//! Sparse matrices: groups `{data, indices, indptr}` as scipy and AnnData know them.

use hdf5_metno as hdf5;

use crate::attribute::{read_numbers, read_text, write_text, write_values};
use crate::dataset::{new_dataset, open_dataset};
use crate::digest::DatasetDigest;
use crate::error::{AtPlace, Place, StoreError};
use crate::layout::{DatasetSpec, Kind, Storage};
use crate::reader::{Reader, to_indices};

/// A compressed sparse matrix that is borrowed to be written.
#[derive(Clone, Copy, Debug)]
pub struct SparseView<'a> {
    /// Rows and columns.
    pub shape: [usize; 2],
    /// Start of each column (CSC) or row (CSR) in `indices` and `data`, and the end of the last.
    pub indptr: &'a [usize],
    /// Row (CSC) or column (CSR) of each entry, increasing within each column or row.
    pub indices: &'a [usize],
    /// Value of each entry.
    pub data: &'a [f64],
}

/// A compressed sparse matrix that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseMatrix {
    /// Rows and columns.
    pub shape: [usize; 2],
    /// Start of each column (CSC) or row (CSR) in `indices` and `data`, and the end of the last.
    pub indptr: Vec<usize>,
    /// Row (CSC) or column (CSR) of each entry, increasing within each column or row.
    pub indices: Vec<usize>,
    /// Value of each entry.
    pub data: Vec<f64>,
}

impl SparseMatrix {
    /// The matrix, borrowed.
    #[must_use]
    pub fn view(&self) -> SparseView<'_> {
        SparseView {
            shape: self.shape,
            indptr: &self.indptr,
            indices: &self.indices,
            data: &self.data,
        }
    }
}

impl SparseView<'_> {
    /// The first breach of the compressed format, if there is one.
    ///
    /// `indptr` starts at 0, does not decrease and ends at the number of entries; indices are in
    /// range and strictly increasing within each column or row.
    #[must_use]
    pub fn problem(&self, kind: Kind) -> Option<String> {
        let [rows, columns] = self.shape;
        let (outer, inner) = if kind == Kind::CscMatrix {
            (columns, rows)
        } else {
            (rows, columns)
        };
        if outer.checked_add(1) != Some(self.indptr.len()) {
            return Some(format!(
                "indptr has {} values for {outer} columns or rows",
                self.indptr.len()
            ));
        }
        if self.indices.len() != self.data.len() {
            return Some(format!(
                "{} indices for {} values",
                self.indices.len(),
                self.data.len()
            ));
        }
        if self.indptr.first() != Some(&0) || self.indptr.last() != Some(&self.data.len()) {
            return Some(format!("indptr does not go from 0 to {}", self.data.len()));
        }
        if !self.indptr.is_sorted() {
            return Some("indptr decreases".into());
        }
        let unordered = |bounds: &[usize]| {
            let indices = &self.indices[bounds[0]..bounds[1]];
            !indices.is_sorted_by(|left, right| left < right)
                || indices.last().is_some_and(|&last| last >= inner)
        };
        let position = self.indptr.windows(2).position(unordered)?;
        Some(format!(
            "indices of column or row {position} are not increasing or not below {inner}"
        ))
    }
}

/// The value of `encoding-version` in the AnnData convention.
const ENCODING_VERSION: &str = "0.1.0";

impl Reader {
    /// Reads a sparse matrix and checks its compressed format.
    ///
    /// # Errors
    /// As for [`Reader::read`]; `Damaged` if `indptr` or `indices` are not those of a matrix.
    pub fn read_matrix(&self, path: &str) -> Result<SparseMatrix, StoreError> {
        let spec = self.spec(path, Kind::CscMatrix)?;
        let place = self.place(spec);
        let file = self.file_of(spec.group)?;
        let group = file.hdf5.group(spec.path).at(place, "open the matrix")?;
        let encoding = read_text(&group, place, "encoding-type")?;
        if encoding != spec.kind.tag() {
            return Err(place.mismatch(spec.kind.tag(), encoding));
        }
        let shape = shape_of(&group, place)?;
        self.check_shape(spec, &shape)?;
        let indptr: Vec<i64> = read_part(&file.hdf5, place, "indptr", Kind::I64)?;
        let indices: Vec<i64> = read_part(&file.hdf5, place, "indices", Kind::I64)?;
        let data: Vec<f64> = read_part(&file.hdf5, place, "data", Kind::F64)?;
        self.all_finite(path, &data)?;
        let matrix = SparseMatrix {
            shape,
            indptr: to_indices(&indptr, place)?,
            indices: to_indices(&indices, place)?,
            data,
        };
        matrix
            .view()
            .problem(spec.kind)
            .map_or(Ok(matrix), |problem| Err(place.damaged(problem)))
    }
}

/// The datasets in the group of a matrix.
pub(super) const PARTS: [&str; 3] = ["data", "indices", "indptr"];

fn read_part<T: hdf5::H5Type>(
    file: &hdf5::File,
    place: Place<'_>,
    name: &str,
    kind: Kind,
) -> Result<Vec<T>, StoreError> {
    let path = format!("{}/{name}", place.dataset);
    let place = place.beside(&path);
    let dataset = open_dataset(file, place, kind)?;
    dataset.read_raw().at(place, "read the values")
}

/// The attribute `shape` of the group of a matrix.
pub(super) fn shape_of(group: &hdf5::Group, place: Place<'_>) -> Result<[usize; 2], StoreError> {
    let shape = to_indices(&read_numbers(group, place, "shape")?, place)?;
    <[usize; 2]>::try_from(shape)
        .map_err(|shape| place.mismatch("two extents", format!("{shape:?}")))
}

/// Writes a matrix as a new group and returns the group and its digest.
pub(super) fn write(
    parent: &hdf5::Group,
    place: Place<'_>,
    spec: &DatasetSpec,
    matrix: SparseView<'_>,
) -> Result<(hdf5::Group, String), StoreError> {
    let group = parent
        .create_group_builder()
        .obj_track_times(false)
        .create_intermediate_group(true)
        .create(spec.name())
        .at(place, "create the matrix")?;
    let indptr = from_indices(matrix.indptr);
    let indices = from_indices(matrix.indices);
    for (name, values) in [("indptr", &indptr), ("indices", &indices)] {
        new_dataset(&group, place, name, &[values.len()], spec.storage, values)?;
    }
    let (plain, size) = (Storage::Plain, matrix.data.len());
    new_dataset(&group, place, "data", &[size], plain, matrix.data)?;
    write_text(&group, place, "encoding-type", spec.kind.tag())?;
    write_text(&group, place, "encoding-version", ENCODING_VERSION)?;
    write_values(&group, place, "shape", &from_indices(&matrix.shape))?;
    let digest = digest(spec.kind, matrix.shape, &indptr, &indices, matrix.data);
    Ok((group, digest))
}

/// Indices as the file stores them; a slice in memory has fewer than 2^63 elements, so its indices
/// fit.
pub(super) fn from_indices(indices: &[usize]) -> Vec<i64> {
    indices
        .iter()
        .map(|&index| i64::try_from(index).unwrap_or(i64::MAX))
        .collect()
}

fn digest(kind: Kind, shape: [usize; 2], indptr: &[i64], indices: &[i64], data: &[f64]) -> String {
    let mut digest = DatasetDigest::new(kind, &shape);
    digest.size(data.len());
    digest.values(indptr);
    digest.values(indices);
    digest.values(data);
    digest.finish()
}

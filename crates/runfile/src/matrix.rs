//! Sparse matrices: groups `{data, indices, indptr}` as scipy and AnnData know them.

use hdf5_metno as hdf5;

use crate::attribute::{read_numbers, read_text, write_text, write_values};
use crate::dataset::{claims_much, feed, new_dataset, open_dataset, require_bytes};
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
        let volume = self.volume(spec.group)?;
        let group = volume.file.group(spec.path).at(place, "open the matrix")?;
        let encoding = read_text(&group, place, "encoding-type")?;
        if encoding != spec.kind.tag() {
            return Err(place.mismatch(spec.kind.tag(), encoding));
        }
        let shape = shape_of(&group, place)?;
        self.check_shape(spec, &shape)?;
        for part in PARTS.map(|part| format!("{path}/{part}")) {
            if !self.volume_of_object(spec.group, &part)?.holds(&part) {
                return Err(self.missing(&part, spec.group));
            }
        }
        let stored = read_text(&group, place, "digest")?;
        let parts = MatrixParts::open(&volume.file, place, volume.bytes)?;
        if parts.claim_much() {
            place.same_digest(stored.clone(), parts.digest(spec.kind, shape, place)?)?;
        }
        let read = "read the values";
        let indptr: Vec<i64> = parts.indptr.read_raw().at(place, read)?;
        let indices: Vec<i64> = parts.indices.read_raw().at(place, read)?;
        let data: Vec<f64> = parts.data.read_raw().at(place, read)?;
        place.same_digest(stored, digest(spec.kind, shape, &indptr, &indices, &data))?;
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

/// The datasets of a stored matrix, whose values the file can hold.
struct MatrixParts {
    indptr: hdf5::Dataset,
    indices: hdf5::Dataset,
    data: hdf5::Dataset,
}

impl MatrixParts {
    fn open(file: &hdf5::File, place: Place<'_>, file_bytes: u64) -> Result<Self, StoreError> {
        let part = |name, kind| {
            let path = format!("{}/{name}", place.dataset);
            let place = place.beside(&path);
            let dataset = open_dataset(file, place, kind)?;
            if dataset.ndim() != 1 {
                return Err(place.mismatch("a vector", format!("shape {:?}", dataset.shape())));
            }
            require_bytes(&dataset, place, file_bytes)?;
            Ok(dataset)
        };
        Ok(Self {
            indptr: part("indptr", Kind::I64)?,
            indices: part("indices", Kind::I64)?,
            data: part("data", Kind::F64)?,
        })
    }

    fn claim_much(&self) -> bool {
        let mut parts = [&self.indptr, &self.indices, &self.data].into_iter();
        parts.any(|part| claims_much(part, &part.shape(), size_of::<f64>()))
    }

    fn digest(
        &self,
        kind: Kind,
        shape: [usize; 2],
        place: Place<'_>,
    ) -> Result<String, StoreError> {
        let mut digest = DatasetDigest::new(kind, &shape);
        digest.size(self.data.size());
        feed::<i64>(&mut digest, &self.indptr, place)?;
        feed::<i64>(&mut digest, &self.indices, place)?;
        feed::<f64>(&mut digest, &self.data, place)?;
        Ok(digest.finish())
    }
}

/// The digest of the values of a matrix that the table need not know.
pub(super) fn digest_of(
    file: &hdf5::File,
    place: Place<'_>,
    file_bytes: u64,
) -> Result<String, StoreError> {
    let group = file.group(place.dataset).at(place, "open the matrix")?;
    let encoding = read_text(&group, place, "encoding-type")?;
    let mut kinds = [Kind::CscMatrix, Kind::CsrMatrix].into_iter();
    let kind = kinds.find(|kind| kind.tag() == encoding);
    let kind = kind.ok_or_else(|| place.mismatch("a sparse matrix", encoding))?;
    let parts = MatrixParts::open(file, place, file_bytes)?;
    parts.digest(kind, shape_of(&group, place)?, place)
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

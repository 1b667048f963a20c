//! Sparse matrices in the file: groups `{data, indices, indptr}` as scipy and AnnData know them.

use hdf5_metno as hdf5;

use super::attribute::{read_numbers, read_text, write_numbers, write_text};
use super::bounds;
use super::dataset::{new_dataset, open_dataset};
use super::digest::DatasetDigest;
use super::element::StoredElement;
use super::error::StoreError;
use super::layout::{DatasetSpec, Kind, Storage};
use super::place::{AtPlace, Place};
use super::reader::{Reader, to_indices};
use super::sparse::{SparseMatrix, SparseView};
use super::stream;

/// The value of `encoding-version` in the AnnData convention.
const ENCODING_VERSION: &str = "0.1.0";

impl Reader {
    /// Reads a sparse matrix and checks its compressed format.
    ///
    /// # Errors
    /// As for [`Reader::read`]; `Damaged` if `indptr` or `indices` are not those of a matrix.
    pub fn read_matrix(&self, path: &str) -> Result<SparseMatrix, StoreError> {
        let spec = self.spec(path, Kind::is_matrix, Kind::CscMatrix)?;
        let place = self.place(spec);
        let file = &self.volume(spec.group)?.file;
        let group = file.group(spec.path).at(place, "open the matrix")?;
        let encoding = read_text(&group, place, "encoding-type")?;
        if encoding != spec.kind.tag() {
            return Err(place.mismatch(spec.kind.tag(), encoding));
        }
        let shape = shape(self, spec)?;
        self.check_shape(spec, &shape)?;
        let stored = read_text(&group, place, "digest")?;
        let pointers = self.part::<i64>(spec, "indptr")?;
        let rows = self.part::<i64>(spec, "indices")?;
        let entries = self.part::<f64>(spec, "data")?;
        if [&pointers, &rows, &entries]
            .iter()
            .any(|part| bounds::claims_much(part, &part.shape(), size_of::<f64>()))
        {
            let mut digest = DatasetDigest::new(spec.kind, &shape);
            digest.size(entries.size());
            stream::feed::<i64>(&mut digest, &pointers, &pointers.shape(), place)?;
            stream::feed::<i64>(&mut digest, &rows, &rows.shape(), place)?;
            stream::feed::<f64>(&mut digest, &entries, &entries.shape(), place)?;
            place.same_digest(stored.clone(), digest.finish())?;
        }
        let read = "read the values";
        let indptr: Vec<i64> = pointers.read_raw().at(place, read)?;
        let indices: Vec<i64> = rows.read_raw().at(place, read)?;
        let data: Vec<f64> = entries.read_raw().at(place, read)?;
        place.same_digest(stored, digest(spec.kind, shape, &indptr, &indices, &data))?;
        self.all_finite(path, &data)?;
        let indptr = to_indices(&indptr, place)?;
        let matrix = SparseMatrix {
            shape,
            indptr,
            indices: to_indices(&indices, place)?,
            data,
        };
        matrix
            .view()
            .problem(spec.kind)
            .map_or(Ok(matrix), |problem| Err(place.damaged(problem)))
    }

    /// A part of a matrix, whose values the file can hold.
    fn part<T: StoredElement>(
        &self,
        spec: &DatasetSpec,
        name: &str,
    ) -> Result<hdf5::Dataset, StoreError> {
        let path = format!("{}/{name}", spec.path);
        let volume = self.volume_of_object(spec.group, &path)?;
        let place = Place::new(&volume.path, &path);
        if !volume.holds(&path) {
            return Err(self.missing(&path, spec.group));
        }
        let dataset = open_dataset(&volume.file, place, &T::type_descriptor())?;
        if dataset.ndim() != 1 {
            return Err(place.mismatch("a vector", format!("shape {:?}", dataset.shape())));
        }
        bounds::check(&dataset, place, volume.bytes)?;
        Ok(dataset)
    }
}

/// The attribute `shape` of a stored matrix: rows, columns.
pub(super) fn shape(reader: &Reader, spec: &DatasetSpec) -> Result<[usize; 2], StoreError> {
    let place = reader.place(spec);
    let file = &reader.volume(spec.group)?.file;
    let group = file.group(spec.path).at(place, "open the matrix")?;
    shape_of(&group, place)
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
    new_dataset(
        &group,
        place,
        "indptr",
        &[indptr.len()],
        spec.storage,
        &indptr,
    )?;
    new_dataset(
        &group,
        place,
        "indices",
        &[indices.len()],
        spec.storage,
        &indices,
    )?;
    new_dataset(
        &group,
        place,
        "data",
        &[matrix.data.len()],
        Storage::Plain,
        matrix.data,
    )?;
    write_text(&group, place, "encoding-type", spec.kind.tag())?;
    write_text(&group, place, "encoding-version", ENCODING_VERSION)?;
    write_numbers(&group, place, "shape", &from_indices(&matrix.shape))?;
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

/// The digest of a matrix that the table need not know.
pub(super) fn digest_of(
    group: &hdf5::Group,
    place: Place<'_>,
    file_bytes: u64,
) -> Result<String, StoreError> {
    let encoding = read_text(group, place, "encoding-type")?;
    let mut kinds = [Kind::CscMatrix, Kind::CsrMatrix].into_iter();
    let kind = kinds.find(|kind| kind.tag() == encoding);
    let kind = kind.ok_or_else(|| place.mismatch("a sparse matrix", encoding))?;
    let shape = shape_of(group, place)?;
    let indptr = vector::<i64>(group, place, "indptr", file_bytes)?;
    let indices = vector::<i64>(group, place, "indices", file_bytes)?;
    let data = vector::<f64>(group, place, "data", file_bytes)?;
    Ok(digest(kind, shape, &indptr, &indices, &data))
}

fn vector<T: StoredElement>(
    group: &hdf5::Group,
    place: Place<'_>,
    name: &'static str,
    file_bytes: u64,
) -> Result<Vec<T>, StoreError> {
    let dataset = open_dataset(group, place.beside(name), &T::type_descriptor())?;
    bounds::check(&dataset, place, file_bytes)?;
    dataset.read_raw().at(place, "read the values")
}

//! Datasets in pieces: streams that need no memory for the whole.

use hdf5_metno as hdf5;
use hdf5_metno::{Hyperslab, SliceOrIndex};
use ndarray::ArrayViewD;

use super::dataset::empty_dataset;
use super::digest::DatasetDigest;
use super::element::StoredElement;
use super::error::{LayoutError, StoreError};
use super::layout::DatasetSpec;
use super::place::AtPlace;
use super::writer::GroupWriter;

/// A dataset whose rows come one after the other; its bytes and its digest are those of all written at once.
#[derive(Debug)]
pub struct Piecewise<T> {
    spec: &'static DatasetSpec,
    dataset: hdf5::Dataset,
    digest: DatasetDigest,
    shape: Vec<usize>,
    /// Rows on the disk.
    rows: usize,
    /// Rows that are written at a time, whole chunks: a chunk that is written twice would be stored twice.
    batch: usize,
    /// What is not on the disk yet.
    waiting: Vec<T>,
}

impl<T> Piecewise<T> {
    /// Values of one row.
    fn width(&self) -> usize {
        self.shape[1..].iter().product()
    }

    fn length_error(&self, found: usize) -> StoreError {
        let problem = format!(": {found} values do not fill the shape {:?}", self.shape);
        LayoutError::dataset(self.spec.path, problem)
    }
}

impl GroupWriter<'_> {
    /// Begins a dataset of one extent or more, whose size is known and whose values are not.
    ///
    /// # Errors
    /// `Internal` for a breach of the table, `Hdf5` if writing fails.
    pub fn begin<T: StoredElement>(
        &mut self,
        path: &str,
        shape: &[usize],
    ) -> Result<Piecewise<T>, StoreError> {
        let spec = self.admit(path, T::KIND, shape, None)?;
        let (place, name) = (self.place(spec), spec.name());
        let dataset = empty_dataset::<T>(&self.object, place, name, shape, spec.storage)?;
        Ok(Piecewise {
            spec,
            batch: dataset.chunk().map_or(1, |chunk| chunk[0]),
            dataset,
            digest: DatasetDigest::new(spec.kind, shape),
            shape: shape.to_vec(),
            rows: 0,
            waiting: Vec::new(),
        })
    }

    /// Writes the next rows.
    ///
    /// # Errors
    /// `Internal` for values that are no whole rows or too many, `Hdf5` if writing fails.
    pub fn append<T: StoredElement>(
        &self,
        piecewise: &mut Piecewise<T>,
        values: &[T],
    ) -> Result<(), StoreError> {
        let width = piecewise.width().max(1);
        piecewise.waiting.extend_from_slice(values);
        let rows = piecewise.waiting.len() / width;
        let is_whole = values.len().is_multiple_of(width);
        if !is_whole || piecewise.rows + rows > piecewise.shape[0] {
            return Err(piecewise.length_error(values.len()));
        }
        piecewise.digest.values(values);
        self.write_rows(piecewise, rows - rows % piecewise.batch)
    }

    /// Writes the first rows of those that wait.
    fn write_rows<T: StoredElement>(
        &self,
        piecewise: &mut Piecewise<T>,
        rows: usize,
    ) -> Result<(), StoreError> {
        if rows == 0 {
            return Ok(());
        }
        let place = self.place(piecewise.spec);
        let end = piecewise.rows + rows;
        let mut shape = piecewise.shape.clone();
        shape[0] = rows;
        let others = shape[1..].iter().map(|extent| 0..*extent);
        let ranges = std::iter::once(piecewise.rows..end).chain(others);
        let slab: Vec<SliceOrIndex> = ranges.map(SliceOrIndex::from).collect();
        let values = &piecewise.waiting[..shape.iter().product()];
        let view = ArrayViewD::from_shape(shape, values)
            .map_err(|error| hdf5::Error::from(error.to_string()))
            .at(place, "shape the values")?;
        let written = piecewise.dataset.write_slice(view, Hyperslab::from(slab));
        written.at(place, "write the values")?;
        let count = values.len();
        piecewise.waiting.drain(..count);
        piecewise.rows = end;
        Ok(())
    }

    /// Ends a dataset.
    ///
    /// # Errors
    /// `Internal` where rows are missing, `Hdf5` if writing fails.
    pub fn end<T: StoredElement>(&mut self, mut piecewise: Piecewise<T>) -> Result<(), StoreError> {
        let rows = piecewise.waiting.len() / piecewise.width().max(1);
        self.write_rows(&mut piecewise, rows)?;
        if piecewise.rows != piecewise.shape[0] {
            return Err(piecewise.length_error(piecewise.rows * piecewise.width()));
        }
        let Piecewise {
            spec,
            dataset,
            digest,
            ..
        } = piecewise;
        self.seal(spec, &dataset, digest.finish())
    }
}

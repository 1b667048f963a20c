//! Writing a dataset piece by piece, where its values are never all in memory.

use std::marker::PhantomData;

use hdf5_metno as hdf5;
use hdf5_metno::{Hyperslab, SliceOrIndex};
use ndarray::ArrayViewD;

use super::dataset::empty_dataset;
use super::digest::DatasetDigest;
use super::element::Element;
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
    rows: usize,
    element: PhantomData<T>,
}

impl<T> Piecewise<T> {
    /// Values of one row.
    fn width(&self) -> usize {
        self.shape[1..].iter().product()
    }

    fn length_error(&self, found: usize) -> StoreError {
        LayoutError::Length {
            path: self.spec.path,
            shape: self.shape.clone(),
            found,
        }
        .into()
    }
}

impl GroupWriter<'_> {
    /// Begins a dataset of one extent or more, whose size is known and whose values are not.
    ///
    /// # Errors
    /// `Internal` for a breach of the table, `Hdf5` if writing fails.
    pub fn begin<T: Element>(
        &mut self,
        path: &str,
        shape: &[usize],
    ) -> Result<Piecewise<T>, StoreError> {
        let spec = self.admit(path, T::KIND, shape, None)?;
        let (place, name) = (self.place(spec), spec.name());
        let dataset = empty_dataset::<T>(&self.object, place, name, shape, spec.storage)?;
        Ok(Piecewise {
            spec,
            dataset,
            digest: DatasetDigest::new(spec.kind, shape),
            shape: shape.to_vec(),
            rows: 0,
            element: PhantomData,
        })
    }

    /// Writes the next rows.
    ///
    /// # Errors
    /// `Internal` for values that are no whole rows or too many, `Hdf5` if writing fails.
    pub fn append<T: Element>(
        &self,
        piecewise: &mut Piecewise<T>,
        values: &[T],
    ) -> Result<(), StoreError> {
        let place = self.place(piecewise.spec);
        let rows = values.len() / piecewise.width().max(1);
        let end = piecewise.rows + rows;
        if rows * piecewise.width() != values.len() || end > piecewise.shape[0] {
            return Err(piecewise.length_error(values.len()));
        }
        let mut shape = piecewise.shape.clone();
        shape[0] = rows;
        let others = shape[1..].iter().map(|extent| 0..*extent);
        let ranges = std::iter::once(piecewise.rows..end).chain(others);
        let slab: Vec<SliceOrIndex> = ranges.map(SliceOrIndex::from).collect();
        let view = ArrayViewD::from_shape(shape, values)
            .map_err(|error| hdf5::Error::from(error.to_string()))
            .at(place, "shape the values")?;
        let written = piecewise.dataset.write_slice(view, Hyperslab::from(slab));
        written.at(place, "write the values")?;
        piecewise.digest.values(values);
        piecewise.rows = end;
        Ok(())
    }

    /// Ends a dataset.
    ///
    /// # Errors
    /// `Internal` where rows are missing, `Hdf5` if writing fails.
    pub fn end<T: Element>(&mut self, piecewise: Piecewise<T>) -> Result<(), StoreError> {
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

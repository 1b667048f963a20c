//! Values read block by block, so that a file which claims much takes no memory before it is found wrong.

use std::ops::ControlFlow;

use hdf5::types::VarLenUnicode;
use hdf5::{Hyperslab, SliceOrIndex};
use hdf5_metno as hdf5;
use ndarray::{ArrayD, Ix1};

use super::digest::DatasetDigest;
use super::element::StoredElement;
use super::error::StoreError;
use super::layout::Kind;
use super::place::{AtPlace, Place};

/// Aim for the size of a block in bytes.
const BLOCK_BYTES: usize = 1 << 24;

/// Texts read at once.
const BLOCK_TEXTS: usize = 16;

/// The digest of a plain array, read in blocks of whole rows.
///
/// # Errors
/// `Hdf5` if reading fails.
pub(super) fn digest<T: StoredElement>(
    dataset: &hdf5::Dataset,
    kind: Kind,
    shape: &[usize],
    place: Place<'_>,
) -> Result<String, StoreError> {
    let mut digest = DatasetDigest::new(kind, shape);
    feed::<T>(&mut digest, dataset, shape, place)?;
    Ok(digest.finish())
}

/// Adds the values of a dataset to a digest, in blocks of whole rows.
///
/// # Errors
/// `Hdf5` if reading fails.
pub(super) fn feed<T: StoredElement>(
    digest: &mut DatasetDigest,
    dataset: &hdf5::Dataset,
    shape: &[usize],
    place: Place<'_>,
) -> Result<(), StoreError> {
    let row = shape.iter().skip(1).product::<usize>() * size_of::<T>();
    let at_once = (BLOCK_BYTES / row.max(1)).max(1);
    let rows = shape.first().copied().unwrap_or(1);
    if rows <= at_once {
        let values = dataset.read_raw::<T>().at(place, "read the values")?;
        digest.values(&values);
        return Ok(());
    }
    for first in (0..rows).step_by(at_once) {
        let others = shape[1..].iter().map(|extent| 0..*extent);
        let ranges = std::iter::once(first..rows.min(first + at_once)).chain(others);
        let slab: Vec<SliceOrIndex> = ranges.map(SliceOrIndex::from).collect();
        let block: ArrayD<T> = dataset
            .read_slice(Hyperslab::from(slab))
            .at(place, "read the values")?;
        let values = block.into_raw_vec_and_offset().0;
        digest.values(&values);
    }
    Ok(())
}

/// The texts of a dataset, which are no longer together than the file: each is stored by itself.
///
/// # Errors
/// `Damaged` for longer ones or one that is not UTF-8, `Hdf5` if reading fails.
pub(super) fn texts(
    dataset: &hdf5::Dataset,
    shape: &[usize],
    place: Place<'_>,
    file_bytes: u64,
) -> Result<Vec<String>, StoreError> {
    let mut texts: Vec<String> = Vec::new();
    let mut bytes = 0;
    let mut add = |read: &[VarLenUnicode]| {
        for text in read {
            bytes += text.as_bytes().len() as u64;
            let Ok(text) = std::str::from_utf8(text.as_bytes()) else {
                return ControlFlow::Break("a text is not UTF-8");
            };
            if bytes > file_bytes {
                return ControlFlow::Break("its texts are longer than the file");
            }
            texts.push(text.to_owned());
        }
        ControlFlow::Continue(())
    };
    let read = "read the texts";
    let found = match *shape {
        [rows] => (0..rows).step_by(BLOCK_TEXTS).try_for_each(|first| {
            let slab: Vec<SliceOrIndex> = vec![(first..rows.min(first + BLOCK_TEXTS)).into()];
            match dataset.read_slice::<VarLenUnicode, _, Ix1>(Hyperslab::from(slab)) {
                Ok(block) => add(&block.to_vec()).map_break(Ok),
                Err(error) => ControlFlow::Break(Err(error)),
            }
        }),
        _ => match dataset.read_raw::<VarLenUnicode>() {
            Ok(block) => add(&block).map_break(Ok),
            Err(error) => ControlFlow::Break(Err(error)),
        },
    };
    match found {
        ControlFlow::Continue(()) => Ok(texts),
        ControlFlow::Break(Ok(reason)) => Err(place.damaged(reason)),
        ControlFlow::Break(Err(error)) => Err(error).at(place, read),
    }
}

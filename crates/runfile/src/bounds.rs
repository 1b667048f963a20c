//! Checks before any memory is taken: a declared size must be backed by bytes in the file.

use hdf5::dataset::Layout as Storage;
use hdf5_metno as hdf5;

use super::error::StoreError;
use super::place::{AtPlace, Place};

/// Deflate stores at most 258 bytes of input in two bits of output; its limit is 1032 to 1.
const MAX_DEFLATE_RATIO: u64 = 1032;

/// Chunks up to this size are fine, larger ones only for larger rows; in bytes.
const SMALL_CHUNK: u64 = 1 << 26;

/// Values up to this size are read at once, in bytes.
const SMALL: u64 = 1 << 26;

/// Our meshes and indices shrink to a tenth or so.
const USUAL_RATIO: u64 = 32;

/// Whether so little is stored for so many values that they had better be compared with their digest before memory is taken
/// for all of them.
pub(super) fn claims_much(dataset: &hdf5::Dataset, shape: &[usize], element: usize) -> bool {
    let bytes = shape.iter().product::<usize>() as u64 * element as u64;
    bytes > SMALL && bytes / USUAL_RATIO > dataset.storage_size()
}

/// Checks that the file can hold the values a dataset declares.
///
/// `file_bytes` is the length of the file.
///
/// # Errors
/// `Damaged` if the declared size exceeds what the stored bytes can expand to, or lies beyond the
/// end of the file.
pub(super) fn check(
    dataset: &hdf5::Dataset,
    place: Place<'_>,
    file_bytes: u64,
) -> Result<(), StoreError> {
    let element = dataset.dtype().at(place, "read the type")?.size() as u64;
    let shape = dataset.get_shape().at(place, "read the shape")?;
    let declared = shape
        .iter()
        .try_fold(element, |bytes, &extent| bytes.checked_mul(extent as u64));
    let declared =
        declared.ok_or_else(|| place.damaged(format!("shape {shape:?} is too large to exist")))?;
    if declared == 0 {
        return Ok(());
    }
    let stored = dataset.storage_size();
    let holds = match dataset.layout() {
        Storage::Compact => stored >= declared && stored <= file_bytes,
        Storage::Contiguous => {
            let end = dataset
                .offset()
                .and_then(|offset| offset.checked_add(stored));
            // A variable-length text takes 16 bytes in the file for a pointer of 8 in memory.
            stored >= declared && end.is_some_and(|end| end <= file_bytes)
        }
        Storage::Chunked => {
            let ratio = if dataset.filters().is_empty() {
                1
            } else {
                MAX_DEFLATE_RATIO
            };
            let chunk = dataset.chunk().unwrap_or_default();
            let chunk = chunk
                .iter()
                .try_fold(element, |bytes, &extent| bytes.checked_mul(extent as u64));
            let row = declared / shape.first().map_or(1, |&rows| rows as u64);
            stored <= file_bytes
                && declared <= stored.saturating_mul(ratio)
                && chunk.is_some_and(|chunk| chunk <= row.max(SMALL_CHUNK))
        }
        Storage::Virtual => false,
    };
    if holds {
        return Ok(());
    }
    Err(place.damaged(format!(
        "shape {shape:?} needs {declared} bytes, the file stores {stored} for it"
    )))
}

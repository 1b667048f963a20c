//! One dataset: how it is made and opened, and how its values are read.
//!
//! A declared size must be backed by bytes in the file before memory is taken for it, and a file that claims much is read block
//! by block until its digest is known to be right.

use hdf5::types::{EnumMember, EnumType, IntSize, TypeDescriptor, VarLenUnicode};
use hdf5::{H5Type, Hyperslab, SliceOrIndex};
use hdf5_metno as hdf5;
use ndarray::{ArrayD, ArrayView1, Ix1};

use crate::digest::DatasetDigest;
use crate::element::StoredElement;
use crate::error::{AtPlace, Place, StoreError};
use crate::layout::{EnumSpec, Kind, Storage};

/// Aim for the size of a chunk in bytes: large enough to compress well, small enough for HDF5's
/// chunk cache.
const CHUNK_BYTES: usize = 1 << 19;

/// The level of gzip: level 4 saves 0.1 % of a run file's bytes at n_div = 24 and takes longer.
const DEFLATE_LEVEL: u8 = 1;

/// Deflate stores at most 258 bytes of input in two bits of output; its limit is 1032 to 1.
const MAX_DEFLATE_RATIO: u64 = 1032;

/// Chunks up to this size are fine, larger ones only for larger rows; in bytes.
const SMALL_CHUNK: u64 = 1 << 26;

/// Values up to this size are read at once, in bytes.
const SMALL: u64 = 1 << 26;

/// Our meshes and indices shrink to a tenth or so.
const USUAL_RATIO: u64 = 32;

/// Aim for the size of a block in bytes.
const BLOCK_BYTES: usize = 1 << 24;

/// Texts read at once.
const BLOCK_TEXTS: usize = 16;

/// The type of a plain dataset in the file.
pub(super) fn type_of(kind: Kind) -> TypeDescriptor {
    match kind {
        Kind::F64 | Kind::CscMatrix | Kind::CsrMatrix => f64::type_descriptor(),
        Kind::F32 => f32::type_descriptor(),
        Kind::I64 => i64::type_descriptor(),
        Kind::U8 => u8::type_descriptor(),
        Kind::Text => TypeDescriptor::VarLenUnicode,
        Kind::Enum(spec) => enumeration(spec),
    }
}

fn enumeration(spec: &EnumSpec) -> TypeDescriptor {
    let members = spec.members.iter().map(|&(name, code)| EnumMember {
        name: name.into(),
        value: code.into(),
    });
    TypeDescriptor::Enum(EnumType {
        size: IntSize::U1,
        signed: false,
        members: members.collect(),
    })
}

/// Opens a dataset and checks its type.
pub(super) fn open_dataset(
    parent: &hdf5::Group,
    place: Place<'_>,
    kind: Kind,
) -> Result<hdf5::Dataset, StoreError> {
    let expected = type_of(kind);
    let dataset = parent
        .dataset(place.dataset)
        .at(place, "open the dataset")?;
    let found = dataset.dtype().and_then(|dtype| dtype.to_descriptor());
    match found {
        Ok(found) if found == expected => Ok(dataset),
        Ok(found) => Err(place.mismatch(format!("type {expected}"), format!("type {found}"))),
        Err(_) => Err(place.mismatch(format!("type {expected}"), "another type")),
    }
}

/// Creates a dataset and writes its values.
pub(super) fn new_dataset<T: H5Type>(
    group: &hdf5::Group,
    place: Place<'_>,
    name: &str,
    shape: &[usize],
    storage: Storage,
    values: &[T],
) -> Result<hdf5::Dataset, StoreError> {
    let dataset = empty_dataset::<T>(group, place, name, shape, storage)?;
    if !values.is_empty() {
        dataset
            .write_raw(ArrayView1::from(values))
            .at(place, "write the values")?;
    }
    Ok(dataset)
}

/// Creates a dataset whose values come later, all of them.
pub(super) fn empty_dataset<T: H5Type>(
    group: &hdf5::Group,
    place: Place<'_>,
    name: &str,
    shape: &[usize],
    storage: Storage,
) -> Result<hdf5::Dataset, StoreError> {
    let mut builder = group
        .new_dataset_builder()
        .empty::<T>()
        .obj_track_times(false);
    if storage == Storage::Compressed && !shape.is_empty() && !shape.contains(&0) {
        builder = builder
            .chunk(chunk::<T>(shape))
            .shuffle()
            .deflate(DEFLATE_LEVEL)
            .fill_time(hdf5::plist::dataset_create::FillTime::Never);
    }
    builder
        .shape(shape)
        .create(name)
        .at(place, "create the dataset")
}

/// Whole rows, as many as come near the aimed size.
fn chunk<T>(shape: &[usize]) -> Vec<usize> {
    let row: usize = shape[1..].iter().product();
    let rows = (CHUNK_BYTES / (row * size_of::<T>()).max(1)).clamp(1, shape[0]);
    let mut chunk = shape.to_vec();
    chunk[0] = rows;
    chunk
}

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
pub(super) fn require_bytes(
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
        hdf5::dataset::Layout::Compact => stored >= declared && stored <= file_bytes,
        hdf5::dataset::Layout::Contiguous => {
            let end = dataset
                .offset()
                .and_then(|offset| offset.checked_add(stored));
            // A variable-length text takes 16 bytes in the file for a pointer of 8 in memory.
            stored >= declared && end.is_some_and(|end| end <= file_bytes)
        }
        hdf5::dataset::Layout::Chunked => {
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
        hdf5::dataset::Layout::Virtual => false,
    };
    if holds {
        return Ok(());
    }
    Err(place.damaged(format!(
        "shape {shape:?} needs {declared} bytes, the file stores {stored} for it"
    )))
}

/// The digest of the values of a plain dataset, which is no longer than its file; of whichever type the file has.
///
/// # Errors
/// `Damaged` if the file cannot hold the values or a text is not UTF-8, `Hdf5` if reading fails.
pub(super) fn digest_of(
    dataset: &hdf5::Dataset,
    kind: Kind,
    place: Place<'_>,
    file_bytes: u64,
) -> Result<String, StoreError> {
    require_bytes(dataset, place, file_bytes)?;
    let shape = dataset.get_shape().at(place, "read the shape")?;
    let mut digest = DatasetDigest::new(kind, &shape);
    match kind {
        Kind::F64 => feed::<f64>(&mut digest, dataset, place)?,
        Kind::F32 => feed::<f32>(&mut digest, dataset, place)?,
        Kind::I64 => feed::<i64>(&mut digest, dataset, place)?,
        Kind::U8 | Kind::Enum(_) => feed::<u8>(&mut digest, dataset, place)?,
        Kind::Text | Kind::CscMatrix | Kind::CsrMatrix => {
            let texts = texts(dataset, &shape, place, file_bytes)?;
            texts.iter().for_each(|text| digest.text(text));
        }
    }
    Ok(digest.finish())
}

/// Adds the values of a dataset to a digest, in blocks of whole rows.
pub(super) fn feed<T: StoredElement>(
    digest: &mut DatasetDigest,
    dataset: &hdf5::Dataset,
    place: Place<'_>,
) -> Result<(), StoreError> {
    let shape = dataset.get_shape().at(place, "read the shape")?;
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
    let rows = match *shape {
        [rows] => rows,
        _ => 1,
    };
    for first in (0..rows).step_by(BLOCK_TEXTS) {
        let block = if shape.len() == 1 {
            let slab: Vec<SliceOrIndex> = vec![(first..rows.min(first + BLOCK_TEXTS)).into()];
            let block = dataset.read_slice::<VarLenUnicode, _, Ix1>(Hyperslab::from(slab));
            block.map(|block| block.to_vec())
        } else {
            dataset.read_raw()
        };
        for text in block.at(place, "read the texts")? {
            bytes += text.as_bytes().len() as u64;
            let text = std::str::from_utf8(text.as_bytes());
            let text = text.map_err(|_| place.damaged("a text is not UTF-8"))?;
            if bytes > file_bytes {
                return Err(place.damaged("its texts are longer than the file"));
            }
            texts.push(text.to_owned());
        }
    }
    Ok(texts)
}

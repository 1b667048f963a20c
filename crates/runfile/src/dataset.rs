//! One dataset: how it is made and opened.

use hdf5::H5Type;
use hdf5::types::{EnumMember, EnumType, IntSize, TypeDescriptor, VarLenUnicode};
use hdf5_metno as hdf5;
use ndarray::ArrayView1;

use crate::error::{AtPlace, Place, StoreError};
use crate::layout::{EnumSpec, Kind, Storage};

/// Aim for the size of a chunk in bytes: large enough to compress well, small enough for HDF5's
/// chunk cache.
const CHUNK_BYTES: usize = 1 << 19;

/// Values up to this many bytes are stored as they are: chunks and their index take as much.
const PLAIN_BYTES: usize = 1 << 14;

/// The level of gzip: level 4 saves 0.1 % of a run file's bytes at n_div = 24 and takes longer.
const DEFLATE_LEVEL: u8 = 1;

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

/// Creates a dataset and writes its values; those of few bytes are not compressed.
pub(super) fn new_dataset<T: H5Type>(
    group: &hdf5::Group,
    place: Place<'_>,
    name: &str,
    shape: &[usize],
    storage: Storage,
    values: &[T],
) -> Result<hdf5::Dataset, StoreError> {
    let mut builder = group
        .new_dataset_builder()
        .empty::<T>()
        .obj_track_times(false);
    if storage == Storage::Compressed && size_of_val(values) > PLAIN_BYTES {
        builder = builder
            .chunk(chunk::<T>(shape))
            .shuffle()
            .deflate(DEFLATE_LEVEL)
            .fill_time(hdf5::plist::dataset_create::FillTime::Never);
    }
    let dataset = builder
        .shape(shape)
        .create(name)
        .at(place, "create the dataset")?;
    if !values.is_empty() {
        dataset
            .write_raw(ArrayView1::from(values))
            .at(place, "write the values")?;
    }
    Ok(dataset)
}

/// Whole rows, as many as come near the aimed size.
fn chunk<T>(shape: &[usize]) -> Vec<usize> {
    let row: usize = shape[1..].iter().product();
    let rows = (CHUNK_BYTES / (row * size_of::<T>()).max(1)).clamp(1, shape[0]);
    let mut chunk = shape.to_vec();
    chunk[0] = rows;
    chunk
}

/// The texts of a dataset.
pub(super) fn texts(dataset: &hdf5::Dataset, place: Place<'_>) -> Result<Vec<String>, StoreError> {
    let texts: Vec<VarLenUnicode> = dataset.read_raw().at(place, "read the texts")?;
    Ok(texts.iter().map(|text| text.as_str().to_owned()).collect())
}

//! One dataset: what it can hold, plain numbers and Rust enumerations that are stored as HDF5 enumerations, and how it is made and opened.

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

/// A number type with one kind in the table and one byte pattern in digests.
pub trait StoredElement: hdf5::H5Type + Copy {
    /// The kind of the datasets that hold such numbers.
    const KIND: Kind;

    /// Writes the values as little-endian bytes; `bytes` has exactly their length.
    fn to_little_endian(values: &[Self], bytes: &mut [u8]);
}

macro_rules! stored_elements {
    ($($number:ident $kind:ident),*) => {$(
        impl StoredElement for $number {
            const KIND: Kind = Kind::$kind;

            fn to_little_endian(values: &[Self], bytes: &mut [u8]) {
                let places = bytes.chunks_exact_mut(size_of::<Self>());
                for (value, bytes) in values.iter().zip(places) {
                    bytes.copy_from_slice(&value.to_le_bytes());
                }
            }
        }
    )*};
}

stored_elements!(f64 F64, f32 F32, i64 I64, u8 U8);

/// An enumeration over `u8` with the same names and codes in Rust, in the table and in the file.
///
/// Implemented by `stored_enum!` only. Values are read as codes and checked before they become an
/// enumeration.
pub trait StoredEnum: hdf5::H5Type + Copy {
    /// Name and members, as the table carries them.
    const SPEC: &'static EnumSpec;

    /// The code of this member.
    fn code(self) -> u8;

    /// The member with this code.
    fn from_code(code: u8) -> Option<Self>;
}

/// Declares an enumeration with its names and codes in the file and implements [`StoredEnum`] for
/// it.
///
/// `stored_enum! { /// Doc. pub enum Zone as "zone" { /// Doc. Open = 0 => "open", … } }`
#[macro_export]
macro_rules! stored_enum {
    (
        $(#[$meta:meta])*
        $visibility:vis enum $name:ident as $label:literal {
            $($(#[$member_meta:meta])* $member:ident = $code:literal => $text:literal),+ $(,)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, hdf5_metno::H5Type)]
        #[repr(u8)]
        $visibility enum $name {
            $($(#[$member_meta])* #[hdf5(rename = $text)] $member = $code),+
        }

        impl $crate::StoredEnum for $name {
            const SPEC: &'static $crate::EnumSpec =
                &$crate::EnumSpec { name: $label, members: &[$(($text, $code)),+] };

            fn code(self) -> u8 {
                self as u8
            }

            fn from_code(code: u8) -> Option<Self> {
                match code {
                    $($code => Some($name::$member),)+
                    _ => None,
                }
            }
        }
    };
}

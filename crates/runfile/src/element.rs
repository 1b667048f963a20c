//! The plain number types a dataset can hold.

use hdf5_metno as hdf5;

use super::layout::Kind;

/// A number type with one kind in the table and one byte pattern in digests.
pub trait StoredElement: hdf5::H5Type + Copy + private::Sealed {
    /// The kind of the datasets that hold such numbers.
    const KIND: Kind;

    /// Writes the values as little-endian bytes; `bytes` has exactly their length.
    fn to_little_endian(values: &[Self], bytes: &mut [u8]);
}

mod private {
    pub trait Sealed {}
    impl Sealed for f64 {}
    impl Sealed for f32 {}
    impl Sealed for i64 {}
    impl Sealed for u8 {}
}

impl StoredElement for f64 {
    const KIND: Kind = Kind::F64;

    fn to_little_endian(values: &[Self], bytes: &mut [u8]) {
        for (value, bytes) in values.iter().zip(bytes.chunks_exact_mut(8)) {
            bytes.copy_from_slice(&value.to_le_bytes());
        }
    }
}

impl StoredElement for f32 {
    const KIND: Kind = Kind::F32;

    fn to_little_endian(values: &[Self], bytes: &mut [u8]) {
        for (value, bytes) in values.iter().zip(bytes.chunks_exact_mut(4)) {
            bytes.copy_from_slice(&value.to_le_bytes());
        }
    }
}

impl StoredElement for i64 {
    const KIND: Kind = Kind::I64;

    fn to_little_endian(values: &[Self], bytes: &mut [u8]) {
        for (value, bytes) in values.iter().zip(bytes.chunks_exact_mut(8)) {
            bytes.copy_from_slice(&value.to_le_bytes());
        }
    }
}

impl StoredElement for u8 {
    const KIND: Kind = Kind::U8;

    fn to_little_endian(values: &[Self], bytes: &mut [u8]) {
        bytes.copy_from_slice(values);
    }
}

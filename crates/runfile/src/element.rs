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
}

macro_rules! stored_elements {
    ($($number:ident $kind:ident),*) => {$(
        impl private::Sealed for $number {}

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

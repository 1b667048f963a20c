//! What a dataset can hold: plain numbers, and Rust enumerations that are stored as HDF5 enumerations.

use hdf5_metno as hdf5;

use crate::layout::{EnumSpec, Kind};

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

//! Enumerations of the mechanics as a run file holds them.

/// Declares how an enumeration of the mechanics is stored: the name and code of each member.
///
/// Both maps name every member of both, so that a member without a code does not compile; a code
/// without a member is an error of the reader.
macro_rules! stored_as {
    (
        $(#[$meta:meta])*
        $visibility:vis $stored:ident of $meaning:ident as $label:literal {
            $($member:ident = $code:literal => $text:literal),+ $(,)?
        }
    ) => {
        runfile::stored_enum! {
            $(#[$meta])*
            $visibility enum $stored as $label {
                $(#[doc = concat!("`", $text, "`.")] $member = $code => $text),+
            }
        }

        impl From<$meaning> for $stored {
            fn from(value: $meaning) -> Self {
                match value {
                    $($meaning::$member => Self::$member),+
                }
            }
        }

        impl From<$stored> for $meaning {
            fn from(stored: $stored) -> Self {
                match stored {
                    $($stored::$member => Self::$member),+
                }
            }
        }
    };
}

pub(super) use stored_as;

use runfile::{Reader, StoredEnum};

use super::FormatError;

/// Reads the one member that a dataset holds.
pub(super) fn read_member<E: StoredEnum>(
    reader: &Reader,
    path: &'static str,
) -> Result<E, FormatError> {
    let members = reader.read_enum::<E>(path)?;
    members
        .first()
        .copied()
        .ok_or_else(|| FormatError::Inconsistent {
            dataset: path,
            reason: "expected one member, found none".into(),
        })
}

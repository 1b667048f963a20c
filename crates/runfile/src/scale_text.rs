//! Types of texts in the attributes of dimension scales: of fixed length, ending with a zero.
//!
//! HDF5 before 2.0, and so netCDF-C and h5py, takes a dataset for a scale only if its `CLASS` has 16 bytes and is of the kind
//! `H5T_STR_NULLTERM`. The binding makes texts of fixed length of another kind, padded with zeros, and none but those. It
//! copies types that a file has, though, so these come from `scale_texts.hdf5`, an HDF5 file of 250 bytes without data:
//!
//! ```python
//! types = {b"CLASS": 16, b"NAME": 64}
//! for name, size in types.items():                 # file: h5py.h5f.create(…), libver v110, no times
//!     text = h5py.h5t.C_S1.copy()
//!     text.set_size(size)
//!     text.set_strpad(h5py.h5t.STR_NULLTERM)
//!     h5py.h5a.create(file, name, text, h5py.h5s.create(h5py.h5s.SCALAR))
//! ```

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use hdf5::Datatype;
use hdf5::types::FixedAscii;
use hdf5_metno as hdf5;

use super::error::StoreError;
use super::lock::temporary_for;
use super::place::{AtFile, AtPlace, Place};
use super::signals::Temporary;

const FILE: &[u8] = include_bytes!("scale_texts.hdf5");

/// Most bytes of such a text, with the zero that ends it.
pub(super) const TEXT_BYTES: usize = 64;

/// The types, once a process has read them.
static TYPES: OnceLock<Types> = OnceLock::new();

/// The types of the attributes that make a dataset a scale.
#[derive(Debug)]
pub(super) struct Types {
    /// Of `CLASS`.
    pub(super) class: Datatype,
    /// Of `NAME`.
    pub(super) name: Datatype,
}

/// The types; the first call of a process writes the file that has them beside a temporary file, and removes it.
///
/// # Errors
/// `Io` or `Hdf5` if that file cannot be written or read.
pub(super) fn types(temporary: &Path, place: Place<'_>) -> Result<&'static Types, StoreError> {
    if let Some(types) = TYPES.get() {
        return Ok(types);
    }
    let path = &temporary_for(temporary, "texts");
    let made = Temporary::create(path.clone(), |path| {
        fs::write(path, FILE).inspect_err(|_| drop(fs::remove_file(path)))
    });
    let (_temporary, ()) = made.at_file(path, "write a temporary file")?;
    let file = hdf5::File::with_options()
        .with_fapl(|access| access.file_locking(false))
        .open(path)
        .at(place, "open a temporary file")?;
    let type_of = |name| {
        let attribute = file.attr(name);
        let dtype = attribute.and_then(|attribute| attribute.dtype());
        dtype.at(place, "read the type of a text")
    };
    let types = Types {
        class: type_of("CLASS")?,
        name: type_of("NAME")?,
    };
    Ok(TYPES.get_or_init(|| types))
}

/// Writes a text of one of the types, in place of what has its name.
pub(super) fn write(
    object: &hdf5::Location,
    place: Place<'_>,
    (name, dtype): (&str, &Datatype),
    text: &str,
) -> Result<(), StoreError> {
    let fixed = FixedAscii::<TEXT_BYTES>::from_ascii(text.as_bytes())
        .map_err(|error| hdf5::Error::from(error.to_string()))
        .at(place, "store a text that is not ASCII")?;
    let attribute = object.new_attr_builder().empty_as(dtype).create(name);
    attribute
        .and_then(|attribute| attribute.write_scalar(&fixed))
        .at(place, "write an attribute")
}

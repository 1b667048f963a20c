//! Attributes, and the numbers in them as text.

use hdf5::types::{FixedAscii, TypeDescriptor, VarLenUnicode};
use hdf5_metno as hdf5;

use crate::dataset::StoredElement;
use crate::error::{AtPlace, Place, StoreError};

/// Most values an attribute array of ours can have.
const MOST_ATTRIBUTE_VALUES: usize = 16;

/// The text as HDF5 stores it; a text with a zero character cannot be stored.
pub(super) fn unicode(text: &str) -> hdf5::Result<VarLenUnicode> {
    text.parse()
        .map_err(|error| hdf5::Error::from(format!("text cannot be stored: {error}")))
}

pub(super) fn write_text(
    object: &hdf5::Location,
    place: Place<'_>,
    name: &str,
    text: &str,
) -> Result<(), StoreError> {
    let text = unicode(text).at(place, "store a text with a zero character")?;
    write_value(object, place, name, &text)
}

/// The text of N bytes, shorter ones with zeros at the end.
pub(super) fn ascii<const N: usize>(
    text: &[u8],
    place: Place<'_>,
) -> Result<FixedAscii<N>, StoreError> {
    FixedAscii::from_ascii(text)
        .map_err(|error| hdf5::Error::from(error.to_string()))
        .at(place, "store a text that is not ASCII")
}

pub(super) fn write_value<T: hdf5::H5Type>(
    object: &hdf5::Location,
    place: Place<'_>,
    name: &str,
    value: &T,
) -> Result<(), StoreError> {
    let attribute = object.new_attr::<T>().create(name);
    attribute
        .and_then(|attribute| attribute.write_scalar(value))
        .at(place, "write an attribute")
}

pub(super) fn write_values<T: hdf5::H5Type>(
    object: &hdf5::Location,
    place: Place<'_>,
    name: &str,
    values: &[T],
) -> Result<(), StoreError> {
    let attribute = object.new_attr::<T>().shape(values.len()).create(name);
    attribute
        .and_then(|attribute| attribute.write_raw(values))
        .at(place, "write an attribute")
}

pub(super) fn read_text(
    object: &hdf5::Location,
    place: Place<'_>,
    name: &str,
) -> Result<String, StoreError> {
    let attribute = open(object, place, name)?;
    match descriptor(&attribute) {
        Some(TypeDescriptor::VarLenUnicode | TypeDescriptor::VarLenAscii)
            if attribute.is_scalar() => {}
        _ => {
            return Err(place.mismatch(format!("a text in the attribute `{name}`"), "another type"));
        }
    }
    let text = attribute
        .read_scalar::<VarLenUnicode>()
        .at(place, "read an attribute")?;
    std::str::from_utf8(text.as_bytes())
        .map(str::to_owned)
        .map_err(|_| place.damaged(format!("the attribute `{name}` is not UTF-8")))
}

pub(super) fn read_numbers<T: StoredElement>(
    object: &hdf5::Location,
    place: Place<'_>,
    name: &str,
) -> Result<Vec<T>, StoreError> {
    let attribute = open(object, place, name)?;
    if descriptor(&attribute) != Some(T::type_descriptor())
        || attribute.size() > MOST_ATTRIBUTE_VALUES
    {
        return Err(place.mismatch(
            format!("{} numbers in the attribute `{name}`", T::KIND),
            "another type",
        ));
    }
    attribute.read_raw().at(place, "read an attribute")
}

pub(super) fn read_number<T: StoredElement>(
    object: &hdf5::Location,
    place: Place<'_>,
    name: &str,
) -> Result<T, StoreError> {
    let numbers = read_numbers(object, place, name)?;
    match numbers[..] {
        [number] => Ok(number),
        _ => {
            let found = format!("{} numbers", numbers.len());
            Err(place.mismatch(format!("one number in the attribute `{name}`"), found))
        }
    }
}

/// Whether an object has an attribute of that name.
pub(super) fn has(
    object: &hdf5::Location,
    place: Place<'_>,
    name: &str,
) -> Result<bool, StoreError> {
    let names = object.attr_names().at(place, "list the attributes")?;
    Ok(names.iter().any(|found| found == name))
}

fn open(
    object: &hdf5::Location,
    place: Place<'_>,
    name: &str,
) -> Result<hdf5::Attribute, StoreError> {
    object
        .attr(name)
        .map_err(|_| place.mismatch(format!("the attribute `{name}`"), "none"))
}

fn descriptor(attribute: &hdf5::Attribute) -> Option<TypeDescriptor> {
    attribute
        .dtype()
        .and_then(|dtype| dtype.to_descriptor())
        .ok()
}

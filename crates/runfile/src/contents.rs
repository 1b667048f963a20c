//! All that an HDF5 file holds, object by object: so a file on a disk is held against the same in memory.

use std::collections::BTreeMap;

use blake3::Hasher;
use hdf5::LocationType;
use hdf5::types::{FixedAscii, FixedUnicode, TypeDescriptor};
use hdf5_metno as hdf5;

use crate::dataset::{digest_of, require_bytes};
use crate::digest::of_texts;
use crate::error::{AtPlace, Place, StoreError};
use crate::layout::Kind;
use crate::seal::add_attributes;
use crate::volume;

/// Most bytes of a text of fixed length whose digest is taken.
const MOST_TEXT: usize = 1 << 16;

/// What an object holds.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Held {
    /// The digest of its attributes and of its values.
    Digest(String),
    /// Values in other files, or of a type that only other programs write.
    Other,
    /// Nothing that can be read.
    Unreadable,
}

/// What each object of a file holds, by its path, groups with a slash at the end; no link that leads elsewhere is followed.
///
/// `bytes` is the length of the file.
pub(super) fn of(
    file: &hdf5::File,
    place: Place<'_>,
    bytes: u64,
) -> Result<BTreeMap<String, Held>, StoreError> {
    let root = file.group("/").at(place, "open the group")?;
    let mut found = BTreeMap::from([("/".to_owned(), held(of_attributes(&root, place)))]);
    let members = volume::members(&root, "");
    for member in volume::walk(members.at(place, "list the members")?) {
        let (path, name) = (member.path, &member.name);
        match member.kind {
            Ok(Some(LocationType::Dataset)) => {
                let dataset = member.parent.dataset(name).at(place, "open the dataset");
                let digest = dataset.and_then(|dataset| of_dataset(&dataset, place, bytes));
                found.insert(path, held(digest));
            }
            Ok(Some(LocationType::Group)) => {
                let group = member.parent.group(name).at(place, "open the group");
                let digest = group.and_then(|group| of_attributes(&group, place));
                found.insert(format!("{path}/"), held(digest));
            }
            Ok(_) => {}
            Err(_) => {
                found.insert(path, Held::Unreadable);
            }
        }
    }
    Ok(found)
}

fn of_attributes(group: &hdf5::Group, place: Place<'_>) -> Result<Option<String>, StoreError> {
    let mut hasher = Hasher::new();
    add_attributes(&mut hasher, group, place)?;
    Ok(Some(hasher.finalize().to_hex().to_string()))
}

fn held(digest: Result<Option<String>, StoreError>) -> Held {
    match digest {
        Ok(Some(digest)) => Held::Digest(digest),
        Ok(None) => Held::Other,
        Err(_) => Held::Unreadable,
    }
}

fn of_dataset(
    dataset: &hdf5::Dataset,
    place: Place<'_>,
    bytes: u64,
) -> Result<Option<String>, StoreError> {
    let creation = dataset.dcpl().at(place, "read how it is stored")?;
    if !creation.external().is_empty() || dataset.layout() == hdf5::dataset::Layout::Virtual {
        return Ok(None);
    }
    require_bytes(dataset, place, bytes)?;
    let shape = dataset.get_shape().at(place, "read the shape")?;
    let dtype = dataset.dtype().and_then(|dtype| dtype.to_descriptor());
    let values = match dtype {
        Ok(TypeDescriptor::Float(_)) => digest_of(dataset, Kind::F64, place, bytes)?,
        Ok(TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_)) => {
            digest_of(dataset, Kind::I64, place, bytes)?
        }
        Ok(TypeDescriptor::VarLenUnicode) => digest_of(dataset, Kind::Text, place, bytes)?,
        Ok(TypeDescriptor::FixedUnicode(length)) if length <= MOST_TEXT && shape.is_empty() => {
            let text = dataset.read_scalar::<FixedUnicode<MOST_TEXT>>();
            of_texts(&shape, &[text.at(place, "read the text")?])
        }
        Ok(TypeDescriptor::FixedAscii(length)) if length <= MOST_TEXT && shape.is_empty() => {
            let text = dataset.read_scalar::<FixedAscii<MOST_TEXT>>();
            of_texts(&shape, &[text.at(place, "read the text")?])
        }
        _ => return Ok(None),
    };
    let mut hasher = Hasher::new();
    hasher.update(values.as_bytes());
    add_attributes(&mut hasher, dataset, place)?;
    Ok(Some(hasher.finalize().to_hex().to_string()))
}

//! All that an HDF5 file holds, object by object: so a file on a disk is held against the same in memory.

use std::collections::BTreeMap;

use blake3::Hasher;
use hdf5::types::{FixedAscii, FixedUnicode, TypeDescriptor};
use hdf5_metno as hdf5;

use super::bounds;
use super::digest::{DatasetDigest, of_texts};
use super::error::StoreError;
use super::layout::Kind;
use super::place::{AtPlace, Place};
use super::seal::{add_attributes, members};
use super::stream;

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
///
/// # Errors
/// `Hdf5` if its groups cannot be listed.
pub(super) fn of(
    file: &hdf5::File,
    place: Place<'_>,
    bytes: u64,
) -> Result<BTreeMap<String, Held>, StoreError> {
    let mut found = BTreeMap::new();
    let root = file.group("/").at(place, "open the group")?;
    let mut seen = vec![root.loc_info().at(place, "look at the group")?.token];
    let mut groups = vec![("/".to_owned(), root)];
    while let Some((folder, group)) = groups.pop() {
        for name in members(&group, place)? {
            let path = format!("{folder}{name}");
            if let Ok(dataset) = group.dataset(&name) {
                found.insert(path, held(of_dataset(&dataset, place, bytes)));
            } else if let Ok(inner) = group.group(&name) {
                let token = inner.loc_info().at(place, "look at the group")?.token;
                if !seen.contains(&token) {
                    seen.push(token);
                    groups.push((format!("{path}/"), inner));
                }
            }
        }
        let mut hasher = Hasher::new();
        let attributes = add_attributes(&mut hasher, &group, place);
        let digest = attributes.map(|()| Some(hasher.finalize().to_hex().to_string()));
        found.insert(folder, held(digest));
    }
    Ok(found)
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
    bounds::check(dataset, place, bytes)?;
    let shape = dataset.get_shape().at(place, "read the shape")?;
    let numbers = |kind| DatasetDigest::new(kind, &shape);
    let dtype = dataset.dtype().and_then(|dtype| dtype.to_descriptor());
    let values = match dtype {
        Ok(TypeDescriptor::Float(_)) => {
            let mut digest = numbers(Kind::F64);
            stream::feed::<f64>(&mut digest, dataset, &shape, place)?;
            digest.finish()
        }
        Ok(TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_)) => {
            let mut digest = numbers(Kind::I64);
            stream::feed::<i64>(&mut digest, dataset, &shape, place)?;
            digest.finish()
        }
        Ok(TypeDescriptor::VarLenUnicode) => {
            of_texts(&shape, &stream::texts(dataset, &shape, place, bytes)?)
        }
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

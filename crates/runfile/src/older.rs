//! Groups that an older version wrote with other datasets than the present table has: sound, but of
//! no use to the present program.

use std::collections::BTreeMap;

use hdf5::types::{FloatSize, IntSize, TypeDescriptor, VarLenUnicode};
use hdf5_metno as hdf5;

use super::attribute::read_text;
use super::bounds;
use super::digest::{of_group, of_texts, of_values};
use super::error::StoreError;
use super::layout::{EnumSpec, Group, Kind};
use super::matrix;
use super::place::{AtPlace, Place};
use super::reader::Reader;
use super::record::StoredGroup;

/// Stands for any enumeration: digests do not depend on the members.
const ENUMERATION: Kind = Kind::Enum(&EnumSpec {
    name: "",
    members: &[],
});

impl Reader {
    /// Whether the datasets that a group has, known to the table or not, are those it was finished
    /// with.
    pub(super) fn is_whole_as_written(
        &self,
        group: Group,
        stored: &StoredGroup,
    ) -> Result<bool, StoreError> {
        let mut digests = BTreeMap::new();
        for object in self.objects_with_digest(group)? {
            let known = self.layout.find(&object.path);
            if !known.is_some_and(|spec| spec.volatile) {
                digests.insert(object.path, object.digest);
            }
        }
        let digests = digests
            .iter()
            .map(|(path, digest)| (path.as_str(), digest.as_str()));
        Ok(of_group(digests, stored.units) == stored.digest)
    }

    /// The values of such a group that do not fit their digests.
    pub(super) fn problems_as_written(&self, group: Group) -> Result<Vec<StoreError>, StoreError> {
        let mut problems = Vec::new();
        for object in self.objects_with_digest(group)? {
            let volume = self.volume(group)?;
            let place = Place::new(&volume.path, &object.path);
            let found = match &object.content {
                Content::Dataset(dataset) => bounds::check(dataset, place, volume.bytes)
                    .and_then(|()| digest_as_written(dataset, place)),
                Content::Matrix(group) => matrix::digest_of(group, place, volume.bytes),
            };
            let checked = found.and_then(|found| place.same_digest(object.digest.clone(), found));
            problems.extend(checked.err());
        }
        Ok(problems)
    }

    fn objects_with_digest(&self, group: Group) -> Result<Vec<Object>, StoreError> {
        let mut objects = Vec::new();
        for (path, dataset) in self.datasets_below(group)? {
            let place = Place::new(&self.volume(group)?.path, &path);
            if let Ok(digest) = read_text(&dataset, place, "digest") {
                let content = Content::Dataset(dataset);
                objects.push(Object {
                    path,
                    digest,
                    content,
                });
            } else if let Some(matrix) = path.strip_suffix("/indptr") {
                let group = self.volume(group)?.file.group(matrix);
                let group = group.at(place, "open the matrix")?;
                objects.push(Object {
                    digest: read_text(&group, place, "digest")?,
                    path: matrix.to_owned(),
                    content: Content::Matrix(group),
                });
            }
        }
        Ok(objects)
    }
}

/// A dataset or a matrix with the digest beside it.
struct Object {
    path: String,
    digest: String,
    content: Content,
}

enum Content {
    Dataset(hdf5::Dataset),
    Matrix(hdf5::Group),
}

/// The digest of a dataset of whatever type it has.
fn digest_as_written(dataset: &hdf5::Dataset, place: Place<'_>) -> Result<String, StoreError> {
    let shape = dataset.get_shape().at(place, "read the shape")?;
    let stored = dataset.dtype().and_then(|dtype| dtype.to_descriptor());
    let read = "read the values";
    Ok(match stored.at(place, "read the type")? {
        TypeDescriptor::Float(FloatSize::U8) => {
            let values = dataset.read_raw::<f64>().at(place, read)?;
            of_values(Kind::F64, &shape, &values)
        }
        TypeDescriptor::Float(FloatSize::U4) => {
            let values = dataset.read_raw::<f32>().at(place, read)?;
            of_values(Kind::F32, &shape, &values)
        }
        TypeDescriptor::Integer(IntSize::U8) => {
            let values = dataset.read_raw::<i64>().at(place, read)?;
            of_values(Kind::I64, &shape, &values)
        }
        TypeDescriptor::Unsigned(IntSize::U1) => {
            let values = dataset.read_raw::<u8>().at(place, read)?;
            of_values(Kind::U8, &shape, &values)
        }
        TypeDescriptor::Enum(_) => {
            let codes = dataset.read_raw::<u8>().at(place, read)?;
            of_values(ENUMERATION, &shape, &codes)
        }
        TypeDescriptor::VarLenUnicode => {
            let texts = dataset.read_raw::<VarLenUnicode>().at(place, read)?;
            let texts: Vec<&str> = texts.iter().map(VarLenUnicode::as_str).collect();
            of_texts(&shape, &texts)
        }
        other => return Err(place.mismatch("a type of ours", format!("type {other}"))),
    })
}

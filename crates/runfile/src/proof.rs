//! Proof that a file just written holds what it was to hold: opened anew, every value read and held against its digest.

use std::collections::BTreeMap;
use std::path::Path;

use hdf5_metno as hdf5;

use super::attribute::read_text;
use super::bounds;
use super::digest::{DatasetDigest, of_group, of_texts};
use super::element::StoredElement;
use super::error::StoreError;
use super::header;
use super::heaps;
use super::layout::{DatasetSpec, Group, Kind};
use super::matrix::shape_of;
use super::place::{AtPlace, Place};
use super::reader::Reader;
use super::record;
use super::seal::Seals;
use super::stream;
use super::table::Layout;
use super::volume::{Stamp, Volume};

/// What a new state is held against.
#[derive(Debug)]
pub(super) struct Proof<'a> {
    pub(super) layout: &'a Layout,
    /// Digests of the groups that were written.
    pub(super) finished: &'a BTreeMap<Group, String>,
    /// Where the other groups were copied from.
    pub(super) previous: Option<&'a Reader>,
}

impl Proof<'_> {
    /// Reads the groups that a file holds itself back, and all its attributes.
    ///
    /// # Errors
    /// `Unproven` if anything is not what was written; `target` is the file that it names.
    pub(super) fn of(
        &self,
        written: &Path,
        filetype: &'static str,
        seals: &Seals,
        target: &Path,
    ) -> Result<(), StoreError> {
        let stamp = Stamp::of(written);
        let opened = header::open_written(written);
        let volume =
            opened.and_then(|file| Volume::of(file, stamp, written, self.layout, filetype));
        let proven = volume.and_then(|volume| {
            let mut groups = seals.groups();
            groups.try_for_each(|group| self.of_group(&volume, group))?;
            seals.require(&volume, self.previous)
        });
        proven.map_err(|error| StoreError::Unproven {
            file: target.into(),
            reason: error.to_string(),
        })?;
        heaps::trust(written);
        Ok(())
    }

    fn of_group(&self, volume: &Volume, group: Group) -> Result<(), StoreError> {
        let place = Place::new(&volume.path, group.name());
        let mut digests = Vec::new();
        for spec in self.layout.of_group(group) {
            if volume.holds(spec.path) {
                let digest = self.of_dataset(volume, spec)?;
                digests.extend((!spec.volatile).then_some((spec.path, digest)));
            }
        }
        let object = volume
            .file
            .group(group.name())
            .at(place, "open the group")?;
        if let Some(finished) = self.finished.get(&group) {
            let stored = record::read(&object, place)?;
            let digests = digests.iter().map(|(path, d)| (*path, d.as_str()));
            place.same_digest(finished.clone(), of_group(digests, stored.units))?;
            return place.same_digest(finished.clone(), stored.digest);
        }
        Ok(())
    }

    /// The digest of a dataset as the disk has it: the one beside it or, in a copy, that of the original, sound or not.
    fn of_dataset(&self, volume: &Volume, spec: &DatasetSpec) -> Result<String, StoreError> {
        let place = Place::new(&volume.path, spec.path);
        let (expected, found) = digest_on_disk(volume, spec)?;
        if expected != found
            && let Some(previous) = self.previous
            && !self.finished.contains_key(&spec.group)
        {
            let (_, original) = digest_on_disk(previous.volume(spec.group)?, spec)?;
            place.same_digest(original, found.clone())?;
            return Ok(found);
        }
        place.same_digest(expected, found.clone())?;
        Ok(found)
    }
}

/// The digest that stands beside a dataset, and that of its values.
fn digest_on_disk(volume: &Volume, spec: &DatasetSpec) -> Result<(String, String), StoreError> {
    let place = Place::new(&volume.path, spec.path);
    if spec.kind.is_matrix() {
        let group = volume.file.group(spec.path).at(place, "open the matrix")?;
        let part = |name| group.dataset(name).at(place, "open a part of the matrix");
        let data = part("data")?;
        let mut digest = DatasetDigest::new(spec.kind, &shape_of(&group, place)?);
        digest.size(data.size());
        feed::<i64>(&mut digest, &part("indptr")?, place, volume)?;
        feed::<i64>(&mut digest, &part("indices")?, place, volume)?;
        feed::<f64>(&mut digest, &data, place, volume)?;
        return Ok((read_text(&group, place, "digest")?, digest.finish()));
    }
    let dataset = volume.file.dataset(spec.path);
    let dataset = dataset.at(place, "open the dataset")?;
    let beside = read_text(&dataset, place, "digest")?;
    let shape = dataset.get_shape().at(place, "read the shape")?;
    let mut digest = DatasetDigest::new(spec.kind, &shape);
    match spec.kind {
        Kind::F64 => feed::<f64>(&mut digest, &dataset, place, volume)?,
        Kind::F32 => feed::<f32>(&mut digest, &dataset, place, volume)?,
        Kind::I64 => feed::<i64>(&mut digest, &dataset, place, volume)?,
        Kind::U8 | Kind::Enum(_) => feed::<u8>(&mut digest, &dataset, place, volume)?,
        Kind::Text | Kind::CscMatrix | Kind::CsrMatrix => {
            let texts = stream::texts(&dataset, &shape, place, volume.bytes)?;
            return Ok((beside, of_texts(&shape, &texts)));
        }
    }
    Ok((beside, digest.finish()))
}

/// Adds the values of a dataset that is no longer than its file to a digest.
fn feed<T: StoredElement>(
    digest: &mut DatasetDigest,
    dataset: &hdf5::Dataset,
    place: Place<'_>,
    volume: &Volume,
) -> Result<(), StoreError> {
    bounds::check(dataset, place, volume.bytes)?;
    let shape = dataset.get_shape().at(place, "read the shape")?;
    stream::feed::<T>(digest, dataset, &shape, place)
}

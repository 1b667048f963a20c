//! Looking at groups as a whole: records, sizes on disk, and the check of a group against the
//! table.

use std::collections::BTreeSet;
use std::fmt::Debug;

use hdf5_metno as hdf5;

use super::attribute::{read_text, require_ascii, require_numbers};
use super::digest::of_group;
use super::dimension::is_scale;
use super::element::StoredElement;
use super::error::StoreError;
use super::layout::{DatasetSpec, Group, Presence};
use super::place::{AtPlace, Place};
use super::reader::Reader;
use super::record::{self, StoredGroup};

impl Reader {
    /// How a group was run, or `None` if the file does not hold it.
    ///
    /// # Errors
    /// `Mismatch` if the group lacks an attribute or is not complete; `Linked` if the group is kept
    /// in a file of its own that cannot be used.
    pub fn group_record(&self, group: Group) -> Result<Option<StoredGroup>, StoreError> {
        match self.object(group)? {
            Some(object) => record::read(&object, self.group_place(group)).map(Some),
            None => Ok(None),
        }
    }

    /// As [`Reader::group_record`], but only for a group whose set of datasets is the one it was
    /// finished with.
    ///
    /// Values are not read: [`Reader::read`] checks them against the digest of their dataset.
    ///
    /// # Errors
    /// As for [`Reader::group_record`]; `Missing` for a required dataset, `ForeignLink` for a link
    /// in the place of one, `Altered` if the digests of the datasets are not those the group was
    /// finished with; `Older` if it is sound, but an older version wrote it with other datasets.
    pub fn whole_group(&self, group: Group) -> Result<Option<StoredGroup>, StoreError> {
        let Some(stored) = self.group_record(group)? else {
            return Ok(None);
        };
        match self.refuse_altered(group, &stored) {
            Ok(()) => Ok(Some(stored)),
            Err(error) => {
                let is_older = self.is_whole_as_written(group, &stored).unwrap_or(false)
                    && self.refuse_unsealed(group).is_ok();
                if is_older {
                    let file = self.path().into();
                    return Err(StoreError::Older { file, group });
                }
                Err(error)
            }
        }
    }

    /// Refuses a group whose datasets of the table are not those it was finished with.
    fn refuse_altered(&self, group: Group, stored: &StoredGroup) -> Result<(), StoreError> {
        let mut held = Vec::new();
        for spec in self.layout.of_group(group) {
            if self.volume_of_object(group, spec.path)?.holds(spec.path) {
                held.push(spec);
            } else if spec.presence == Presence::Required {
                return Err(self.missing(spec.path, group));
            }
        }
        let mut digests = Vec::new();
        for spec in held.into_iter().filter(|spec| !spec.volatile) {
            digests.push((spec.path, self.attribute(spec, "digest")?));
        }
        let digest = of_group(
            digests
                .iter()
                .map(|(path, digest)| (*path, digest.as_str())),
            stored.units,
        );
        self.group_place(group)
            .same_digest(stored.digest.clone(), digest)
    }

    /// The groups whose record or set of datasets is not what was written.
    #[must_use]
    pub fn damaged_groups(&self) -> Vec<Group> {
        let is_damaged = |group: &Group| match self.whole_group(*group) {
            Ok(_) | Err(StoreError::Linked { .. } | StoreError::Older { .. }) => false,
            Err(_) => true,
        };
        self.layout.groups().filter(is_damaged).collect()
    }

    /// Bytes the datasets of a group take on disk; 0 if the file does not hold the group.
    pub fn group_bytes(&self, group: Group) -> Result<u64, StoreError> {
        let datasets = self.datasets_below(group)?;
        let bytes = |(_, dataset): &(String, hdf5::Dataset)| dataset.storage_size();
        Ok(datasets.iter().map(bytes).sum())
    }

    /// Checks the set of datasets of a group against the table and against the digest of the group.
    ///
    /// # Errors
    /// As for [`Reader::whole_group`]; `Missing` for the group, `Mismatch` for a dataset the table
    /// does not know.
    pub fn check_group(&self, group: Group) -> Result<StoredGroup, StoreError> {
        let stored = self.whole_group(group)?;
        self.refuse_unknown(group)?;
        stored.ok_or_else(|| self.missing(group.name(), group))
    }

    /// Refuses an attribute of a group that is not what
    /// [`super::GroupWriter::write_ascii_attribute`] wrote.
    ///
    /// # Errors
    /// `Missing` for the group, `Mismatch` for the attribute.
    pub fn require_ascii_attribute<const N: usize>(
        &self,
        group: Group,
        name: &str,
        expected: &[u8; N],
    ) -> Result<(), StoreError> {
        let object = self.present(group)?;
        require_ascii(&object, self.group_place(group), name, expected)
    }

    /// Refuses an attribute of a group that is not what
    /// [`super::GroupWriter::write_number_attribute`] wrote; errors as for
    /// [`Reader::require_ascii_attribute`].
    pub fn require_number_attribute<T: StoredElement + PartialEq + Debug>(
        &self,
        group: Group,
        name: &str,
        expected: &[T],
    ) -> Result<(), StoreError> {
        let object = self.present(group)?;
        require_numbers(&object, self.group_place(group), name, expected)
    }

    fn present(&self, group: Group) -> Result<hdf5::Group, StoreError> {
        self.object(group)?
            .ok_or_else(|| self.missing(group.name(), group))
    }

    /// A text stored beside a dataset, such as its digest.
    pub(super) fn attribute(&self, spec: &DatasetSpec, name: &str) -> Result<String, StoreError> {
        let place = self.place(spec);
        let file = &self.volume(spec.group)?.file;
        if spec.kind.is_matrix() {
            read_text(
                &*file.group(spec.path).at(place, "open the matrix")?,
                place,
                name,
            )
        } else {
            read_text(
                &**file.dataset(spec.path).at(place, "open the dataset")?,
                place,
                name,
            )
        }
    }

    pub(super) fn refuse_unknown(&self, group: Group) -> Result<(), StoreError> {
        let mut known = BTreeSet::new();
        for spec in self.layout.of_group(group) {
            if spec.kind.is_matrix() {
                known.extend(
                    ["data", "indices", "indptr"].map(|part| format!("{}/{part}", spec.path)),
                );
            } else {
                known.insert(spec.path.into());
            }
        }
        match self
            .datasets_below(group)?
            .into_iter()
            .find(|(name, _)| !known.contains(name))
        {
            Some((name, _)) => Err(self
                .group_place(group)
                .beside(&name)
                .mismatch("only datasets of the table", "another one")),
            None => Ok(()),
        }
    }

    /// All datasets of a group with their paths: HDF5 would search the whole file for each path.
    pub(super) fn datasets_below(
        &self,
        group: Group,
    ) -> Result<Vec<(String, hdf5::Dataset)>, StoreError> {
        let place = self.group_place(group);
        let volume = self.volume(group)?;
        if let Some(link) = volume.link_below(group) {
            return Err(StoreError::ForeignLink {
                file: volume.path.clone(),
                link: link.into(),
            });
        }
        let mut datasets = Vec::new();
        let mut groups: Vec<_> = self.object(group)?.into_iter().collect();
        let mut seen = BTreeSet::new();
        while let Some(group) = groups.pop() {
            let path = group.name();
            if seen.insert(path.clone()) {
                for name in group.member_names().at(place, "list the datasets")? {
                    let kind = group.loc_type_by_name(&name);
                    if kind.at(place, "look at a member")? == hdf5::LocationType::Dataset {
                        let dataset = group.dataset(&name).at(place, "open the dataset")?;
                        if !is_scale(&dataset) {
                            datasets.push((format!("{path}/{name}"), dataset));
                        }
                    }
                }
                groups.extend(group.groups().at(place, "list the groups")?);
            }
        }
        Ok(datasets)
    }

    fn object(&self, group: Group) -> Result<Option<hdf5::Group>, StoreError> {
        let volume = self.volume(group)?;
        if !volume.holds(&format!("/{group}")) {
            return Ok(None);
        }
        volume
            .file
            .group(group.name())
            .map(Some)
            .at(self.group_place(group), "open the group")
    }

    fn group_place(&self, group: Group) -> Place<'_> {
        Place {
            file: self
                .volume(group)
                .map_or(self.path(), |volume| &volume.path),
            dataset: group.name(),
        }
    }
}

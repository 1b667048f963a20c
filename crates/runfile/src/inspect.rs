//! Looking at groups as a whole: records, sizes on disk, and the check of every dataset against the table and its digest.

use std::collections::BTreeMap;
use std::fmt::Debug;

use hdf5::LocationType;
use hdf5_metno as hdf5;
use units::Units;

use crate::attribute::{read_text, require_ascii, require_numbers};
use crate::dataset::digest_of;
use crate::digest::of_group;
use crate::dimension::is_scale;
use crate::element::StoredElement;
use crate::error::{AtPlace, Place, StoreError};
use crate::header;
use crate::header::StoredGroup;
use crate::layout::{DatasetSpec, Group, Presence};
use crate::matrix::PARTS;
use crate::reader::Reader;
use crate::volume::{members, walk};

impl Reader {
    /// How a group was run, or `None` if the file does not hold it.
    ///
    /// # Errors
    /// `Mismatch` if the group lacks an attribute or is not complete; `Linked` if the group is kept
    /// in a file of its own that cannot be used.
    pub fn group_record(&self, group: Group) -> Result<Option<StoredGroup>, StoreError> {
        match self.object(group)? {
            Some(object) => header::read(&object, self.group_place(group)).map(Some),
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
    /// finished with.
    pub fn whole_group(&self, group: Group) -> Result<Option<StoredGroup>, StoreError> {
        let Some(stored) = self.group_record(group)? else {
            return Ok(None);
        };
        self.refuse_altered(group, &stored)?;
        Ok(Some(stored))
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
        let mut digests = BTreeMap::new();
        for spec in held.into_iter().filter(|spec| !spec.volatile) {
            digests.insert(spec.path, self.attribute(spec, "digest")?);
        }
        let digest = of_group(&digests, stored.units);
        self.group_place(group)
            .same_digest(stored.digest.clone(), digest)
    }

    /// The groups whose record or set of datasets is not what was written.
    #[must_use]
    pub fn damaged_groups(&self) -> Vec<Group> {
        let is_damaged = |group: &Group| match self.whole_group(*group) {
            Ok(_) | Err(StoreError::Linked { .. }) => false,
            Err(_) => true,
        };
        self.layout.groups().filter(is_damaged).collect()
    }

    /// Bytes the datasets of a group take on disk; 0 if the file does not hold the group.
    pub fn group_bytes(&self, group: Group) -> Result<u64, StoreError> {
        let datasets = self.datasets_below(group)?;
        Ok(datasets.iter().map(|(_, it)| it.storage_size()).sum())
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
    /// [`crate::GroupWriter::write_ascii_attribute`] wrote.
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
    /// [`crate::GroupWriter::write_number_attribute`] wrote; errors as for
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
    fn attribute(&self, spec: &DatasetSpec, name: &str) -> Result<String, StoreError> {
        let place = self.place(spec);
        let file = &self.volume(spec.group)?.file;
        if spec.kind.is_matrix() {
            let group = file.group(spec.path).at(place, "open the matrix")?;
            read_text(&group, place, name)
        } else {
            let dataset = file.dataset(spec.path).at(place, "open the dataset")?;
            read_text(&dataset, place, name)
        }
    }

    /// Refuses datasets that the table does not have.
    fn refuse_unknown(&self, group: Group) -> Result<(), StoreError> {
        for (path, _) in self.datasets_below(group)? {
            let is_part = |spec: &DatasetSpec| {
                let mut parts = PARTS.iter();
                spec.kind.is_matrix() && parts.any(|part| path == format!("{}/{part}", spec.path))
            };
            let is_it = |spec: &DatasetSpec| spec.path == path && !spec.kind.is_matrix();
            let mut known = self.layout.of_group(group);
            if !known.any(|spec| is_it(spec) || is_part(spec)) {
                let place = self.group_place(group).beside(&path);
                return Err(place.mismatch("only datasets of the table", "another one"));
            }
        }
        Ok(())
    }

    /// All datasets of a group with their paths: HDF5 would search the whole file for each path.
    fn datasets_below(&self, group: Group) -> Result<Vec<(String, hdf5::Dataset)>, StoreError> {
        let place = self.group_place(group);
        let volume = self.volume(group)?;
        if let Some(link) = volume.link_below(group) {
            return Err(StoreError::ForeignLink {
                file: volume.path.clone(),
                link: link.into(),
            });
        }
        let Some(object) = self.object(group)? else {
            return Ok(Vec::new());
        };
        let members = members(&object, &format!("/{group}"));
        let mut datasets = Vec::new();
        for member in walk(members.at(place, "list the datasets")?) {
            if member.kind.at(place, "look at a member")? == Some(LocationType::Dataset) {
                let dataset = member.parent.dataset(&member.name);
                let dataset = dataset.at(place, "open the dataset")?;
                if !is_scale(&dataset) {
                    datasets.push((member.path, dataset));
                }
            }
        }
        Ok(datasets)
    }

    fn object(&self, group: Group) -> Result<Option<hdf5::Group>, StoreError> {
        let volume = self.volume(group)?;
        if !volume.holds(&format!("/{group}")) {
            return Ok(None);
        }
        let object = volume.file.group(group.name());
        object
            .map(Some)
            .at(self.group_place(group), "open the group")
    }

    fn group_place(&self, group: Group) -> Place<'_> {
        let file = self.volume(group);
        let file = file.map_or(self.path(), |volume| &volume.path);
        Place::new(file, group.name())
    }

    /// Everything that is wrong with a file; empty for one as it was written.
    ///
    /// Reads every value. Groups that are not there, or not finished, are not wrong; whether they
    /// are fresh is another question.
    #[must_use]
    pub fn problems(&self) -> Vec<StoreError> {
        let groups = self.layout.groups();
        let mut problems: Vec<StoreError> = groups
            .flat_map(|group| self.group_problems(group))
            .collect();
        problems.extend(self.root_problems());
        problems
    }

    /// Everything that is wrong with one group; as [`Self::problems`]. What this process has found sound is not read again before
    /// its file changes.
    #[must_use]
    pub fn group_problems(&self, group: Group) -> Vec<StoreError> {
        let file = self.volume(group).ok().filter(|file| file.is_unchanged());
        if file.is_some_and(|file| file.is_sound(group)) {
            return Vec::new();
        }
        let problems = self.problems_read(group);
        if let Some(file) = file.filter(|_| problems.is_empty()) {
            file.note_sound(group);
        }
        problems
    }

    fn problems_read(&self, group: Group) -> Vec<StoreError> {
        let mut problems = Vec::new();
        match self.whole_group(group) {
            Ok(None) => return problems,
            Ok(Some(stored)) => {
                let held = self.layout.of_group(group).filter(|spec| self.holds(spec));
                let wrong = held.filter_map(|spec| self.check_unit(spec, stored.units).err());
                problems.extend(wrong);
            }
            Err(error) => problems.push(error),
        }
        problems.extend(self.refuse_unknown(group).err());
        let held = self.layout.of_group(group).filter(|spec| self.holds(spec));
        problems.extend(held.filter_map(|spec| self.check_values(spec).err()));
        // A seal breaks with what is named already.
        if problems.is_empty() {
            problems.extend(self.refuse_unsealed(group).err());
        }
        problems
    }

    /// Refuses a word for the unit of a dataset that is not that of the units its group names.
    fn check_unit(&self, spec: &DatasetSpec, units: Units) -> Result<(), StoreError> {
        let found = self.attribute(spec, "units")?;
        let expected = units.word(spec.dimension);
        if found == expected {
            return Ok(());
        }
        let [expected, found] = [expected, found].map(|word| format!("units = \"{word}\""));
        Err(self.place(spec).mismatch(expected, found))
    }

    /// Compares the values of a dataset with its digest.
    fn check_values(&self, spec: &'static DatasetSpec) -> Result<(), StoreError> {
        if spec.kind.is_matrix() {
            return self.read_matrix(spec.path).map(drop);
        }
        let (place, dataset) = (self.place(spec), self.dataset(spec)?);
        let expected = read_text(&dataset, place, "digest")?;
        let bytes = self.volume(spec.group)?.bytes;
        place.same_digest(expected, digest_of(&dataset, spec.kind, place, bytes)?)
    }
}

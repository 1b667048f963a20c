//! Looking at stages as a whole: records, sizes on disk, and the check of a stage against the table.

use std::collections::BTreeSet;

use hdf5_metno as hdf5;

use super::attribute::read_text;
use super::digest::of_stage;
use super::error::StoreError;
use super::layout::{DatasetSpec, Presence, Stage};
use super::place::{AtPlace, Place};
use super::reader::Reader;
use super::record::{self, StoredStage};

impl Reader {
    /// How a stage was run, or `None` if the file does not hold it.
    ///
    /// # Errors
    /// `Mismatch` if the group lacks an attribute or is not complete; `Linked` if the stage is kept in a file of its
    /// own that cannot be used.
    pub fn stage_record(&self, stage: Stage) -> Result<Option<StoredStage>, StoreError> {
        match self.group(stage)? {
            Some(group) => record::read(&group, self.stage_place(stage)).map(Some),
            None => Ok(None),
        }
    }

    /// As [`Reader::stage_record`], but only for a stage whose set of datasets is the one it was finished with.
    ///
    /// Values are not read: [`Reader::read`] checks them against the digest of their dataset.
    ///
    /// # Errors
    /// As for [`Reader::stage_record`]; `Missing` for a required dataset, `ForeignLink` for a link in the place of
    /// one, `Altered` if the digests of the datasets are not those the stage was finished with; `Older` if it is
    /// sound, but an older version wrote it with other datasets.
    pub fn whole_stage(&self, stage: Stage) -> Result<Option<StoredStage>, StoreError> {
        let Some(stored) = self.stage_record(stage)? else {
            return Ok(None);
        };
        match self.refuse_altered(stage, &stored) {
            Ok(()) => Ok(Some(stored)),
            Err(_) if self.is_whole_as_written(stage, &stored).unwrap_or(false) => {
                Err(StoreError::Older {
                    file: self.path().into(),
                    stage,
                })
            }
            Err(error) => Err(error),
        }
    }

    /// Refuses a stage whose datasets of the table are not those it was finished with.
    fn refuse_altered(&self, stage: Stage, stored: &StoredStage) -> Result<(), StoreError> {
        let mut held = Vec::new();
        for spec in self.layout.of_stage(stage) {
            if self.volume_of_object(stage, spec.path)?.holds(spec.path) {
                held.push(spec);
            } else if spec.presence == Presence::Required {
                return Err(self.missing(spec.path, stage));
            }
        }
        let mut digests = Vec::new();
        for spec in held.into_iter().filter(|spec| !spec.volatile) {
            digests.push((spec.path, self.attribute(spec, "digest")?));
        }
        let digest = of_stage(
            digests
                .iter()
                .map(|(path, digest)| (*path, digest.as_str())),
            stored.units,
        );
        self.stage_place(stage)
            .same_digest(stored.digest.clone(), digest)
    }

    /// The stages whose record or set of datasets is not what was written.
    pub fn damaged_stages(&self) -> Vec<Stage> {
        let is_damaged = |stage: &Stage| match self.whole_stage(*stage) {
            Ok(_) | Err(StoreError::Linked { .. } | StoreError::Older { .. }) => false,
            Err(_) => true,
        };
        Stage::ALL.into_iter().filter(is_damaged).collect()
    }

    /// Bytes the datasets of a stage take on disk; 0 if the file does not hold the stage.
    pub fn stage_bytes(&self, stage: Stage) -> Result<u64, StoreError> {
        let datasets = self.datasets_below(stage)?;
        Ok(datasets.iter().map(|dataset| dataset.storage_size()).sum())
    }

    /// Checks the set of datasets of a stage against the table and against the digest of the stage.
    ///
    /// # Errors
    /// As for [`Reader::whole_stage`]; `Missing` for the stage, `Mismatch` for a dataset the table does not know.
    pub fn check_stage(&self, stage: Stage) -> Result<StoredStage, StoreError> {
        let stored = self.whole_stage(stage)?;
        self.refuse_unknown(stage)?;
        stored.ok_or_else(|| self.missing(stage.group(), stage))
    }

    /// A text stored beside a dataset, such as its digest.
    pub(super) fn attribute(&self, spec: &DatasetSpec, name: &str) -> Result<String, StoreError> {
        let place = self.place(spec);
        let file = &self.volume(spec.stage)?.file;
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

    pub(super) fn refuse_unknown(&self, stage: Stage) -> Result<(), StoreError> {
        let mut known = BTreeSet::new();
        for spec in self.layout.of_stage(stage) {
            if spec.kind.is_matrix() {
                known.extend(
                    ["data", "indices", "indptr"].map(|part| format!("{}/{part}", spec.path)),
                );
            } else {
                known.insert(spec.path.into());
            }
        }
        match self
            .datasets_below(stage)?
            .iter()
            .map(|dataset| dataset.name())
            .find(|name| !known.contains(name))
        {
            Some(name) => Err(Place {
                dataset: &name,
                ..self.stage_place(stage)
            }
            .mismatch("only datasets of the table", "another one")),
            None => Ok(()),
        }
    }

    pub(super) fn datasets_below(&self, stage: Stage) -> Result<Vec<hdf5::Dataset>, StoreError> {
        let place = self.stage_place(stage);
        let volume = self.volume(stage)?;
        if let Some(link) = volume.link_below(stage) {
            return Err(StoreError::ForeignLink {
                file: volume.path.clone(),
                link: link.into(),
            });
        }
        let mut datasets = Vec::new();
        let mut groups: Vec<_> = self.group(stage)?.into_iter().collect();
        let mut seen = BTreeSet::new();
        while let Some(group) = groups.pop() {
            if seen.insert(group.name()) {
                datasets.extend(group.datasets().at(place, "list the datasets")?);
                groups.extend(group.groups().at(place, "list the groups")?);
            }
        }
        Ok(datasets)
    }

    fn group(&self, stage: Stage) -> Result<Option<hdf5::Group>, StoreError> {
        let volume = self.volume(stage)?;
        if !volume.holds(&format!("/{stage}")) {
            return Ok(None);
        }
        volume
            .file
            .group(stage.group())
            .map(Some)
            .at(self.stage_place(stage), "open the group")
    }

    fn stage_place(&self, stage: Stage) -> Place<'_> {
        Place {
            file: self
                .volume(stage)
                .map_or(self.path(), |volume| &volume.path),
            dataset: stage.group(),
        }
    }
}

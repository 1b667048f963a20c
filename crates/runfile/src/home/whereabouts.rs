//! In which file a reader finds what: the run file, or the one beside it that holds the group.

use std::path::Path;

use crate::error::StoreError;
use crate::layout::{DatasetSpec, Group};
use crate::place::Place;
use crate::reader::Reader;
use crate::volume::Volume;

impl Reader {
    /// The name and the length of the file beside the run file that holds a group, if one does.
    #[must_use]
    pub fn linked_file(&self, group: Group) -> Option<(String, u64)> {
        let linked = self.linked.get(&group)?;
        let volume = linked.volume.as_ref().ok()?;
        Some((linked.name.as_ref()?.to_string(), volume.bytes))
    }

    /// The file that holds a group: the run file, or the one beside it.
    pub(crate) fn volume(&self, group: Group) -> Result<&Volume, StoreError> {
        match self.linked.get(&group).map(|linked| &linked.volume) {
            None => Ok(&self.home),
            Some(Ok(volume)) => Ok(volume),
            Some(Err(problem)) => Err(StoreError::Linked {
                file: self.home.path.clone(),
                group,
                problem: problem.clone(),
            }),
        }
    }

    /// The path of the file that holds a dataset.
    pub(crate) fn file_of(&self, path: &str) -> &Path {
        let spec = self.layout.find(path);
        let volume = spec.and_then(|spec| self.volume(spec.group).ok());
        &volume.unwrap_or(&self.home).path
    }

    pub(crate) fn place<'a>(&'a self, spec: &DatasetSpec) -> Place<'a> {
        Place::new(self.file_of(spec.path), spec.path)
    }

    /// Whether the dataset itself, not a link to another place, is there.
    pub(crate) fn holds(&self, spec: &DatasetSpec) -> bool {
        self.volume(spec.group)
            .is_ok_and(|volume| volume.holds(spec.path))
    }

    /// The file that holds a group, unless a link stands on the way to one of its objects.
    pub(crate) fn volume_of_object(&self, group: Group, path: &str) -> Result<&Volume, StoreError> {
        let volume = self.volume(group)?;
        match volume.link_on_the_way(path) {
            None => Ok(volume),
            Some(link) => Err(StoreError::ForeignLink {
                file: volume.path.clone(),
                link: link.into(),
            }),
        }
    }

    pub(crate) fn missing(&self, dataset: &str, group: Group) -> StoreError {
        StoreError::Missing {
            file: self.home.path.clone(),
            dataset: dataset.into(),
            group,
        }
    }
}

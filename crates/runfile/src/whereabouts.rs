//! In which file a reader finds what: the run file, or the one beside it that holds the stage.

use std::path::Path;

use super::error::StoreError;
use super::layout::{DatasetSpec, Stage};
use super::place::Place;
use super::reader::Reader;
use super::volume::Volume;

impl Reader {
    /// The name and the length of the file beside the run file that holds a stage, if one does.
    pub fn linked_file(&self, stage: Stage) -> Option<(String, u64)> {
        let linked = self.linked.get(&stage)?;
        let volume = linked.volume.as_ref().ok()?;
        Some((linked.name.as_ref()?.to_string(), volume.bytes))
    }

    /// The file that holds a stage: the run file, or the one beside it.
    pub(super) fn volume(&self, stage: Stage) -> Result<&Volume, StoreError> {
        match self.linked.get(&stage).map(|linked| &linked.volume) {
            None => Ok(&self.home),
            Some(Ok(volume)) => Ok(volume),
            Some(Err(problem)) => Err(StoreError::Linked {
                file: self.home.path.clone(),
                stage,
                problem: problem.clone(),
            }),
        }
    }

    /// The path of the file that holds a dataset.
    pub(super) fn file_of(&self, path: &str) -> &Path {
        let spec = self.layout.find(path);
        let volume = spec.and_then(|spec| self.volume(spec.stage).ok());
        &volume.unwrap_or(&self.home).path
    }

    pub(super) fn place<'a>(&'a self, spec: &DatasetSpec) -> Place<'a> {
        Place {
            file: self.file_of(spec.path),
            dataset: spec.path,
        }
    }

    /// Whether the dataset itself, not a link to another place, is there.
    pub(super) fn holds(&self, spec: &DatasetSpec) -> bool {
        self.volume(spec.stage)
            .is_ok_and(|volume| volume.holds(spec.path))
    }

    /// The file that holds a stage, unless a link stands on the way to one of its objects.
    pub(super) fn volume_of_object(&self, stage: Stage, path: &str) -> Result<&Volume, StoreError> {
        let volume = self.volume(stage)?;
        match volume.link_on_the_way(path) {
            None => Ok(volume),
            Some(link) => Err(StoreError::ForeignLink {
                file: volume.path.clone(),
                link: link.into(),
            }),
        }
    }

    pub(super) fn missing(&self, dataset: &str, stage: Stage) -> StoreError {
        StoreError::Missing {
            file: self.home.path.clone(),
            dataset: dataset.into(),
            stage,
        }
    }
}

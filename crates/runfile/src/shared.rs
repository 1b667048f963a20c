//! Stages in files that several run files of a folder share, found by what they were computed from.

use std::fs;
use std::path::Path;

use super::layout::Stage;
use super::linked::{self, LinkedName};
use super::lock::RunFile;
use super::place::Place;
use super::record::{self, StoredStage};
use super::table::Layout;
use super::volume::Volume;

/// A stage in a file `STAGE-DIGEST.h5` that no run file owns.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedStage {
    pub(super) stage: Stage,
    pub(super) name: LinkedName,
    stored: StoredStage,
}

impl SharedStage {
    /// Looks beside a run file for a stage that was computed from the same input; files that cannot be used are
    /// passed over.
    #[must_use]
    pub fn find(run_file: &RunFile, stage: Stage, input_digest: &str) -> Option<Self> {
        let entries = fs::read_dir(&run_file.folder).ok()?;
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let mut names: Vec<LinkedName> = names
            .filter_map(|name| LinkedName::parse(&name, stage))
            .filter(|name| name.is_shared(stage))
            .collect();
        names.sort_by_key(ToString::to_string);
        names.into_iter().find_map(|name| {
            let path = run_file.folder.join(name.to_string());
            let stored = read(&path, &run_file.layout, stage, &name)?;
            (stored.record.input_digest == input_digest).then_some(Self {
                stage,
                name,
                stored,
            })
        })
    }

    /// How the stage was run, and its digest.
    #[must_use]
    pub fn stored(&self) -> &StoredStage {
        &self.stored
    }
}

fn read(path: &Path, layout: &Layout, stage: Stage, name: &LinkedName) -> Option<StoredStage> {
    let volume = linked::open_named(path, layout, stage, name).ok()?;
    let place = Place {
        file: path,
        dataset: stage.group(),
    };
    let Volume { file, .. } = &volume;
    record::read(&*file.group(stage.group()).ok()?, place).ok()
}

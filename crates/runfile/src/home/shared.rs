//! Groups in files that several run files of a folder share, found by what they were computed from.

use std::fs;
use std::path::Path;

use super::linked::{self, LinkedName};
use crate::layout::Group;
use crate::lock::RunFile;
use crate::place::Place;
use crate::record::{self, StoredGroup};
use crate::table::Layout;
use crate::volume::Volume;

/// A group in a file `STAGE-DIGEST.h5`.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedGroup {
    pub(crate) group: Group,
    pub(crate) name: LinkedName,
    stored: StoredGroup,
}

impl SharedGroup {
    /// Looks beside a run file for a group that was computed from the same input; files that cannot
    /// be used are passed over.
    #[must_use]
    pub fn find(run_file: &RunFile, group: Group, input_digest: &str) -> Option<Self> {
        let entries = fs::read_dir(&run_file.folder).ok()?;
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let mut names: Vec<LinkedName> = names
            .filter_map(|name| LinkedName::parse(&name, group))
            .filter(|name| name.is_shared(group))
            .collect();
        names.sort_by_key(ToString::to_string);
        names.into_iter().find_map(|name| {
            let path = run_file.folder.join(name.to_string());
            let stored = read(&path, &run_file.layout, group, &name)?;
            (stored.record.input_digest == input_digest).then_some(Self {
                group,
                name,
                stored,
            })
        })
    }

    /// How the group was run, and its digest.
    #[must_use]
    pub fn stored(&self) -> &StoredGroup {
        &self.stored
    }
}

fn read(path: &Path, layout: &Layout, group: Group, name: &LinkedName) -> Option<StoredGroup> {
    let volume = linked::open_named(path, layout, group, name).ok()?;
    let place = Place::new(path, group.name());
    let Volume { file, .. } = &volume;
    record::read(&*file.group(group.name()).ok()?, place).ok()
}

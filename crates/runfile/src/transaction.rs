//! A change of a run file: written beside it, then put in its place in one step, or not at all.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use hdf5_metno::sync::sync as undisturbed;

use crate::atomic_file::{AtomicFile, replaceable, sync_folder};
use crate::dimension::{self, name_axes};
use crate::error::{AtFile, AtPlace, LayoutError, Place, StoreError};
use crate::extents::Sizes;
use crate::external::{
    LinkedName, SharedGroup, carry_over, is_joined, join, lock_linked, take_over,
};
use crate::hdf5_file::FileState;
use crate::header;
use crate::header::GroupRecord;
use crate::layout::{Group, Layout};
use crate::lock::RunFile;
use crate::reader::Reader;
use crate::signals::note_commit;
use crate::writer::GroupWriter;

/// A new state of a run file, in a hidden file beside it; dropping it leaves the run file as it was.
///
/// New groups are written to an empty file and the groups that stay are copied at the commit,
/// object by object: the file never holds dead space, however often a group runs again. A group in
/// a file of its own is written once and only linked again.
///
/// Where many calls of HDF5 follow one another, the lock of the library is taken once for all: threads that write small files
/// then wait less. No other lock may be taken meanwhile.
#[derive(Debug)]
pub struct Transaction {
    run_file: AtomicFile,
    /// Groups that are written to files of their own.
    beside: Vec<Group>,
    external: Vec<ExternalPart>,
    previous: Option<Reader>,
    /// That of the present file, before it was opened.
    state: FileState,
    replaced: Vec<Group>,
    embed: bool,
    unfinished: Option<Group>,
    /// Digests of the groups that are written.
    finished: BTreeMap<Group, String>,
    pub(super) sizes: Sizes,
    pub(super) layout: Layout,
    pub(super) target: PathBuf,
    folder: PathBuf,
    /// Locks of the files that are linked: whoever removes what nobody links leaves them.
    linked: Vec<Arc<File>>,
}

/// A group being written to a file of its own.
#[derive(Debug)]
struct ExternalPart {
    group: Group,
    part: AtomicFile,
}

impl Transaction {
    /// Begins a change of a locked run file.
    ///
    /// # Errors
    /// Those of [`Reader::open`] for the present file, `Io` if it is write-protected, `Hdf5` if the
    /// temporary file cannot be created.
    pub fn begin(run_file: &RunFile) -> Result<Self, StoreError> {
        let state = FileState::of(&run_file.path);
        let previous = Reader::open_if_there(&run_file.path, run_file.layout)?;
        replaceable(&run_file.path)?;
        let layout = run_file.layout;
        let target = &run_file.path;
        Ok(Transaction {
            run_file: part(target, &layout, layout.filetype)?,
            beside: Vec::new(),
            external: Vec::new(),
            previous,
            state,
            replaced: Vec::new(),
            embed: false,
            unfinished: None,
            finished: BTreeMap::new(),
            sizes: Sizes::default(),
            layout,
            target: run_file.path.clone(),
            folder: run_file.folder.clone(),
            linked: Vec::new(),
        })
    }

    /// Has a group that will be written kept in a file beside the run file, named by its digest, that any run file of the folder
    /// may link.
    pub fn keep_beside(&mut self, group: Group) {
        self.beside.push(group);
    }

    /// Whether a group is written to a file beside the run file.
    #[must_use]
    pub fn keeps_beside(&self, group: Group) -> bool {
        self.beside.contains(&group)
    }

    /// The state before this change, to read upstream groups from; `None` for a new file.
    #[must_use]
    pub fn previous(&self) -> Option<&Reader> {
        self.previous.as_ref()
    }

    /// Begins to write a group in place of what the file held of it.
    ///
    /// Symbolic sizes must agree with the upstream groups that stay and with the groups already
    /// written.
    ///
    /// # Errors
    /// `Internal` if the group was written before or another one is unfinished.
    pub fn group(&mut self, group: Group) -> Result<GroupWriter<'_>, StoreError> {
        if let Some(group) = self.unfinished {
            return Err(LayoutError::NotFinished { group }.into());
        }
        if self.finished.contains_key(&group) {
            let path = group.name().into();
            return Err(LayoutError::Twice { path }.into());
        }
        self.remove(group);
        self.learn_upstream_sizes(group);
        let place = Place::new(&self.target, group.name());
        let file = if self.keeps_beside(group) {
            let (layout, filetype) = (&self.layout, self.layout.linked_filetype);
            let part = part(&self.target, layout, filetype)?;
            self.external.push(ExternalPart { group, part });
            &self.external[self.external.len() - 1].part.file
        } else {
            &self.run_file.file
        };
        let object = file
            .create_group_builder()
            .obj_track_times(false)
            .create(group.name())
            .at(place, "create the group")?;
        self.unfinished = Some(group);
        Ok(GroupWriter::new(self, group, object))
    }

    /// Writes a whole group with its record, as [`Self::group`] and [`GroupWriter::finish`]; returns its digest.
    ///
    /// # Errors
    /// Those of `write` and of both.
    pub fn write<E: From<StoreError>>(
        &mut self,
        group: Group,
        record: &GroupRecord,
        write: impl FnOnce(&mut GroupWriter<'_>) -> Result<(), E>,
    ) -> Result<String, E> {
        let mut writer = self.group(group)?;
        undisturbed(|| {
            write(&mut writer)?;
            Ok(writer.finish(record)?)
        })
    }

    /// Puts a link to a shared file in the place of what the file held of its group.
    pub fn link(&mut self, shared: &SharedGroup) -> Result<(), StoreError> {
        self.remove(shared.group);
        self.linked.push(shared.lock.clone());
        let place = Place::new(&self.target, shared.group.name());
        join(&self.run_file.file, place, shared.group, &shared.name)
    }

    /// Puts a copy of a group of another file, with its record, in the place of what the file held of it.
    ///
    /// # Errors
    /// Those of [`Reader::group_record`], `Hdf5` if copying fails.
    pub fn copy(&mut self, from: &Reader, group: Group) -> Result<(), StoreError> {
        self.remove(group);
        take_over(from, group, &self.run_file.file)
    }

    /// Leaves a group out of the new state.
    pub fn remove(&mut self, group: Group) {
        if !self.replaced.contains(&group) {
            self.replaced.push(group);
        }
    }

    /// Takes the groups that were kept in files of their own, and stay, into the run file.
    pub fn embed_linked(&mut self) {
        self.embed = true;
    }

    /// The names of the files beside the run file that this change writes; where it fails, no run file may link them.
    #[must_use]
    pub fn names_beside(&self) -> Vec<String> {
        let name = |part: &ExternalPart| {
            let digest = self.finished.get(&part.group)?;
            Some(LinkedName::new(part.group, digest).to_string())
        };
        self.external.iter().filter_map(name).collect()
    }

    /// Puts the new state in the place of the old one, safe against loss of power.
    ///
    /// Each file is closed with every error seen before it is renamed. Files of groups come first: until the run file itself is
    /// renamed, its old state is whole.
    ///
    /// # Errors
    /// `Internal` if a group is unfinished; `Hdf5` or `Io` if copying, closing, syncing or renaming
    /// fails, `Unproven` if what was written is not what the disk has, with the old state kept; `Changed` if another program
    /// changed the file since the change began; `Unsynced`, with the new state in its place.
    pub fn commit(mut self) -> Result<(), StoreError> {
        if let Some(group) = self.unfinished {
            return Err(LayoutError::NotFinished { group }.into());
        }
        let file = &self.run_file.file;
        if let Some(previous) = &self.previous {
            carry_over(previous, &self.replaced, self.embed, file)?;
        }
        // What was copied from a file that another program overwrote meanwhile may be a mixture.
        if FileState::of(&self.target) != self.state {
            return Err(StoreError::Changed { file: self.target });
        }
        let permissions = replaceable(&self.target)?;
        let place = Place::new(&self.target, "/");
        let texts = dimension::types(&self.target, place)?;
        let layout = self.layout;
        for ExternalPart { group, part } in self.external.drain(..) {
            let digest = self.finished.remove(&group).unwrap_or_default();
            name_axes(&part.file, place, &layout, (group, true), texts)?;
            let name = LinkedName::new(group, &digest);
            join(file, place, group, &name)?;
            let target = self.folder.join(name.to_string());
            replaceable(&target)?;
            let written = part.finish(&target, layout.linked_filetype)?;
            written.publish(&target, permissions.clone())?;
            self.linked.extend(lock_linked(&target).map(Arc::new));
            sync_folder(&self.folder).at_file(&self.folder, "sync the folder")?;
        }
        let groups = layout.groups();
        let held: Vec<Group> = groups
            .filter(|group| file.link_exists(group.name()))
            .collect();
        undisturbed(|| {
            for group in held.iter().filter(|group| !is_joined(file, **group)) {
                let is_new = self.finished.contains_key(group);
                name_axes(file, place, &layout, (*group, is_new), texts)?;
            }
            Ok::<(), StoreError>(())
        })?;
        let written = self.run_file.finish(&self.target, layout.filetype)?;
        drop(self.previous);
        written.publish(&self.target, permissions)?;
        note_commit(&self.target, held);
        sync_folder(&self.folder).map_err(|source| StoreError::Unsynced {
            file: self.target,
            source,
        })
    }

    pub(super) fn group_finished(&mut self, digest: &str) {
        let group = self.unfinished.take();
        self.finished
            .extend(group.map(|group| (group, digest.to_owned())));
    }

    fn learn_upstream_sizes(&mut self, group: Group) {
        let Some(previous) = &self.previous else {
            return;
        };
        let upstream = self.layout.upstream_of(group);
        let kept = upstream.filter(|other| !self.replaced.contains(other));
        self.sizes.adopt(previous.sizes_of(kept));
    }
}

/// Begins a hidden file with its root attributes.
fn part(target: &Path, layout: &Layout, filetype: &'static str) -> Result<AtomicFile, StoreError> {
    AtomicFile::create(target, |path| header::create(path, layout, filetype))
}

//! A change of a run file: written beside it, read back, then put in its place in one step, or not at all.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hdf5_metno::sync::sync as undisturbed;

use crate::attribute::read_text;
use crate::dataset::digest_of;
use crate::digest::of_group;
use crate::dimension::name_axes;
use crate::error::{AtFile, AtPlace, LayoutError, Place, StoreError};
use crate::extents::Sizes;
use crate::header::GroupRecord;
use crate::home::{Home, LinkedName, SharedGroup, carry_over, is_joined, join, take_over};
use crate::layout::{DatasetSpec, Group, Layout};
use crate::lock::{RunFile, temporary_for};
use crate::reader::Reader;
use crate::seal::Seals;
use crate::signals::note_commit;
use crate::volume::{FileState, Volume};
use crate::whole::{WholeFile, replaceable, sync_folder};
use crate::writer::GroupWriter;
use crate::{dimension, header, heaps, matrix};

/// A new state of a run file, in the hidden file `.NAME.part`; dropping it leaves the run file as
/// it was.
///
/// New groups are written to an empty file and the groups that stay are copied at the commit,
/// object by object: the file never holds dead space, however often a group runs again. A group in
/// a file of its own is written once and only linked again.
///
/// Where many calls of HDF5 follow one another, the lock of the library is taken once for all: threads that write small files
/// then wait less. No other lock may be taken meanwhile.
#[derive(Debug)]
pub struct Transaction {
    run_file: WholeFile,
    shared: Vec<SharedPart>,
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
    temporary: PathBuf,
}

/// A group being written to a file of its own.
#[derive(Debug)]
struct SharedPart {
    group: Group,
    part: WholeFile,
    /// Known once the group is finished.
    name: Option<LinkedName>,
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
        let temporary = run_file.temporary();
        Ok(Transaction {
            run_file: part(temporary.clone(), &layout, layout.filetype)?,
            shared: Vec::new(),
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
            temporary,
        })
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
    pub fn group(&mut self, group: Group, home: Home) -> Result<GroupWriter<'_>, StoreError> {
        if let Some(group) = self.unfinished {
            return Err(LayoutError::NotFinished { group }.into());
        }
        let is_shared = self.shared.iter().any(|shared| shared.group == group);
        if is_shared || self.run_file.file().link_exists(group.name()) {
            let path = group.name().into();
            return Err(LayoutError::Twice { path }.into());
        }
        self.remove(group);
        self.learn_upstream_sizes(group);
        let place = Place::new(&self.target, group.name());
        let file = match home {
            Home::RunFile => self.run_file.file(),
            Home::Shared => {
                let temporary = temporary_for(&self.temporary, group);
                self.shared.push(SharedPart {
                    group,
                    part: part(temporary, &self.layout, self.layout.linked_filetype)?,
                    name: None,
                });
                self.shared[self.shared.len() - 1].part.file()
            }
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
        home: Home,
        record: &GroupRecord,
        write: impl FnOnce(&mut GroupWriter<'_>) -> Result<(), E>,
    ) -> Result<String, E> {
        let mut writer = self.group(group, home)?;
        undisturbed(|| {
            write(&mut writer)?;
            Ok(writer.finish(record)?)
        })
    }

    /// Puts a link to a shared file in the place of what the file held of its group.
    pub fn link(&mut self, shared: &SharedGroup) -> Result<(), StoreError> {
        self.remove(shared.group);
        let place = Place::new(&self.target, shared.group.name());
        join(self.run_file.file(), place, shared.group, &shared.name)
    }

    /// Puts a copy of a group of another file, with its record, in the place of what the file held of it.
    ///
    /// # Errors
    /// The first of the group's [`Reader::group_problems`], `Hdf5` if copying fails.
    pub fn copy(&mut self, from: &Reader, group: Group) -> Result<(), StoreError> {
        if let Some(problem) = from.group_problems(group).into_iter().next() {
            return Err(problem);
        }
        self.remove(group);
        take_over(from, group, self.run_file.file())
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

    /// Puts the new state in the place of the old one, safe against loss of power.
    ///
    /// Each file is closed with every error seen, and read back, before it is renamed. Files of groups come first: until the
    /// run file itself is renamed, its old state is whole.
    ///
    /// # Errors
    /// `Internal` if a group is unfinished; `Hdf5` or `Io` if copying, closing, syncing or renaming
    /// fails, `Unproven` if what was written is not what the disk has, with the old state kept; `ForeignLink` for a link in the
    /// root that this program did not make; `Changed` if another program changed the file since the change began; `Unsynced`,
    /// with the new state in its place.
    pub fn commit(mut self) -> Result<(), StoreError> {
        if let Some(group) = self.unfinished {
            return Err(LayoutError::NotFinished { group }.into());
        }
        let file = self.run_file.file();
        if let Some(previous) = &self.previous {
            carry_over(previous, &self.replaced, self.embed, file)?;
        }
        // What was copied from a file that another program overwrote meanwhile may be a mixture.
        if FileState::of(&self.target) != self.state {
            return Err(StoreError::Changed { file: self.target });
        }
        let permissions = replaceable(&self.target)?;
        let place = Place::new(&self.target, "/");
        let texts = dimension::types(&self.temporary, place)?;
        let proof = Proof {
            layout: &self.layout,
            finished: &self.finished,
            previous: self.previous.as_ref(),
        };
        for shared in self.shared.drain(..) {
            let Some(name) = shared.name else { continue };
            name_axes(
                shared.part.file(),
                place,
                &self.layout,
                (shared.group, true),
                texts,
            )?;
            let seals = Seals::set(shared.part.file(), place, &[shared.group])?;
            join(file, place, shared.group, &name)?;
            let target = self.folder.join(name.to_string());
            replaceable(&target)?;
            let filetype = self.layout.linked_filetype;
            let proven = |path: &Path| proof.of(path, filetype, &seals, &target);
            let written = shared.part.finish(proven)?;
            written.publish(&target, permissions.clone())?;
            sync_folder(&self.folder).at_file(&self.folder, "sync the folder")?;
        }
        let groups = self.layout.groups();
        let held: Vec<Group> = groups
            .filter(|group| file.link_exists(group.name()))
            .collect();
        let own = held.iter().filter(|group| !is_joined(file, **group));
        let own: Vec<Group> = own.copied().collect();
        let seals = undisturbed(|| {
            for group in &own {
                let is_new = self.finished.contains_key(group);
                name_axes(file, place, &self.layout, (*group, is_new), texts)?;
            }
            Seals::set(file, place, &own)
        })?;
        let filetype = self.layout.filetype;
        let proven = |path: &Path| undisturbed(|| proof.of(path, filetype, &seals, &self.target));
        let written = self.run_file.finish(proven)?;
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
        for shared in &mut self.shared {
            if Some(shared.group) == group {
                shared.name = Some(LinkedName::new(shared.group, digest));
            }
        }
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
fn part(path: PathBuf, layout: &Layout, filetype: &'static str) -> Result<WholeFile, StoreError> {
    WholeFile::create(path, |path| header::create(path, layout, filetype))
}

/// What a new state is held against.
#[derive(Debug)]
struct Proof<'a> {
    layout: &'a Layout,
    /// Digests of the groups that were written.
    finished: &'a BTreeMap<Group, String>,
    /// Where the other groups were copied from.
    previous: Option<&'a Reader>,
}

impl Proof<'_> {
    /// Reads the groups that a file holds itself back, and all its attributes.
    ///
    /// # Errors
    /// `Unproven` if anything is not what was written; `target` is the file that it names.
    fn of(
        &self,
        written: &Path,
        filetype: &'static str,
        seals: &Seals,
        target: &Path,
    ) -> Result<(), StoreError> {
        let state = FileState::of(written);
        let opened = header::open_written(written);
        let volume =
            opened.and_then(|file| Volume::of(file, state, written, self.layout, filetype));
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
        let mut digests = BTreeMap::new();
        for spec in self.layout.of_group(group) {
            if volume.holds(spec.path) {
                let digest = self.of_dataset(volume, spec)?;
                if !spec.volatile {
                    digests.insert(spec.path, digest);
                }
            }
        }
        let object = volume.file.group(group.name());
        let object = object.at(place, "open the group")?;
        let Some(finished) = self.finished.get(&group) else {
            return Ok(());
        };
        let stored = header::read(&object, place)?;
        place.same_digest(finished.clone(), of_group(&digests, stored.units))?;
        place.same_digest(finished.clone(), stored.digest)
    }

    /// The digest of a dataset as the disk has it: the one beside it or, in a copy, that of the original, sound or not.
    fn of_dataset(&self, volume: &Volume, spec: &DatasetSpec) -> Result<String, StoreError> {
        let place = Place::new(&volume.path, spec.path);
        let (mut expected, found) = digests_on_disk(volume, spec)?;
        if expected != found
            && let Some(previous) = self.previous
            && !self.finished.contains_key(&spec.group)
        {
            expected = digests_on_disk(previous.volume(spec.group)?, spec)?.1;
        }
        place.same_digest(expected, found.clone())?;
        Ok(found)
    }
}

/// The digest that stands beside a dataset or matrix, and that of its values.
fn digests_on_disk(volume: &Volume, spec: &DatasetSpec) -> Result<(String, String), StoreError> {
    let place = Place::new(&volume.path, spec.path);
    if spec.kind.is_matrix() {
        let group = volume.file.group(spec.path).at(place, "open the matrix")?;
        let found = matrix::digest_of(&volume.file, place, volume.bytes)?;
        return Ok((read_text(&group, place, "digest")?, found));
    }
    let dataset = volume.file.dataset(spec.path);
    let dataset = dataset.at(place, "open the dataset")?;
    let found = digest_of(&dataset, spec.kind, place, volume.bytes)?;
    Ok((read_text(&dataset, place, "digest")?, found))
}

//! Where a group is kept: in the run file, or in a file beside it that the run files of a folder share.
//!
//! Such a file, `STAGE-DIGEST.h5`, is named by the digest of the group and never changes. It is found by what the group was
//! computed from. Its name stands in a root attribute of the run file, which this program goes by; the external link there is
//! for everyone else.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{fmt, fs, io};

use hdf5_metno as hdf5;

use crate::attribute::{read_text, write_text};
use crate::error::{AtPlace, LinkProblem, Place, StoreError};
use crate::hdf5_file::{FileState, Hdf5File};
use crate::header;
use crate::header::StoredGroup;
use crate::layout::{DatasetSpec, Group, Layout};
use crate::lock::RunFile;
use crate::plain_file::{is_still_at, open_plain};
use crate::reader::Reader;

/// Hexadecimal digits of the group's digest in the name; 64 bits tell the groups of a folder apart.
const NAME_DIGITS: usize = 16;

/// The plain name of a file that holds one group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct LinkedName(String);

impl LinkedName {
    pub(super) fn new(group: Group, digest: &str) -> Self {
        let digits = digest.get(..NAME_DIGITS).unwrap_or(digest);
        LinkedName(format!("{group}-{digits}.h5"))
    }

    /// Takes a text that is such a name; a name has no path separators, so it stays in its folder.
    pub(super) fn parse(text: &str, group: Group) -> Option<Self> {
        let digits = text.strip_prefix(group.name())?.strip_prefix('-')?;
        let digits = digits.strip_suffix(".h5")?;
        let hexadecimal = |c: u8| c.is_ascii_digit() || (b'a'..=b'f').contains(&c);
        let is_name = digits.len() == NAME_DIGITS && digits.bytes().all(hexadecimal);
        is_name.then(|| LinkedName(text.into()))
    }

    /// Whether the file may hold a group with this digest.
    fn fits(&self, digest: &str) -> bool {
        let name = self.0.strip_suffix(".h5").unwrap_or_default();
        let digits = name.rsplit_once('-').map_or("", |(_, digits)| digits);
        !digits.is_empty() && digest.starts_with(digits)
    }
}

impl fmt::Display for LinkedName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// A group that the run file keeps elsewhere.
#[derive(Debug)]
pub(super) struct Linked {
    /// `None` if what stands in the run file cannot be the name.
    pub(super) name: Option<LinkedName>,
    pub(super) file: Result<Hdf5File, LinkProblem>,
}

/// The root attribute that names the file of a group.
fn attribute(group: Group) -> String {
    format!("{group}_file")
}

impl Linked {
    /// Opens the file of a group, or `None` if the run file holds the group itself, or not at all.
    pub(super) fn open(home: &Hdf5File, layout: &Layout, group: Group) -> Option<Self> {
        if !is_joined(&home.hdf5, group) {
            return None;
        }
        let place = Place::new(&home.path, group.name());
        let text = read_text(&home.hdf5, place, &attribute(group)).unwrap_or_default();
        let name = LinkedName::parse(&text, group);
        let file = match &name {
            None => Err(LinkProblem::NotAName { found: text }),
            Some(name) => {
                // HDF5 and we look beside the run file itself, not beside a symbolic link to it.
                let home = home.path.canonicalize().unwrap_or(home.path.clone());
                open_named(&home.with_file_name(&name.0), layout, group, name)
            }
        };
        Some(Linked { name, file })
    }
}

/// Opens a file that holds a group with the digest in its name.
fn open_named(
    path: &Path,
    layout: &Layout,
    group: Group,
    name: &LinkedName,
) -> Result<Hdf5File, LinkProblem> {
    let unusable = |error: StoreError| match error {
        StoreError::NotFound { file } => LinkProblem::Missing { file },
        error => LinkProblem::Unusable {
            reason: error.to_string(),
        },
    };
    let file = Hdf5File::open(path, layout, layout.linked_filetype).map_err(unusable)?;
    let place = Place::new(path, group.name());
    let object = file.hdf5.group(group.name());
    let digest = object
        .at(place, "open the group")
        .and_then(|object| read_text(&object, place, "digest"))
        .map_err(unusable)?;
    if name.fits(&digest) {
        return Ok(file);
    }
    Err(LinkProblem::Replaced {
        file: path.into(),
        found: digest,
    })
}

/// Joins the file of a group to a run file: the name for us, an external link for everyone else.
pub(super) fn join(
    run_file: &hdf5::File,
    place: Place<'_>,
    group: Group,
    name: &LinkedName,
) -> Result<(), StoreError> {
    write_text(run_file, place, &attribute(group), &name.0)?;
    run_file
        .link_external(&name.0, &format!("/{group}"), group.name())
        .at(place, "link the file of the stage")
}

/// Whether a group of a run file is kept in a file of its own.
pub(super) fn is_joined(run_file: &hdf5::File, group: Group) -> bool {
    run_file.attr(&attribute(group)).is_ok()
}

impl RunFile {
    /// The names of all files that the run file links.
    #[must_use]
    pub fn linked_names(&self) -> Vec<String> {
        linked_names(&self.path, &self.layout).unwrap_or_default()
    }

    /// Removes linked files that no run file of the folder names any more. What cannot be removed, or is write-protected, stays, and
    /// what is no file of ours; all stay unless every file of the folder tells what it links, and nothing changes meanwhile.
    pub fn remove_unlinked(&self, mut names: Vec<String>) {
        names.retain(|name| {
            let mut groups = self.layout.groups();
            groups.any(|group| LinkedName::parse(name, group).is_some())
        });
        if names.is_empty() {
            return;
        }
        let Ok(before) = states_in(&self.folder) else {
            return;
        };
        for (path, _) in &before {
            let Some(named) = linked_names(path, &self.layout) else {
                return;
            };
            names.retain(|name| !named.contains(name));
        }
        for path in names.iter().map(|name| self.folder.join(name)) {
            let is_ours = header::open(&path, &self.layout, self.layout.linked_filetype).is_ok();
            let removable = |metadata: fs::Metadata| !metadata.permissions().readonly();
            if !is_ours || !fs::metadata(&path).is_ok_and(removable) {
                continue;
            }
            // Whoever is about to link it has locked it; whoever did so since the folder was looked at has changed the folder.
            let opened = open_plain(&path, File::options().read(true).write(true));
            let locked = opened.ok().filter(|file| file.try_lock().is_ok());
            let is_same =
                |file: &File| is_still_at(file, &path) && is_unchanged(&self.folder, &before);
            if locked.as_ref().is_some_and(is_same) {
                let _ = fs::remove_file(&path);
            }
        }
    }
}

/// What a folder holds.
fn states_in(folder: &Path) -> io::Result<Vec<(PathBuf, FileState)>> {
    let paths = fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path()));
    let states = paths.map(|path| path.map(|path| (path.clone(), FileState::of(&path))));
    states.collect()
}

/// Whether a folder holds nothing that it did not hold before.
fn is_unchanged(folder: &Path, before: &[(PathBuf, FileState)]) -> bool {
    states_in(folder).is_ok_and(|now| now.iter().all(|state| before.contains(state)))
}

/// Locks a linked file against being removed, while a run file is about to link it; `None` if it is being removed, or has no locks.
pub(super) fn lock_linked(path: &Path) -> Option<File> {
    let file = open_plain(path, File::options().read(true)).ok()?;
    file.try_lock_shared().ok()?;
    is_still_at(&file, path).then_some(file)
}

/// The names of all files that a file links, none for what is no run file; `None` if it does not tell.
pub(super) fn linked_names(path: &Path, layout: &Layout) -> Option<Vec<String>> {
    let file = match header::open(path, layout, layout.filetype) {
        Ok(file) => file,
        Err(StoreError::NotFound { .. } | StoreError::NotHdf5 { .. }) => return Some(Vec::new()),
        Err(StoreError::IsDirectory { .. } | StoreError::NotAFile { .. }) => {
            return Some(Vec::new());
        }
        // Other files of ours link nothing; those of another program, or of another format, may.
        Err(StoreError::NotOurs { found, .. }) if found.starts_with('"') => return Some(Vec::new()),
        Err(_) => return None,
    };
    let place = Place::new(path, "/");
    let linked = layout.groups().filter(|group| is_joined(&file, *group));
    linked
        .map(|group| read_text(&file, place, &attribute(group)).ok())
        .collect()
}

/// Carries everything but the replaced groups over to a new file.
///
/// With `embed`, groups in files of their own are copied into the new file too.
///
/// # Errors
/// `Hdf5` if copying fails.
pub(super) fn carry_over(
    previous: &Reader,
    replaced: &[Group],
    embed: bool,
    to: &hdf5::File,
) -> Result<(), StoreError> {
    let home = &previous.home;
    let place = Place::new(&home.path, "/");
    let names = home.hdf5.member_names();
    for name in names.at(place, "list its groups")? {
        let group = previous.layout.groups().find(|group| group.name() == name);
        if group.is_some_and(|group| replaced.contains(&group)) {
            continue;
        }
        let linked = group.and_then(|group| Some((group, previous.linked.get(&group)?)));
        match linked {
            Some((group, Linked { name, file })) => match (name, file) {
                (_, Ok(file)) if embed => copy(&file.hdf5, place, group.name(), to)?,
                (Some(name), _) => join(to, place, group, name)?,
                // Nothing can be found by it again.
                (None, _) => {}
            },
            None => copy(&home.hdf5, place, &name, to)?,
        }
    }
    Ok(())
}

/// Copies one group of another file as it is.
pub(super) fn take_over(from: &Reader, group: Group, to: &hdf5::File) -> Result<(), StoreError> {
    let file = from.file_of(group)?;
    let place = Place::new(&file.path, "/");
    copy(&file.hdf5, place, group.name(), to)
}

/// Copies a group.
fn copy(
    from: &hdf5::File,
    place: Place<'_>,
    name: &str,
    to: &hdf5::File,
) -> Result<(), StoreError> {
    let place = place.beside(name);
    let info = from.loc_info_by_name(name).at(place, "find the group")?;
    let object = from.open_by_token(info.token).at(place, "open the group")?;
    object.copy_to(to, name).at(place, "copy the group")
}

/// A group in a file `STAGE-DIGEST.h5`, which nobody removes meanwhile.
#[derive(Debug, Clone)]
pub struct SharedGroup {
    /// The group.
    pub group: Group,
    pub(super) name: LinkedName,
    pub(super) lock: Arc<File>,
    /// How the group was run, and its digest.
    pub stored: StoredGroup,
}

impl SharedGroup {
    /// Looks beside a run file for a group that was computed from the same input; altered files are passed over.
    #[must_use]
    pub fn find(run_file: &RunFile, group: Group, input_digest: &str) -> Option<Self> {
        let entries = fs::read_dir(&run_file.folder).ok()?;
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let mut names: Vec<LinkedName> = names
            .filter_map(|name| LinkedName::parse(&name, group))
            .collect();
        names.sort_by_key(ToString::to_string);
        names.into_iter().find_map(|name| {
            let path = run_file.folder.join(name.to_string());
            let lock = Arc::new(lock_linked(&path)?);
            let file = open_named(&path, &run_file.layout, group, &name).ok()?;
            let object = file.hdf5.group(group.name()).ok()?;
            let stored = header::read(&object, Place::new(&path, group.name())).ok()?;
            (stored.record.input_digest == input_digest).then_some(Self {
                group,
                name,
                lock,
                stored,
            })
        })
    }
}

impl Reader {
    /// The name and the length of the file beside the run file that holds a group, if one does.
    #[must_use]
    pub fn linked_file(&self, group: Group) -> Option<(String, u64)> {
        let linked = self.linked.get(&group)?;
        let file = linked.file.as_ref().ok()?;
        Some((linked.name.as_ref()?.to_string(), file.bytes))
    }

    /// What is wrong with the files beside the run file, one for each that cannot be used.
    pub fn link_problems(&self) -> impl Iterator<Item = StoreError> {
        let groups = self.linked.keys();
        groups.filter_map(|group| self.file_of(*group).err())
    }

    /// The file that holds a group: the run file, or the one beside it.
    pub(super) fn file_of(&self, group: Group) -> Result<&Hdf5File, StoreError> {
        match self.linked.get(&group).map(|linked| &linked.file) {
            None => Ok(&self.home),
            Some(Ok(file)) => Ok(file),
            Some(Err(problem)) => Err(StoreError::Linked {
                file: self.home.path.clone(),
                group,
                problem: problem.clone(),
            }),
        }
    }

    /// The path of the file that holds a dataset.
    pub(super) fn path_of(&self, path: &str) -> &Path {
        let spec = self.layout.find(path);
        let file = spec.and_then(|spec| self.file_of(spec.group).ok());
        &file.unwrap_or(&self.home).path
    }

    pub(super) fn place<'a>(&'a self, spec: &DatasetSpec) -> Place<'a> {
        Place::new(self.path_of(spec.path), spec.path)
    }

    /// Whether the dataset is there.
    pub(super) fn holds(&self, spec: &DatasetSpec) -> bool {
        self.file_of(spec.group)
            .is_ok_and(|file| file.holds(spec.path))
    }

    pub(super) fn missing(&self, dataset: &str, group: Group) -> StoreError {
        StoreError::Missing {
            file: self.home.path.clone(),
            dataset: dataset.into(),
            group,
        }
    }
}

//! One HDF5 file opened for reading: the run file, or the file beside it that holds one group.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

use hdf5::{IndexType, IterationOrder, LinkType, LocationType};
use hdf5_metno as hdf5;

use crate::error::{AtFile, Place, StoreError};
use crate::header;
use crate::layout::{Group, Layout};

/// An open file with what is needed to judge its contents.
#[derive(Debug)]
pub(super) struct Volume {
    pub(super) path: PathBuf,
    pub(super) file: hdf5::File,
    /// Length of the file.
    pub(super) bytes: u64,
    objects: Objects,
    /// That of the file before it was opened.
    state: FileState,
}

/// A file that was not changed for so long has another time of change once it is: clocks of file systems tick less often.
pub(super) const TICK: Duration = Duration::from_millis(20);

/// Groups of files that this process has found sound.
static SOUND: LazyLock<Mutex<HashSet<(FileState, Group)>>> = LazyLock::new(Mutex::default);

fn sound() -> MutexGuard<'static, HashSet<(FileState, Group)>> {
    SOUND.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Volume {
    /// Opens a file and checks its root attributes; errors as for [`crate::Reader::open`].
    pub(super) fn open(
        path: &Path,
        layout: &Layout,
        filetype: &'static str,
    ) -> Result<Self, StoreError> {
        let state = FileState::of(path);
        Self::of(header::open_any(path)?, state, path, layout, filetype)
    }

    /// Takes an open file, with its stamp before it was opened; errors as for [`crate::Reader::open`].
    pub(super) fn of(
        file: hdf5::File,
        state: FileState,
        path: &Path,
        layout: &Layout,
        filetype: &'static str,
    ) -> Result<Self, StoreError> {
        header::check(&file, path, layout, filetype)?;
        let bytes = fs::metadata(path).at_file(path, "look at the file")?.len();
        let place = Place::new(path, "/");
        let objects = Objects::of(&file).map_err(|error| place.unlisted(&error))?;
        Ok(Volume {
            path: path.into(),
            file,
            bytes,
            objects,
            state,
        })
    }

    /// Whether the file is still the one that was opened, as it was.
    pub(super) fn is_unchanged(&self) -> bool {
        FileState::of(&self.path) == self.state
    }

    pub(super) fn is_sound(&self, group: Group) -> bool {
        sound().contains(&(self.state.clone(), group))
    }

    /// Notes that a group is what was written.
    pub(super) fn note_sound(&self, group: Group) {
        if self.state.is_older_than(TICK) {
            sound().insert((self.state.clone(), group));
        }
    }

    /// The soft or external link that lies on the way to a path.
    pub(super) fn link_on_the_way(&self, path: &str) -> Option<&str> {
        let leads = |link: &&String| {
            path.strip_prefix(link.as_str())
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        self.objects.links.iter().find(leads).map(String::as_str)
    }

    /// A soft or external link inside the group of a group.
    pub(super) fn link_below(&self, group: Group) -> Option<&str> {
        let inside = format!("/{group}/");
        let mut links = self.objects.links.iter().map(String::as_str);
        links.find(|link| link.starts_with(&inside))
    }

    /// Whether every group on the way, and the object itself, is in this file.
    pub(super) fn holds(&self, path: &str) -> bool {
        let Objects {
            paths, has_aliases, ..
        } = &self.objects;
        self.link_on_the_way(path).is_none()
            && (paths.contains(path) || *has_aliases && has_path(&self.file, path))
    }
}

/// What is in a file, listed once: to ask HDF5 for each object costs more.
#[derive(Debug, Default)]
struct Objects {
    /// Paths of all soft and external links, which are never followed.
    links: Vec<String>,
    /// Paths of all groups and datasets along hard links, but of a group with several names only those below one of them.
    paths: HashSet<String>,
    /// Whether there are such groups.
    has_aliases: bool,
}

impl Objects {
    fn of(file: &hdf5::File) -> hdf5::Result<Self> {
        let mut objects = Self::default();
        for member in walk(members(file, "")?) {
            objects.has_aliases |= member.is_alias;
            match member.kind? {
                None => objects.links.push(member.path),
                Some(_) => drop(objects.paths.insert(member.path)),
            }
        }
        Ok(objects)
    }
}

/// Whether every group on the way to an object, and the object itself, is there.
pub(super) fn has_path(from: &hdf5::Group, path: &str) -> bool {
    let mut ends = path
        .match_indices('/')
        .map(|(end, _)| end)
        .filter(|end| *end > 0)
        .chain([path.len()]);
    ends.all(|end| from.link_exists(&path[..end]))
}

/// What tells the present state of a file from any other: what changes when it is written, replaced or removed.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct FileState(Option<(u64, SystemTime, u64)>);

impl FileState {
    /// The length, the time of the last change and, where the system has it, the number of the
    /// file at a path.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        let metadata = fs::metadata(path).ok();
        Self(metadata.and_then(|m| Some((m.len(), m.modified().ok()?, inode(&m)))))
    }

    /// Whether the last change is so long ago.
    pub(super) fn is_older_than(&self, age: Duration) -> bool {
        let elapsed = self.0.and_then(|(_, changed, _)| changed.elapsed().ok());
        elapsed.is_some_and(|elapsed| elapsed > age)
    }
}

#[cfg(unix)]
pub(super) fn inode(metadata: &fs::Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(metadata)
}

#[cfg(not(unix))]
pub(super) fn inode(_: &fs::Metadata) -> u64 {
    0
}

/// What a group has under a name.
pub(super) struct GroupMember {
    pub(super) parent: hdf5::Group,
    pub(super) name: String,
    pub(super) path: String,
    /// `None` for a soft or external link, which is never followed; an error for what cannot be looked at.
    pub(super) kind: hdf5::Result<Option<LocationType>>,
    /// Whether it is a group that was met under another name.
    is_alias: bool,
}

/// The members of a group with some path, empty for the root.
pub(super) fn members(parent: &hdf5::Group, path: &str) -> hdf5::Result<Vec<GroupMember>> {
    let links = parent.links(IndexType::Name, IterationOrder::Native)?;
    let member = |(name, link): (String, hdf5::LinkInfo)| {
        let kind = match link.link_type {
            LinkType::Hard => parent.loc_info_by_name(&name).map(|it| Some(it.loc_type)),
            LinkType::Soft | LinkType::External => Ok(None),
        };
        GroupMember {
            parent: parent.clone(),
            path: format!("{path}/{name}"),
            name,
            kind,
            is_alias: false,
        }
    };
    Ok(links.into_iter().map(member).collect())
}

/// Members of a group and all that is below them along hard links; of a group with several names what is below only once.
pub(super) fn walk(mut open: Vec<GroupMember>) -> Vec<GroupMember> {
    let mut found = Vec::new();
    let mut seen = Vec::new();
    while let Some(mut member) = open.pop() {
        if let Ok(Some(LocationType::Group)) = member.kind {
            let opened = member.parent.group(&member.name).and_then(|group| {
                let token = group.loc_info()?.token;
                Ok((members(&group, &member.path)?, token))
            });
            match opened {
                Ok((_, token)) if seen.contains(&token) => member.is_alias = true,
                Ok((below, token)) => {
                    seen.push(token);
                    open.extend(below);
                }
                Err(error) => member.kind = Err(error),
            }
        }
        found.push(member);
    }
    found
}

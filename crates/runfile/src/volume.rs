//! One HDF5 file opened for reading: the run file, or the file beside it that holds one group.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

use hdf5::{IndexType, IterationOrder, LinkType, LocationType};
use hdf5_metno as hdf5;

use super::error::StoreError;
use super::header;
use super::layout::Group;
use super::place::{AtFile, Place};
use super::table::Layout;

/// An open file with what is needed to judge its contents.
#[derive(Debug)]
pub(super) struct Volume {
    pub(super) path: PathBuf,
    pub(super) file: hdf5::File,
    /// Length of the file.
    pub(super) bytes: u64,
    /// Major and minor version of its format.
    pub(super) format_version: [i64; 2],
    /// Paths of all soft and external links, which are never followed.
    links: Vec<String>,
    /// That of the file before it was opened.
    stamp: Stamp,
}

/// A file that was not changed for so long has another time of change once it is: clocks of file systems tick less often.
pub(super) const TICK: Duration = Duration::from_millis(20);

/// Groups of files that this process has found sound.
static SOUND: LazyLock<Mutex<HashSet<(Stamp, Group)>>> = LazyLock::new(Mutex::default);

fn sound() -> MutexGuard<'static, HashSet<(Stamp, Group)>> {
    SOUND.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Volume {
    /// Opens a file and checks its root attributes; errors as for [`super::Reader::open`].
    pub(super) fn open(
        path: &Path,
        layout: &Layout,
        filetype: &'static str,
    ) -> Result<Self, StoreError> {
        let stamp = Stamp::of(path);
        Self::of(header::open_any(path)?, stamp, path, layout, filetype)
    }

    /// Takes an open file, with its stamp before it was opened; errors as for [`super::Reader::open`].
    pub(super) fn of(
        file: hdf5::File,
        stamp: Stamp,
        path: &Path,
        layout: &Layout,
        filetype: &'static str,
    ) -> Result<Self, StoreError> {
        let format_version = header::check(&file, path, layout, filetype)?;
        let bytes = fs::metadata(path).at_file(path, "look at the file")?.len();
        let place = Place::new(path, "/");
        let links = links(&file).map_err(|error| place.unlisted(&error))?;
        Ok(Volume {
            path: path.into(),
            file,
            bytes,
            format_version,
            links,
            stamp,
        })
    }

    /// Whether the file is still the one that was opened, as it was.
    pub(super) fn is_unchanged(&self) -> bool {
        Stamp::of(&self.path) == self.stamp
    }

    pub(super) fn is_sound(&self, group: Group) -> bool {
        sound().contains(&(self.stamp.clone(), group))
    }

    /// Notes that a group is what was written.
    pub(super) fn note_sound(&self, group: Group) {
        if self.stamp.is_older_than(TICK) {
            sound().insert((self.stamp.clone(), group));
        }
    }

    /// The soft or external link that lies on the way to a path.
    pub(super) fn link_on_the_way(&self, path: &str) -> Option<&str> {
        let leads = |link: &&String| {
            path.strip_prefix(link.as_str())
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        self.links.iter().find(leads).map(String::as_str)
    }

    /// A soft or external link inside the group of a group.
    pub(super) fn link_below(&self, group: Group) -> Option<&str> {
        let inside = format!("/{group}/");
        let mut links = self.links.iter().map(String::as_str);
        links.find(|link| link.starts_with(&inside))
    }

    /// Whether every group on the way, and the object itself, is in this file.
    pub(super) fn holds(&self, path: &str) -> bool {
        self.link_on_the_way(path).is_none() && has_path(&self.file, path)
    }
}

/// Whether every group on the way to an object, and the object itself, is there.
pub(super) fn has_path(file: &hdf5::File, path: &str) -> bool {
    let mut ends = path
        .match_indices('/')
        .map(|(end, _)| end)
        .skip(1)
        .chain([path.len()]);
    ends.all(|end| file.link_exists(&path[..end]))
}

/// What changes when a file is written, replaced or removed.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Stamp(Option<(u64, SystemTime, u64)>);

impl Stamp {
    /// The length, the time of the last change and, where the system has it, the number of the
    /// file.
    pub(super) fn of(path: &Path) -> Self {
        let metadata = fs::metadata(path).ok();
        Stamp(metadata.and_then(|m| Some((m.len(), m.modified().ok()?, inode(&m)))))
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

/// Walks the groups of a file, each once, along hard links.
fn links(file: &hdf5::File) -> hdf5::Result<Vec<String>> {
    let mut found = Vec::new();
    let mut seen = vec![file.loc_info()?.token];
    let mut groups = vec![(String::new(), file.group("/")?)];
    while let Some((path, group)) = groups.pop() {
        for (name, info) in group.links(IndexType::Name, IterationOrder::Native)? {
            let path = format!("{path}/{name}");
            if info.link_type != LinkType::Hard {
                found.push(path);
                continue;
            }
            let info = group.loc_info_by_name(&name)?;
            if info.loc_type == LocationType::Group && !seen.contains(&info.token) {
                seen.push(info.token);
                groups.push((path, group.group(&name)?));
            }
        }
    }
    Ok(found)
}

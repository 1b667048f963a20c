//! Groups kept in a file of their own beside the run file, joined to it by an external link.
//!
//! Such a file, `STAGE-DIGEST.h5`, is named by the digest of the group and never changes; older versions also wrote
//! `RUNFILE.STAGE-DIGEST.h5`. The name stands in a root attribute of the run file, which this program goes by; the link is there
//! for everyone else.

use std::fmt;
use std::fs;
use std::path::Path;

use hdf5_metno as hdf5;

use crate::attribute::{read_text, write_text};
use crate::error::{LinkProblem, StoreError};
use crate::header;
use crate::layout::Group;
use crate::lock::RunFile;
use crate::place::{AtPlace, Place};
use crate::table::Layout;
use crate::volume::Volume;

/// Hexadecimal digits of the group's digest in the name; 64 bits tell the groups of a folder apart.
const DIGITS: usize = 16;

/// The plain name of a file that holds one group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LinkedName(String);

impl LinkedName {
    pub(crate) fn new(group: Group, digest: &str) -> Self {
        let digits = digest.get(..DIGITS).unwrap_or(digest);
        LinkedName(format!("{group}-{digits}.h5"))
    }

    /// Takes a text that is such a name; a name has no path separators, so it stays in its folder.
    pub(crate) fn parse(text: &str, group: Group) -> Option<Self> {
        let name = LinkedName(text.into());
        let owner = name.owner_and_dot(group)?;
        let plain = owner.is_empty() || (owner.ends_with('.') && owner.len() > 1);
        (plain && !text.contains(['/', '\\', '\0'])).then_some(name)
    }

    /// Whether the file may hold a group with this digest.
    fn fits(&self, digest: &str) -> bool {
        let digits = self.digits().unwrap_or_default();
        !digits.is_empty() && digest.starts_with(digits)
    }

    /// Whether any run file may link the file.
    pub(crate) fn is_shared(&self, group: Group) -> bool {
        self.owner_and_dot(group) == Some("")
    }

    fn digits(&self) -> Option<&str> {
        let stem = self.0.strip_suffix(".h5")?;
        let digits = stem.get(stem.len().checked_sub(DIGITS)?..)?;
        let hexadecimal = |c: u8| c.is_ascii_digit() || (b'a'..=b'f').contains(&c);
        digits.bytes().all(hexadecimal).then_some(digits)
    }

    fn owner_and_dot(&self, group: Group) -> Option<&str> {
        let digits = self.digits()?;
        self.0.strip_suffix(&format!("{group}-{digits}.h5"))
    }
}

impl fmt::Display for LinkedName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// A group that the run file keeps elsewhere.
#[derive(Debug)]
pub(crate) struct Linked {
    /// `None` if what stands in the run file cannot be the name.
    pub(crate) name: Option<LinkedName>,
    pub(crate) volume: Result<Volume, LinkProblem>,
}

/// The root attribute that names the file of a group.
fn attribute(group: Group) -> String {
    format!("{group}_file")
}

impl Linked {
    /// Opens the file of a group, or `None` if the run file holds the group itself, or not at all.
    pub(crate) fn open(home: &Volume, layout: &Layout, group: Group) -> Option<Self> {
        let path = format!("/{group}");
        home.link_on_the_way(&path)?;
        let place = Place::new(&home.path, &path);
        let text = read_text(&home.file, place, &attribute(group)).unwrap_or_default();
        let name = LinkedName::parse(&text, group);
        let volume = match &name {
            None => Err(LinkProblem::NotAName { found: text }),
            Some(name) => open(home, layout, group, name),
        };
        Some(Linked { name, volume })
    }
}

fn open(
    home: &Volume,
    layout: &Layout,
    group: Group,
    name: &LinkedName,
) -> Result<Volume, LinkProblem> {
    // HDF5 and we look beside the run file itself, not beside a symbolic link to it.
    let true_path = home
        .path
        .canonicalize()
        .unwrap_or_else(|_| home.path.clone());
    open_named(&true_path.with_file_name(&name.0), layout, group, name)
}

/// Opens a file that holds a group with the digest in its name.
pub(crate) fn open_named(
    path: &Path,
    layout: &Layout,
    group: Group,
    name: &LinkedName,
) -> Result<Volume, LinkProblem> {
    let unusable = |error: StoreError| match error {
        StoreError::NotFound { file } => LinkProblem::Missing { file },
        error => LinkProblem::Unusable {
            reason: error.to_string(),
        },
    };
    let volume = Volume::open(path, layout, layout.linked_filetype).map_err(unusable)?;
    let place = Place::new(path, group.name());
    if !volume.holds(&format!("/{group}")) {
        return Err(unusable(place.mismatch("the group of the stage", "none")));
    }
    let object = volume.file.group(group.name());
    let digest = object
        .at(place, "open the group")
        .and_then(|object| read_text(&object, place, "digest"))
        .map_err(unusable)?;
    if name.fits(&digest) {
        return Ok(volume);
    }
    Err(LinkProblem::Replaced {
        file: path.into(),
        found: digest,
    })
}

/// Joins the file of a group to a run file: the name for us, an external link for everyone else.
pub(crate) fn join(
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

/// Whether a group of a run file being written is kept in a file of its own.
pub(crate) fn is_joined(run_file: &hdf5::File, group: Group) -> bool {
    run_file.attr(&attribute(group)).is_ok()
}

impl RunFile {
    /// The names of all files that the run file links.
    #[must_use]
    pub fn linked_names(&self) -> Vec<String> {
        linked_names(&self.path, &self.layout)
    }

    /// Removes linked files that no run file of the folder names any more; what cannot be removed, or is write-protected, stays, and
    /// what is no file of ours.
    pub fn remove_unlinked(&self, mut names: Vec<String>) {
        names.retain(|name| {
            let mut groups = self.layout.groups();
            groups.any(|group| LinkedName::parse(name, group).is_some())
        });
        if names.is_empty() {
            return;
        }
        for entry in fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            let named = linked_names(&entry.path(), &self.layout);
            names.retain(|name| !named.contains(name));
        }
        for path in names.iter().map(|name| self.folder.join(name)) {
            let is_ours = header::open(&path, &self.layout, self.layout.linked_filetype).is_ok();
            let removable = |metadata: fs::Metadata| !metadata.permissions().readonly();
            if is_ours && fs::metadata(&path).is_ok_and(removable) {
                let _ = fs::remove_file(path);
            }
        }
    }
}

/// The names of all files that a run file links; none if it cannot be read.
pub(crate) fn linked_names(run_file: &Path, layout: &Layout) -> Vec<String> {
    let Ok((file, _)) = header::open(run_file, layout, layout.filetype) else {
        return Vec::new();
    };
    let place = Place::new(run_file, "/");
    let named = |group| read_text(&file, place, &attribute(group)).ok();
    layout.groups().filter_map(named).collect()
}

//! Files of other programs, opened for reading with the care that run files get.

use std::fs;
use std::path::Path;

use hdf5::dataset::Layout as Storage;
use hdf5::{IndexType, IterationOrder, LinkType, LocationType};
use hdf5_metno as hdf5;

use super::bounds;
use super::error::StoreError;
use super::header;
use super::place::{AtFile, AtPlace, Place};

/// An HDF5 file of which some groups are known to hold all their data themselves.
///
/// No soft or external link leads out of these groups, no dataset lies in another file, virtual or by external storage, and every size that is
/// declared is backed by bytes of the file, up to what deflate can make of them.
#[derive(Debug)]
pub struct Foreign {
    file: hdf5::File,
    declared: u64,
}

impl Foreign {
    /// Opens a file and examines those of some groups of its root that are there, and all in them.
    ///
    /// # Errors
    /// `NotFound`, `IsDirectory`, `NotAFile`, `NotHdf5`, `Io`; `NotItself` for what is damaged, or lies elsewhere.
    pub fn open(path: &Path, groups: &[&str]) -> Result<Self, StoreError> {
        let file = header::open_any(path).map_err(|error| in_words(error, path))?;
        let bytes = fs::metadata(path).at_file(path, "look at the file")?.len();
        let mut declared = 0_u64;
        for group in groups {
            declared = declared.saturating_add(examined(&file, path, bytes, group)?);
        }
        Ok(Self { file, declared })
    }

    /// The file; only the groups that were named may be read.
    #[must_use]
    pub fn file(&self) -> &hdf5::File {
        &self.file
    }

    /// Bytes of all values in the groups, once they are read.
    #[must_use]
    pub fn declared(&self) -> u64 {
        self.declared
    }
}

/// A link of a group, with the path of what it leads to.
struct Link {
    parent: hdf5::Group,
    path: String,
    name: String,
    kind: LinkType,
}

/// The links of a group, whose path ends with a slash.
fn links(parent: &hdf5::Group, file: &Path, folder: &str) -> Result<Vec<Link>, StoreError> {
    let links = parent.links(IndexType::Name, IterationOrder::Native);
    let links = links.at(place(file, folder), "list the links")?;
    let links = links.into_iter().map(|(name, info)| Link {
        parent: parent.clone(),
        path: format!("{folder}{name}"),
        name,
        kind: info.link_type,
    });
    Ok(links.collect())
}

/// Bytes of all values at and below an object of the root, each object counted once, along hard links.
fn examined(file: &hdf5::File, path: &Path, bytes: u64, name: &str) -> Result<u64, StoreError> {
    let root = file.group("/").at(place(path, "/"), "open the group")?;
    let mut open = links(&root, path, "/")?;
    open.retain(|link| link.name == name);
    let mut seen = Vec::new();
    let mut declared = 0_u64;
    while let Some(link) = open.pop() {
        let at = place(path, &link.path);
        if link.kind != LinkType::Hard {
            return Err(elsewhere(path, &link.path, "a link to another place"));
        }
        let info = link.parent.loc_info_by_name(&link.name);
        let info = info.at(at, "look at the object")?;
        if seen.contains(&info.token) {
            continue;
        }
        seen.push(info.token);
        match info.loc_type {
            LocationType::Group => {
                let group = link.parent.group(&link.name).at(at, "open the group")?;
                open.extend(links(&group, path, &format!("{}/", link.path))?);
            }
            LocationType::Dataset => {
                let dataset = link.parent.dataset(&link.name);
                let dataset = dataset.at(at, "open the dataset")?;
                declared = declared.saturating_add(backed(&dataset, at, bytes)?);
            }
            _ => {}
        }
    }
    Ok(declared)
}

fn place<'a>(file: &'a Path, object: &'a str) -> Place<'a> {
    Place {
        file,
        dataset: object,
    }
}

/// The bytes that a dataset declares, all of them backed by the file.
fn backed(dataset: &hdf5::Dataset, place: Place<'_>, bytes: u64) -> Result<u64, StoreError> {
    let creation = dataset.dcpl().at(place, "read how it is stored")?;
    if !creation.external().is_empty() || dataset.layout() == Storage::Virtual {
        return Err(elsewhere(
            place.file,
            place.dataset,
            "values in other files",
        ));
    }
    bounds::check(dataset, place, bytes).map_err(|error| in_words(error, place.file))?;
    let element = dataset.dtype().at(place, "read the type")?.size() as u64;
    Ok(element.saturating_mul(dataset.size() as u64))
}

/// What is damaged said to those who have no stages to run again.
fn in_words(error: StoreError, file: &Path) -> StoreError {
    match error {
        StoreError::Damaged {
            dataset, reason, ..
        } => elsewhere(file, &dataset, reason),
        other => other,
    }
}

fn elsewhere(file: &Path, object: &str, found: impl Into<String>) -> StoreError {
    StoreError::NotItself {
        file: file.into(),
        object: object.into(),
        found: found.into(),
    }
}

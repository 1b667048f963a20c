//! The head of a file: what it is, by whom, in which format, and whether it is ours.

use std::env;
use std::fs;
use std::io;
use std::path::Path;

use hdf5::file::LibraryVersion;
use hdf5_metno as hdf5;

use super::attribute::{read_numbers, read_text, write_numbers, write_text};
use super::error::StoreError;
use super::heaps;
use super::place::{AtFile, Place};
use super::seal::SEAL;
use super::table::Layout;
use super::whole::{self, seeing_every_error};

/// The root attributes with their meanings, as the schema lists them.
pub const ROOT_ATTRIBUTES: &[(&str, &str, &str)] = &[
    ("filetype", "text", "what the file is"),
    (
        "format_version",
        "i64[2]",
        "major and minor version of the format; readers take any older minor one",
    ),
    (
        "creator",
        "text",
        "the program that wrote the file, with its version",
    ),
    (
        SEAL,
        "text",
        "BLAKE3 over the other attributes of the root and the seals of the stages; files of older versions have none",
    ),
];

/// How a group may be kept in a file of its own, as the schema tells it.
pub(super) const LINKED_GROUPS: &str = "A stage may be kept in a file of its own in the same folder. Then the group in the \
     root is an external link to the group of the same name in that file, and the root attribute `STAGE_file` names \
     it: `STAGE-DIGEST.h5` with the first 16 digits of the digest of the stage, which any run file of the folder may \
     link; older versions put `NAME.` before it for a run file NAME alone. Such a file never changes.";

/// Variables that make HDF5 open files in another way than it is told, and the only value that does not.
const FOREIGN_ACCESS: [(&str, &str); 2] =
    [("HDF5_DRIVER", "sec2"), ("HDF5_VOL_CONNECTOR", "native")];

/// Refuses an environment that has HDF5 open files by other means: with means that it does not know it would crash.
///
/// # Errors
/// `Environment`.
pub fn require_plain_hdf5() -> Result<(), StoreError> {
    for (variable, plain) in FOREIGN_ACCESS {
        let found = env::var_os(variable).unwrap_or_default();
        if !found.is_empty() && found != plain {
            let found = found.to_string_lossy().into_owned();
            return Err(StoreError::Environment {
                variable,
                plain,
                found,
            });
        }
    }
    Ok(())
}

/// The version of the HDF5 library: major, minor, patch.
#[must_use]
pub fn hdf5_version() -> [u8; 3] {
    let (major, minor, patch) = hdf5::library_version();
    [major, minor, patch]
}

/// Creates an empty file, readable by HDF5 1.10 and newer.
pub(super) fn create(
    path: &Path,
    layout: &Layout,
    filetype: &'static str,
) -> Result<hdf5::File, StoreError> {
    let place = Place::new(path, "/");
    let file = whole::create(path, |access| {
        let access = seeing_every_error(access);
        access.libver_bounds(LibraryVersion::V110, LibraryVersion::V110)
    })?;
    write_text(&file, place, "filetype", filetype)?;
    write_numbers(&file, place, "format_version", &layout.format_version)?;
    write_text(&file, place, "creator", layout.creator)?;
    Ok(file)
}

/// Opens a file of ours for reading; with its format version.
pub(super) fn open(
    path: &Path,
    layout: &Layout,
    filetype: &'static str,
) -> Result<(hdf5::File, [i64; 2]), StoreError> {
    let file = open_any(path)?;
    let version = check(&file, path, layout, filetype)?;
    Ok((file, version))
}

/// Opens a file for reading, whoever wrote it, unless HDF5 could not come to an end with it.
pub(super) fn open_any(path: &Path) -> Result<hdf5::File, StoreError> {
    let file = open_written(path)?;
    let place = Place::new(path, "/");
    heaps::check(&file, place)?;
    Ok(file)
}

/// Opens a file that HDF5 has just written in this process.
pub(super) fn open_written(path: &Path) -> Result<hdf5::File, StoreError> {
    let metadata = fs::metadata(path).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => StoreError::NotFound { file: path.into() },
        _ => StoreError::Io {
            file: path.into(),
            action: "look at the file",
            source,
        },
    })?;
    if metadata.is_dir() {
        return Err(StoreError::IsDirectory { file: path.into() });
    }
    // Opening a pipe could wait for ever.
    if !metadata.is_file() {
        return Err(StoreError::NotAFile { file: path.into() });
    }
    fs::File::open(path).at_file(path, "open the file for reading")?;
    let file = hdf5::File::with_options()
        .with_fapl(|access| access.sec2().file_locking(false))
        .open(path);
    let place = Place::new(path, "/");
    file.map_err(|error| {
        if error.contains_minor(hdf5::MinorErrorCode::NotHdf5) {
            StoreError::NotHdf5 { file: path.into() }
        } else if path.try_exists().is_ok_and(|exists| !exists) {
            // Removed since it was looked at.
            StoreError::NotFound { file: path.into() }
        } else {
            place.damaged(error.to_string())
        }
    })
}

/// Refuses a file that is not of this type and version; its format version.
pub(super) fn check(
    file: &hdf5::File,
    path: &Path,
    layout: &Layout,
    expected: &'static str,
) -> Result<[i64; 2], StoreError> {
    let place = Place::new(path, "/");
    let filetype = read_text(file, place, "filetype");
    if filetype.as_deref().ok() != Some(expected) {
        let found = filetype.map_or_else(|_| "none".into(), |filetype| format!("\"{filetype}\""));
        return Err(StoreError::NotOurs {
            file: path.into(),
            expected,
            found,
        });
    }
    let creator = read_text(file, place, "creator")?;
    let version: Vec<i64> = read_numbers(file, place, "format_version")?;
    let expected = layout.format_version;
    match version[..] {
        [major, minor] if major == expected[0] && (0..=expected[1]).contains(&minor) => {
            Ok([major, minor])
        }
        [major, minor] => Err(StoreError::Version {
            file: path.into(),
            expected,
            found: [major, minor],
            creator,
        }),
        _ => Err(place.mismatch("format_version with two numbers", format!("{version:?}"))),
    }
}

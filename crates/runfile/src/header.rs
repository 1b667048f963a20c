//! What files and groups tell about themselves in attributes: of which format a file is and whether it is ours, how a group was run.

use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use std::{env, fs, io};

use hdf5_metno as hdf5;
use units::Units;

use crate::attribute::{
    read_number, read_numbers, read_text, write_text, write_value, write_values,
};
use crate::error::{Place, StoreError};
use crate::layout::Layout;
use crate::{atomic_file, user_block};

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
];

/// How a file begins, as the schema tells it.
pub(super) const FILE_DIGEST: &str = "The file begins with a user block of HDF5 of 512 bytes, a text: its type, a line of words, and the \
     BLAKE3 of all bytes that follow as 64 hexadecimal digits. A file in which they are not equal was altered.";

/// How a group may be kept in a file of its own, as the schema tells it.
pub(super) const LINKED_GROUPS: &str = "A stage may be kept in a file of its own in the same folder. Then the group in the \
     root is an external link to the group of the same name in that file, and the root attribute `STAGE_file` names \
     it: `STAGE-DIGEST.h5` with the first 16 digits of the digest of the stage, which any run file of the folder may \
     link. Such a file never changes.";

/// Variables that make HDF5 open files in another way than it is told, and the only value that does not.
const FOREIGN_ACCESS: [(&str, &str); 2] =
    [("HDF5_DRIVER", "sec2"), ("HDF5_VOL_CONNECTOR", "native")];

/// Refuses an environment that has HDF5 open files by other means: with means that it does not know it would crash.
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
    let file = atomic_file::create(path)?;
    write_text(&file, place, "filetype", filetype)?;
    write_values(&file, place, "format_version", &layout.format_version)?;
    write_text(&file, place, "creator", layout.creator)?;
    Ok(file)
}

/// Opens a file of ours for reading, unless it was altered.
pub(super) fn open(
    path: &Path,
    layout: &Layout,
    filetype: &'static str,
) -> Result<hdf5::File, StoreError> {
    require_file(path)?;
    user_block::check(path, filetype)?;
    let file = open_any(path)?;
    let place = Place::new(path, "/");
    let version: Vec<i64> = read_numbers(&file, place, "format_version")?;
    let expected = layout.format_version;
    match version[..] {
        [major, minor] if major == expected[0] && (0..=expected[1]).contains(&minor) => Ok(file),
        [major, minor] => Err(StoreError::Version {
            file: path.into(),
            expected,
            found: [major, minor],
            creator: read_text(&file, place, "creator")?,
        }),
        _ => Err(place.mismatch("format_version with two numbers", format!("{version:?}"))),
    }
}

fn require_file(path: &Path) -> Result<(), StoreError> {
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
    Ok(())
}

/// Opens an HDF5 file for reading.
pub(super) fn open_any(path: &Path) -> Result<hdf5::File, StoreError> {
    let file = hdf5::File::with_options()
        .with_fapl(|access| access.sec2().file_locking(false))
        .open(path);
    file.map_err(|error| {
        if path.try_exists().is_ok_and(|exists| !exists) {
            // Removed since it was looked at.
            StoreError::NotFound { file: path.into() }
        } else {
            // Its digest fits where that was looked at, so the machine is at fault.
            StoreError::Hdf5 {
                file: path.into(),
                dataset: "/".into(),
                action: "open the file",
                source: Box::new(error),
            }
        }
    })
}

/// The attributes every group carries, with their meanings, as the schema lists them.
pub const GROUP_ATTRIBUTES: &[(&str, &str, &str)] = &[
    (
        "complete",
        "u8",
        "1 once every required dataset of the stage is written",
    ),
    (
        "input_digest",
        "text",
        "digest of the settings and of the upstream stages the stage was computed from",
    ),
    (
        "digest",
        "text",
        "BLAKE3 over the sorted paths and digests of the datasets, without timings and factors that can be made again, and over `units`",
    ),
    (
        "units",
        "text",
        "units of length and force that all others follow from, such as `mm, N`",
    ),
    ("settings", "text", "the settings used, as TOML"),
    ("seconds", "f64", "wall-clock time of the stage in s"),
    ("threads", "i64", "number of threads"),
    ("date", "text", "when the stage ended, RFC 3339 in UTC"),
];

/// How a group was run.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupRecord {
    /// The settings used, as TOML.
    pub settings: String,
    /// Digest of everything the group was computed from.
    pub input_digest: String,
    /// Wall-clock time in s.
    pub seconds: f64,
    /// Number of threads.
    pub threads: i64,
    /// When the group ended, RFC 3339 in UTC, see [`timestamp`].
    pub date: String,
}

impl GroupRecord {
    /// That of a group which ends now, after so many seconds on so many threads.
    #[must_use]
    pub fn ended(settings: String, input_digest: String, seconds: f64, threads: usize) -> Self {
        Self {
            settings,
            input_digest,
            seconds,
            threads: i64::try_from(threads).unwrap_or(i64::MAX),
            date: timestamp(),
        }
    }

    /// That of a group that only gathers what other files hold, with no input or time of its own, now.
    #[must_use]
    pub fn gathered(settings: String) -> Self {
        Self::ended(settings, String::new(), 0.0, 1)
    }
}

/// A group as the file holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredGroup {
    /// How it was run.
    pub record: GroupRecord,
    /// Digest of its datasets and units.
    pub digest: String,
    /// What its numbers are in.
    pub units: Units,
}

/// The last second that RFC 3339 can write, at the end of the year 9999.
const LAST_SECOND: Duration = Duration::from_secs(253_402_300_799);

/// The present time to the second, RFC 3339 in UTC; of a clock that is before 1970 or after 9999, the nearer end.
#[must_use]
pub fn timestamp() -> String {
    let (first, last) = (UNIX_EPOCH, UNIX_EPOCH + LAST_SECOND);
    humantime::format_rfc3339_seconds(SystemTime::now().clamp(first, last)).to_string()
}

pub(super) fn write(
    group: &hdf5::Location,
    place: Place<'_>,
    record: &GroupRecord,
    units: Units,
    digest: &str,
) -> Result<(), StoreError> {
    write_text(group, place, "units", &units.to_string())?;
    write_text(group, place, "input_digest", &record.input_digest)?;
    write_text(group, place, "digest", digest)?;
    write_text(group, place, "settings", &record.settings)?;
    write_value(group, place, "seconds", &record.seconds)?;
    write_value(group, place, "threads", &record.threads)?;
    write_text(group, place, "date", &record.date)?;
    write_value(group, place, "complete", &1_u8)
}

pub(super) fn read(group: &hdf5::Location, place: Place<'_>) -> Result<StoredGroup, StoreError> {
    let complete: u8 = read_number(group, place, "complete")?;
    if complete != 1 {
        return Err(place.mismatch("complete = 1", format!("complete = {complete}")));
    }
    Ok(StoredGroup {
        record: GroupRecord {
            settings: read_text(group, place, "settings")?,
            input_digest: read_text(group, place, "input_digest")?,
            seconds: read_number(group, place, "seconds")?,
            threads: read_number(group, place, "threads")?,
            date: read_text(group, place, "date")?,
        },
        digest: read_text(group, place, "digest")?,
        units: read_units(group, place)?,
    })
}

/// The units a group names.
fn read_units(group: &hdf5::Location, place: Place<'_>) -> Result<Units, StoreError> {
    let text = read_text(group, place, "units")?;
    text.parse()
        .map_err(|problem: String| place.damaged(problem))
}

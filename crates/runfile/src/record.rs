//! What a group tells about itself in the attributes of its group.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use hdf5_metno as hdf5;
use units::Units;

use super::attribute::{has, read_number, read_text, write_number, write_text};
use super::error::StoreError;
use super::place::Place;
use super::seal::SEAL;

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
        "BLAKE3 over the sorted paths and digests of the datasets, without timings, and over `units`",
    ),
    ("settings", "text", "the settings used, as TOML"),
    ("seconds", "f64", "wall-clock time of the stage in s"),
    ("threads", "i64", "number of threads"),
    ("date", "text", "when the stage ended, RFC 3339 in UTC"),
    (
        SEAL,
        "text",
        "BLAKE3 over all other attributes in the stage, the names and the extents of its datasets; stages of older versions have none",
    ),
];

/// The attributes a group may carry besides, as the schema lists them.
pub(super) const OPTIONAL_GROUP_ATTRIBUTES: &[(&str, &str, &str)] = &[(
    "units",
    "text",
    "units of length and force that all others follow from, such as `mm, N`; absent for `m, N`",
)];

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
    if !units.is_default() {
        write_text(group, place, "units", &units.to_string())?;
    }
    write_text(group, place, "input_digest", &record.input_digest)?;
    write_text(group, place, "digest", digest)?;
    write_text(group, place, "settings", &record.settings)?;
    write_number(group, place, "seconds", record.seconds)?;
    write_number(group, place, "threads", record.threads)?;
    write_text(group, place, "date", &record.date)?;
    write_number(group, place, "complete", 1_u8)
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

/// The units a group names; the default where it names none, as in files before format 1.4.
fn read_units(group: &hdf5::Location, place: Place<'_>) -> Result<Units, StoreError> {
    if !has(group, place, "units")? {
        return Ok(Units::SI);
    }
    let text = read_text(group, place, "units")?;
    text.parse()
        .map_err(|problem: String| place.damaged(problem))
}

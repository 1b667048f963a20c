//! One table or several, as scene files write bodies and contact faces.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A table or an array of tables.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "OneOrSeveral{T}")]
pub(super) enum OneOrSeveral<T> {
    /// The only one.
    One(Box<T>),
    /// Several.
    Several(Vec<T>),
}

/// A single one as a table, as scenes with one always had it, and several as an array.
pub(super) fn serialize<T: Serialize, S: Serializer>(
    entries: &[T],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match entries {
        [only] => only.serialize(serializer),
        several => several.serialize(serializer),
    }
}

/// A table or an array of tables.
pub(super) fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    Ok(match OneOrSeveral::deserialize(deserializer)? {
        OneOrSeveral::One(only) => vec![*only],
        OneOrSeveral::Several(entries) => entries,
    })
}

/// The key of an entry among `count`: the word alone for the only one.
pub(super) fn entry_key(word: &str, count: usize, entry: usize) -> String {
    match count {
        1 => word.to_owned(),
        _ => format!("{word}.{entry}"),
    }
}

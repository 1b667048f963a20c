//! `/scene`: the validated input, and values at dotted key paths of a scene, such as `friction.coefficient_1.constant` or
//! `traction.0.value`.

use std::path::Path;

use contact3d::scene::{Scene, SceneFile};
use runfile::{DatasetSpec, Group, GroupWriter, Kind, Reader, StoreError};
use toml::Value;
use units::Dimension;

use super::{FormatError, Stage};

/// The validated input.
pub const GROUP: Group = Group::new("scene", Stage::Mesh.command());

const TOML: &str = "/scene/toml";

pub(super) const TABLE: &[DatasetSpec] = &[GROUP.row(
    TOML,
    Kind::Text,
    &[],
    Dimension::Number,
    "The scene as TOML with every default written out; it parses back to the same scene.",
)];

/// The canonical text of a scene that came from a text.
///
/// # Panics
/// For a scene with Rust functions, which no command of the program can be given.
pub fn text(scene: &Scene) -> String {
    let text = scene.to_toml();
    text.expect("a scene from a text holds no Rust function")
}

/// The scene as a table whose keys can be read and changed one by one: its text, with the zeros of clamps, which the text leaves
/// out.
///
/// # Panics
/// As [`text`].
pub fn table(scene: &Scene) -> toml::Table {
    table_of_text(&text(scene)).unwrap_or_default()
}

/// As [`table`], of a scene's text; `None` for a text that is no TOML.
pub fn table_of_text(text: &str) -> Option<toml::Table> {
    let mut table: toml::Table = text.parse().ok()?;
    let clamps = table.get_mut("clamp").and_then(Value::as_array_mut);
    for clamp in clamps.into_iter().flatten() {
        let held = || Value::Array(vec![Value::Float(0.0); 3]);
        if let Some(clamp) = clamp.as_table_mut() {
            clamp.entry("value").or_insert_with(held);
        }
    }
    Some(table)
}

/// Writes the scene.
pub fn write(writer: &mut GroupWriter<'_>, scene: &Scene) -> Result<(), StoreError> {
    writer.write_text(TOML, &text(scene))
}

/// Reads and validates the scene.
pub fn read(reader: &Reader, file: &Path) -> Result<SceneFile, FormatError> {
    let text = reader.read_text(TOML)?;
    let folder = file.parent().unwrap_or(Path::new("")).to_owned();
    SceneFile::parse(TOML.to_owned(), &text, folder).map_err(|e| FormatError::Scene(Box::new(e)))
}

/// Whether a file holds a scene word by word, also in what no stage depends on, such as the title.
pub fn holds(reader: &Reader, scene: &Scene) -> Result<bool, StoreError> {
    Ok(reader.read_text(TOML)? == text(scene))
}

/// Puts a value at a key path; tables that are not there are made, items of lists must be there.
///
/// # Errors
/// The part of the path that leads nowhere.
pub fn set_key(table: &mut toml::Table, key: &str, value: Value) -> Result<(), String> {
    let (first, rest) = split(key);
    match rest {
        None => {
            table.insert(first.to_owned(), value);
            Ok(())
        }
        Some(rest) => {
            let below = table
                .entry(first)
                .or_insert_with(|| Value::Table(toml::Table::new()));
            set_below(below, first, rest, value)
        }
    }
}

fn set_below(place: &mut Value, name: &str, key: &str, value: Value) -> Result<(), String> {
    match place {
        Value::Table(table) => set_key(table, key, value),
        Value::Array(items) => {
            let (first, rest) = split(key);
            let item = first.parse::<usize>().ok().and_then(|i| items.get_mut(i));
            let item = item.ok_or_else(|| format!("no item {first} in the list {name}"))?;
            match rest {
                None => *item = value,
                Some(rest) => set_below(item, first, rest, value)?,
            }
            Ok(())
        }
        _ => Err(format!("{name} is neither a table nor a list")),
    }
}

/// The value at a key path; `None` where it leads nowhere.
pub fn get_key<'a>(table: &'a toml::Table, key: &str) -> Option<&'a Value> {
    let mut parts = key.split('.');
    let mut found = table.get(parts.next()?)?;
    for part in parts {
        found = match found {
            Value::Table(table) => table.get(part)?,
            Value::Array(items) => items.get(part.parse::<usize>().ok()?)?,
            _ => return None,
        };
    }
    Some(found)
}

fn split(key: &str) -> (&str, Option<&str>) {
    match key.split_once('.') {
        Some((first, rest)) => (first, Some(rest)),
        None => (key, None),
    }
}

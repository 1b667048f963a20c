//! `/scene`: the validated input.

use std::path::Path;

use contact3d::scene::{Scene, SceneFile};
use runfile::{DatasetSpec, Group, GroupWriter, Kind, Reader, StoreError};
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
    let clamps = table.get_mut("clamp").and_then(toml::Value::as_array_mut);
    for clamp in clamps.into_iter().flatten() {
        let held = || toml::Value::Array(vec![toml::Value::Float(0.0); 3]);
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
    reader.whole_group(GROUP)?;
    let text = reader.read_text(TOML)?;
    let folder = file.parent().unwrap_or(Path::new("")).to_owned();
    SceneFile::parse(TOML.to_owned(), text, folder).map_err(|e| FormatError::Scene(Box::new(e)))
}

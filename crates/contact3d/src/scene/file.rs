//! A scene with the text it was read from.

use std::path::{Path, PathBuf};

use super::{Invalid, Scene, SceneError, read_bounded};

/// Longest scene in bytes; a friction law of 1000 × 200 values stays below.
pub const LONGEST_SCENE: u64 = 4_000_000;

/// A scene with the text it was read from, so that later errors can still show the line.
#[derive(Debug, Clone)]
pub struct SceneFile {
    /// The validated scene.
    pub scene: Scene,
    /// The folder in which mesh files are looked for.
    pub folder: PathBuf,
    /// The file, and how it was changed, for messages.
    name: String,
    /// The file itself.
    origin: String,
    text: String,
}

impl SceneFile {
    /// Reads and validates a scene, from a file or a pipe.
    ///
    /// # Errors
    /// A folder or device, a file or pipe that cannot be read, is too long or no UTF-8 text, or is
    /// no scene.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let name = path.display().to_string();
        let bytes = read_bounded(path, LONGEST_SCENE).map_err(|source| SceneError::Read {
            path: name.clone(),
            source,
        })?;
        if bytes.len() as u64 > LONGEST_SCENE {
            return Err(SceneError::TooLong {
                path: name,
                longest: LONGEST_SCENE,
            });
        }
        let text = String::from_utf8(bytes).map_err(|error| SceneError::no_text(&name, &error))?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Self::parse(name, text, folder)
    }

    /// Parses and validates a scene's text.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn parse(name: String, text: String, folder: PathBuf) -> Result<Self, SceneError> {
        Ok(Self {
            scene: Scene::parse(&name, &text)?,
            folder,
            origin: name.clone(),
            name,
            text,
        })
    }

    /// The scene with other text in its place; `changes` says, for messages, what is other than in
    /// the file.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn changed(&self, changes: &str, text: String) -> Result<Self, SceneError> {
        let name = format!("{} with {changes}", self.origin);
        Ok(Self {
            origin: self.origin.clone(),
            ..Self::parse(name, text, self.folder.clone())?
        })
    }

    /// An error that shows the line of an unusable value.
    #[must_use]
    pub fn refuse(&self, invalid: Invalid) -> SceneError {
        SceneError::invalid(&self.name, &self.text, invalid)
    }
}

use std::{
    fs,
    path::{Path, PathBuf},
};

use super::{Invalid, Scene, SceneError};

/// A scene with the text it was read from, so that later errors can still show the line.
#[derive(Debug, Clone)]
pub struct SceneFile {
    /// The validated scene.
    pub scene: Scene,
    /// The folder in which mesh files are looked for.
    pub folder: PathBuf,
    name: String,
    text: String,
}

impl SceneFile {
    /// Reads and validates a scene file.
    ///
    /// # Errors
    /// A file that cannot be read, or is no scene.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let name = path.display().to_string();
        let text = fs::read_to_string(path).map_err(|source| SceneError::Read {
            path: name.clone(),
            source,
        })?;
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
            name,
            text,
        })
    }

    /// The scene with other text in its place, such as one with changed keys.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn changed(&self, text: String) -> Result<Self, SceneError> {
        Self::parse(
            format!("{} with changes", self.name),
            text,
            self.folder.clone(),
        )
    }

    /// An error that shows the line of an unusable value.
    #[must_use]
    pub fn refuse(&self, invalid: Invalid) -> SceneError {
        SceneError::invalid(&self.name, &self.text, invalid)
    }
}

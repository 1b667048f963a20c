//! Folders for outputs, claimed before anything is computed.

use std::{
    fs::{self, File},
    io,
    path::{Path, PathBuf},
};

use super::OutputError;

/// Written and removed to see whether a folder takes files.
const PROBE: &str = ".contact3d-pipe.part";

/// A folder that is there and takes files. What was made for it vanishes again when this is dropped
/// and nothing was put there.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// The folders that were made, the innermost last.
    made: Vec<PathBuf>,
}

impl Folder {
    /// Makes a folder, with those around it, unless it is there.
    ///
    /// # Errors
    /// [`OutputError::Folder`].
    pub fn make(path: &Path) -> Result<Self, OutputError> {
        let mut folder = Self {
            path: path.to_owned(),
            made: Vec::new(),
        };
        let missing: Vec<&Path> = path
            .ancestors()
            .take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists())
            .collect();
        let refuse = |source: io::Error| OutputError::Folder {
            folder: path.to_owned(),
            found: match path.exists() && !path.is_dir() {
                true => "a file".to_owned(),
                false => source.to_string(),
            },
        };
        for missing in missing.into_iter().rev() {
            match fs::create_dir(missing) {
                Ok(()) => folder.made.push(missing.to_owned()),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists && missing.is_dir() => {}
                Err(error) => return Err(refuse(error)),
            }
        }
        let probe = path.join(PROBE);
        let probed = File::options().write(true).create_new(true).open(&probe);
        // Another process may be at the same.
        let _ = fs::remove_file(&probe);
        match probed {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => Err(refuse(error)),
            _ => Ok(folder),
        }
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        for made in self.made.iter().rev() {
            let _ = fs::remove_dir(made);
        }
    }
}

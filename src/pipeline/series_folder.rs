//! Folders of series that ParaView plays.

use std::{
    fs,
    path::{Path, PathBuf},
};

use runfile::{IfMissing, RunFile};

use super::StageError;
use crate::{
    format::SERIES_LAYOUT,
    output::{Folder, Inputs},
};

const ENDING: &str = ".vtkhdf";

/// What the series of a folder show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeriesKind {
    /// Paths of solutions, `path_1.vtkhdf` and so on.
    Paths,
    /// Cases of a sweep on a mesh, `cases_1.vtkhdf` and so on.
    Cases,
}

impl SeriesKind {
    const fn prefix(self) -> &'static str {
        match self {
            Self::Paths => "path_",
            Self::Cases => "cases_",
        }
    }

    /// The number that a file's name says; `None` for other files.
    fn number_of(self, file: &Path) -> Option<usize> {
        let name = file.file_name()?.to_str()?;
        let number = name.strip_prefix(self.prefix())?.strip_suffix(ENDING)?;
        number.parse().ok()
    }
}

/// A folder that takes series.
#[derive(Debug)]
pub struct SeriesFolder {
    folder: Folder,
    kind: SeriesKind,
    /// Series that were there before.
    old: Vec<PathBuf>,
}

impl SeriesFolder {
    /// Makes the folder unless it is there, and refuses it if a file in it has the name of a series and is none, or is an input.
    ///
    /// # Errors
    /// An unwritable folder, a foreign or busy file; nothing is changed.
    pub fn claim(path: &Path, kind: SeriesKind, inputs: &Inputs) -> Result<Self, StageError> {
        let folder = Folder::make(path)?;
        let unreadable = |source: std::io::Error| StageError::Write {
            file: path.to_owned(),
            source,
        };
        let mut old = Vec::new();
        for entry in fs::read_dir(path).map_err(unreadable)? {
            let file = entry.map_err(unreadable)?.path();
            if kind.number_of(&file).is_some() {
                inputs.refuse(&file)?;
                RunFile::lock(&file, SERIES_LAYOUT, IfMissing::Refuse)?;
                old.push(file);
            }
        }
        Ok(Self { folder, kind, old })
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The file of a series, counted from 0.
    #[must_use]
    pub fn file(&self, index: usize) -> PathBuf {
        let name = format!("{}{}{ENDING}", self.kind.prefix(), index + 1);
        self.path().join(name)
    }

    /// Removes the series that were there before and are not among these.
    ///
    /// # Errors
    /// A busy file, an unwritable folder.
    pub fn keep_only(&self, files: &[PathBuf]) -> Result<(), StageError> {
        for file in self.old.iter().filter(|file| !files.contains(file)) {
            // The lock of a file that is no more goes with it.
            let _lock = RunFile::lock(file, SERIES_LAYOUT, IfMissing::Refuse)?;
            fs::remove_file(file).map_err(|source| StageError::Write {
                file: file.clone(),
                source,
            })?;
        }
        Ok(())
    }
}

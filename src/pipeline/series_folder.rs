//! Folders of series that ParaView plays.

use std::{
    fs,
    path::{Path, PathBuf},
    time::Instant,
};

use contact3d::{mesh::Mesh, scene::InvalidValue};
use runfile::{GroupRecord, IfMissing, RunFile, Transaction};
use studies::branches::{Branches, Family};

use super::StageError;
use crate::{
    format::{self, ResultState, SERIES_LAYOUT},
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
    /// Makes the folder, where one is wanted, unless it is there, and refuses it if a file in it has the name of a series and is none,
    /// or is an input.
    ///
    /// # Errors
    /// An unwritable folder, a foreign or busy file; nothing is changed.
    pub fn claim(
        path: Option<&Path>,
        kind: SeriesKind,
        inputs: &Inputs,
    ) -> Result<Option<Self>, StageError> {
        let Some(path) = path else {
            return Ok(None);
        };
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
        Ok(Some(Self { folder, kind, old }))
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The file of a series, counted from 0.
    pub fn file(&self, index: usize) -> PathBuf {
        let name = format!("{}{}{ENDING}", self.kind.prefix(), index + 1);
        self.path().join(name)
    }

    /// Removes the series that were there before and are not among these.
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

/// Writes the series of all paths, and removes those of paths that are no more; returns the files.
///
/// # Errors
/// A parameter that changes the mesh, which a series has only one of; an unwritable folder.
pub(super) fn write_paths(
    folder: &SeriesFolder,
    family: &Family<'_>,
    branches: &Branches,
    threads: usize,
) -> Result<Vec<PathBuf>, StageError> {
    let mut files = Vec::new();
    for (k, path) in branches.paths.iter().enumerate() {
        let file = folder.file(k);
        write_path(&file, family, path, threads)?;
        files.push(file);
    }
    folder.keep_only(&files)?;
    Ok(files)
}

fn write_path(
    file: &Path,
    family: &Family<'_>,
    path: &studies::branches::Path,
    threads: usize,
) -> Result<(), StageError> {
    let started = Instant::now();
    let mesh = family.base().mesh();
    let layout = SERIES_LAYOUT.in_units(family.base().scene().units);
    let file = RunFile::lock(file, layout, IfMissing::Create)?;
    let mut transaction = Transaction::begin(&file)?;
    let mut writer = transaction.group(format::VTKHDF)?;
    let mut series = format::begin_path_series(&mut writer, mesh, path)?;
    for point in &path.points {
        let problem = family.problem_at(point.parameter)?;
        require_same_mesh(mesh, problem.mesh(), &family.range().key)?;
        let report = problem.report(&problem.state_of(point.multiplier.clone()))?;
        let contact = problem.contact_state();
        let frame = contact.map(|contact| &contact.interface.frame);
        series.step(mesh, &ResultState::from(&report), frame);
    }
    series.finish()?;
    let seconds = started.elapsed().as_secs_f64();
    let record = GroupRecord::ended(String::new(), String::new(), seconds, threads);
    writer.finish(&record)?;
    Ok(transaction.commit()?)
}

/// Refuses a parameter that moves the nodes.
pub(super) fn require_same_mesh(first: &Mesh, other: &Mesh, key: &str) -> Result<(), StageError> {
    if first.coordinates == other.coordinates && first.tetrahedra == other.tetrahedra {
        return Ok(());
    }
    Err(StageError::Setting(InvalidValue {
        key: key.to_owned(),
        expected: "a parameter that leaves the mesh as it is, for --series".into(),
        found: "one that changes it".into(),
        help: "follow the paths without --series".into(),
    }))
}

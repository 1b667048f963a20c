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

/// How the files of paths of solutions begin: `path_1.vtkhdf` and so on.
pub const PATH_SERIES: &str = "path_";

/// How those of cases of a sweep on a mesh begin.
pub const CASE_SERIES: &str = "cases_";

/// A folder that takes series.
#[derive(Debug)]
pub struct SeriesFolder {
    folder: Folder,
    /// How the names of its series begin, before their numbers.
    prefix: &'static str,
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
        prefix: &'static str,
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
            if is_series(&file, prefix) {
                inputs.refuse(&file)?;
                RunFile::lock(&file, SERIES_LAYOUT, IfMissing::Refuse)?;
                old.push(file);
            }
        }
        Ok(Some(Self {
            folder,
            prefix,
            old,
        }))
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The file of a series, counted from 0.
    pub fn file(&self, index: usize) -> PathBuf {
        let name = format!("{}{}{ENDING}", self.prefix, index + 1);
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

/// Whether a file has the name of a series: a prefix, its number and the ending.
fn is_series(file: &Path, prefix: &str) -> bool {
    let name = file.file_name().and_then(|name| name.to_str());
    let number = name.and_then(|name| name.strip_prefix(prefix)?.strip_suffix(ENDING));
    number.is_some_and(|number| number.parse::<usize>().is_ok())
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
    let mesh = family.base.mesh();
    let layout = SERIES_LAYOUT.in_units(family.base.scene().units);
    let file = RunFile::lock(file, layout, IfMissing::Create)?;
    let mut transaction = Transaction::begin(&file)?;
    let mut writer = transaction.group(format::VTKHDF)?;
    let mut series = format::begin_path_series(&mut writer, mesh, path)?;
    for point in &path.points {
        let problem = family.problem_at(point.parameter)?;
        require_same_mesh(mesh, problem.mesh(), &family.range.key)?;
        let report = problem.report(&problem.state_of(point.multiplier.clone()))?;
        let contact = problem.contact_side();
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

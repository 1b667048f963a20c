//! Paths of solutions as series that ParaView plays, one file for each path.

use std::{
    fs,
    path::{Path, PathBuf},
    time::Instant,
};

use contact3d::{
    branches::{Branches, Family},
    mesh::Mesh,
    scene::Invalid,
};
use runfile::{GroupRecord, Home, IfMissing, RunFile, Transaction, timestamp};

use super::StageError;
use crate::{
    format::{self, GridValues, SERIES_LAYOUT},
    output::{Folder, Inputs},
};

/// What the names of the files begin and end with.
const PREFIX: &str = "path_";
const ENDING: &str = ".vtkhdf";

/// A folder that takes one series for each path.
#[derive(Debug)]
pub struct SeriesFolder {
    folder: Folder,
    /// Series that were there before.
    old: Vec<PathBuf>,
}

impl SeriesFolder {
    /// Makes the folder unless it is there, and refuses it if a file in it has the name of a series and is none, or is an input.
    ///
    /// # Errors
    /// An unwritable folder, a foreign or busy file; nothing is changed.
    pub fn claim(path: &Path, inputs: &Inputs) -> Result<Self, StageError> {
        let folder = Folder::make(path)?;
        let unreadable = |source: std::io::Error| StageError::Write {
            file: path.to_owned(),
            source,
        };
        let mut old = Vec::new();
        for entry in fs::read_dir(path).map_err(unreadable)? {
            let file = entry.map_err(unreadable)?.path();
            if number_of(&file).is_some() {
                inputs.refuse(&file)?;
                RunFile::lock(&file, SERIES_LAYOUT, IfMissing::Refuse)?;
                old.push(file);
            }
        }
        Ok(Self { folder, old })
    }

    /// Writes the series of all paths, and removes those of paths that are no more; returns the files.
    ///
    /// # Errors
    /// A parameter that changes the mesh, which a series has only one of; an unwritable folder.
    pub(super) fn write(
        &self,
        family: &Family<'_>,
        branches: &Branches,
        threads: usize,
    ) -> Result<Vec<PathBuf>, StageError> {
        let mut files = Vec::new();
        for (k, path) in branches.paths.iter().enumerate() {
            let file = self
                .folder
                .path()
                .join(format!("{PREFIX}{}{ENDING}", k + 1));
            write_path(&file, family, path, threads)?;
            files.push(file);
        }
        for file in self.old.iter().filter(|file| !files.contains(file)) {
            // The lock of a file that is no more goes with it.
            let _lock = RunFile::lock(file, SERIES_LAYOUT, IfMissing::Refuse)?;
            fs::remove_file(file).map_err(|source| StageError::Write {
                file: file.clone(),
                source,
            })?;
        }
        Ok(files)
    }
}

/// The number of the path that a file's name says; `None` for other files.
fn number_of(file: &Path) -> Option<usize> {
    let name = file.file_name()?.to_str()?;
    let number = name.strip_prefix(PREFIX)?.strip_suffix(ENDING)?;
    number.parse().ok()
}

fn write_path(
    file: &Path,
    family: &Family<'_>,
    path: &contact3d::branches::Path,
    threads: usize,
) -> Result<(), StageError> {
    let started = Instant::now();
    let mesh = family.base().mesh();
    let layout = SERIES_LAYOUT.in_units(family.base().scene().units);
    let file = RunFile::lock(file, layout, IfMissing::Create)?;
    let mut transaction = Transaction::begin(&file)?;
    let mut writer = transaction.group(format::VTKHDF, Home::RunFile)?;
    let mut series = format::begin_path_series(&mut writer, mesh, path)?;
    for point in &path.points {
        let problem = family.problem_at(point.parameter)?;
        require_same_mesh(mesh, problem.mesh(), &family.range().key)?;
        let report = problem.report(&problem.state_of(point.multiplier.clone()))?;
        let contact = problem.contact_state();
        series.step(
            &GridValues::from(&report),
            contact.map(|contact| &contact.interface.frame),
        )?;
    }
    series.finish()?;
    writer.finish(&GroupRecord {
        settings: String::new(),
        input_digest: String::new(),
        seconds: started.elapsed().as_secs_f64(),
        threads: i64::try_from(threads).unwrap_or(i64::MAX),
        date: timestamp(),
    })?;
    Ok(transaction.commit()?)
}

/// Refuses a parameter that moves the nodes.
pub(super) fn require_same_mesh(first: &Mesh, other: &Mesh, key: &str) -> Result<(), StageError> {
    if first.coordinates == other.coordinates && first.tetrahedra == other.tetrahedra {
        return Ok(());
    }
    Err(StageError::Setting(Invalid {
        key: key.to_owned(),
        expected: "a parameter that leaves the mesh as it is, for --series".into(),
        found: "one that changes it".into(),
        help: "follow the paths without --series".into(),
    }))
}

//! Paths of solutions as series that ParaView plays, one file for each path.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use contact3d::{
    branches::{Branches, Family},
    mesh::Mesh,
    scene::Invalid,
};
use runfile::{GroupRecord, Home, IfMissing, RunFile, Transaction};

use super::{SeriesFolder, StageError};
use crate::format::{self, GridValues, SERIES_LAYOUT};

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
            mesh,
            &GridValues::from(&report),
            contact.map(|contact| &contact.interface.frame),
        )?;
    }
    series.finish()?;
    writer.finish(&GroupRecord::ended(
        String::new(),
        String::new(),
        started.elapsed().as_secs_f64(),
        threads,
    ))?;
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

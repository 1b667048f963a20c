//! Whole files: who wrote them, and what can be taken out.

use std::path::Path;

use hdf5_metno::{self as hdf5, types::VarLenUnicode};

use crate::{FclibError, error::InFile};

/// The attribute of the root that names the program.
pub(crate) const PROGRAM: &str = "program";

/// The groups of problems.
pub(crate) const LOCAL: &str = "fclib_local";
pub(crate) const GLOBAL: &str = "fclib_global";
pub(crate) const SOLUTION: &str = "solution";
pub(crate) const GUESSES: &str = "guesses";

pub(crate) fn open(path: &Path) -> Result<hdf5::File, FclibError> {
    hdf5::File::open(path).in_file(path, || "open the file".into())
}

/// Opens a file to write to it.
pub(crate) fn open_to_write(path: &Path) -> Result<hdf5::File, FclibError> {
    // A lock would outlive its owner in a process that is started meanwhile and inherits the file.
    let mut options = hdf5::File::with_options();
    let options = options.with_fapl(|access| access.file_locking(false));
    options
        .open_rw(path)
        .in_file(path, || "open the file to write to it".into())
}

/// The program that marked an FCLIB file as its own by [`crate::write_program`]; `None` for other files.
#[must_use]
pub fn program_of(path: &Path) -> Option<String> {
    let file = hdf5::File::open(path).ok()?;
    if !(file.link_exists(LOCAL) || file.link_exists(GLOBAL)) {
        return None;
    }
    let text: VarLenUnicode = file.attr(PROGRAM).ok()?.read_scalar().ok()?;
    Some(text.as_str().to_owned())
}

/// Removes `/solution`, if it is there; its bytes stay in the file.
///
/// # Errors
/// HDF5 failures.
pub fn remove_solution(path: &Path) -> Result<(), FclibError> {
    let file = open_to_write(path)?;
    if file.link_exists(SOLUTION) {
        let removed = file.unlink(SOLUTION);
        removed.in_file(path, || format!("remove /{SOLUTION}"))?;
    }
    file.close().in_file(path, || "close the file".into())
}

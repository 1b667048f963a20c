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
pub fn remove_solution(file: &hdf5::File) -> Result<(), FclibError> {
    if file.link_exists(SOLUTION) {
        let removed = file.unlink(SOLUTION);
        let path = file.filename();
        removed.in_file(Path::new(&path), || format!("remove /{SOLUTION}"))?;
    }
    Ok(())
}

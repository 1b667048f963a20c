//! Whole files: who wrote them, and what can be taken out.

use std::path::Path;

use hdf5_metno::{self as hdf5, types::VarLenUnicode};
use runfile::Foreign;

use crate::{FclibError, error::InFile};

/// The attribute of the root that names the program.
pub(crate) const PROGRAM: &str = "program";

/// The groups of problems.
pub(crate) const LOCAL: &str = "fclib_local";
pub(crate) const GLOBAL: &str = "fclib_global";
pub(crate) const SOLUTION: &str = "solution";
pub(crate) const GUESSES: &str = "guesses";

/// Opens a file and examines what is read of it.
pub(crate) fn open(path: &Path) -> Result<Foreign, FclibError> {
    Ok(Foreign::open(path, &[LOCAL, GLOBAL, SOLUTION, GUESSES])?)
}

/// Bytes of all that may be read of a file, once it is read.
///
/// # Errors
/// A file that cannot be opened, is damaged, or does not hold its own data.
pub fn declared_bytes(path: &Path) -> Result<u64, FclibError> {
    Ok(open(path)?.declared())
}

/// The program that marked an FCLIB file as its own by [`crate::write_program`]; `None` for other files.
#[must_use]
pub fn program_of(path: &Path) -> Option<String> {
    let opened = Foreign::open(path, &[]).ok()?;
    let file = opened.file();
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

//! What became of a case that could not be run: a text beside its run file.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// The file that holds the error of a failed case.
fn file(run_file: &Path) -> PathBuf {
    run_file.with_extension("error.txt")
}

/// The error of a failed case.
pub(super) fn read(run_file: &Path) -> Option<String> {
    fs::read_to_string(file(run_file)).ok()
}

/// Records an error in one step, so that a killed process leaves a whole text or none.
pub(super) fn record(run_file: &Path, error: &str) -> io::Result<()> {
    let temporary = run_file.with_extension("error.txt.part");
    let written = fs::write(&temporary, error);
    let written = written.and_then(|()| fs::rename(&temporary, file(run_file)));
    written.inspect_err(|_| drop(fs::remove_file(&temporary)))
}

/// Forgets the error of a case.
pub(super) fn forget(run_file: &Path) -> io::Result<()> {
    match fs::remove_file(file(run_file)) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

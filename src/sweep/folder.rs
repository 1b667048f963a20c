//! The folder of a sweep: whose tables lie there, who works in it, which cases failed. Tables of another sweep, or of nobody we
//! know, are not written over.

use std::{
    collections::BTreeSet,
    fs::{self, File, TryLockError},
    io::{self, ErrorKind, Write},
    path::{Component, Path, PathBuf},
};

use runfile::{Reader, StoreError, Temporary, is_locked, lock_file, open_plain, remove_left_overs};

use super::{
    Plan, StageError, SweepError,
    summary::{CSV_FILE, SUMMARY_FILE},
};
use crate::{
    format::{SWEEP_LAYOUT, TableOwner, read_table_owner},
    output::{self, OutputKind},
};

/// Refuses a folder whose tables are no tables of this program, or those of another sweep.
///
/// A table is this sweep's if the same sweep file wrote it, whatever its axes were then, or if all
/// its cases are in the plan.
pub(super) fn refuse_others(plan: &Plan, folder: &Path) -> Result<(), StageError> {
    let ids: BTreeSet<&str> = plan.cases.iter().map(|case| case.id.as_str()).collect();
    let file = folder.join(SUMMARY_FILE);
    plan.inputs.refuse(&file)?;
    let table = Reader::open_if_there(&file, SWEEP_LAYOUT)?;
    let table = table.map(|table| read_table_owner(&table)).transpose()?;
    if let Some(table) = &table
        && !is_own(table, &ids, &plan.sweep_file_from(folder))
    {
        return Err(StageError::from(SweepError::OthersTable {
            file,
            sweep: table.sweep_file.clone(),
        }));
    }
    let file = folder.join(CSV_FILE);
    output::admit(&file, OutputKind::SweepTable, &plan.inputs)?;
    let listed = planned_in(&file)?;
    let known = |id: &String| {
        let of_table = table.as_ref().is_some_and(|table| table.ids.contains(id));
        of_table || ids.contains(id.as_str())
    };
    if listed.is_empty() || listed.iter().any(known) {
        return Ok(());
    }
    Err(StageError::from(SweepError::OthersTable {
        file,
        sweep: String::new(),
    }))
}

fn is_own(table: &TableOwner, ids: &BTreeSet<&str>, sweep_file: &str) -> bool {
    let mut planned = table.planned.iter().map(String::as_str);
    table.sweep_file == sweep_file || planned.all(|id| ids.contains(id))
}

/// The planned cases of `summary.csv`; none if there is no such file.
fn planned_in(file: &Path) -> Result<Vec<String>, StageError> {
    let failed = |source: csv::Error| StageError::Io {
        action: "read",
        file: file.to_owned(),
        source: source.into(),
    };
    if !file.is_file() {
        return Ok(Vec::new());
    }
    let mut reader = csv::Reader::from_path(file).map_err(failed)?;
    let mut ids = Vec::new();
    for record in reader.records() {
        let record = record.map_err(failed)?;
        if record.get(1) == Some("1") {
            ids.extend(record.get(0).map(str::to_owned));
        }
    }
    Ok(ids)
}

/// The path from a folder to a file, both canonical, so that a project may move as a whole.
pub(super) fn relative(folder: &Path, file: &Path) -> PathBuf {
    let mut from = folder.components().peekable();
    let mut to = file.components().peekable();
    if from.peek() != to.peek() {
        return file.to_owned();
    }
    while from.peek().is_some() && from.peek() == to.peek() {
        from.next();
        to.next();
    }
    from.map(|_| Component::ParentDir).chain(to).collect()
}

const LOCK_FILE: &str = ".sweep.lock";

/// Waits for the turn to prepare an operator, so that of many processes one computes and the others
/// read.
pub(super) fn operator_turn(folder: &Path, key: &str) -> Result<Option<File>, StoreError> {
    let name = format!(".operator-{}.lock", key.get(..16).unwrap_or(key));
    let wait = |file: &File| file.lock().map_err(TryLockError::Error);
    lock_file(&folder.join(name), wait)
}

/// Locks a folder until the file is dropped, as `try_lock` does: for a sweep alone, or for one of several processes that run single cases,
/// whose run files have their own locks. A killed process leaves no lock.
pub(super) fn lock(
    folder: &Path,
    try_lock: fn(&File) -> Result<(), TryLockError>,
) -> Result<File, StageError> {
    let folder = folder.to_owned();
    let locked = lock_file(&folder.join(LOCK_FILE), try_lock)?;
    locked.ok_or_else(|| SweepError::Busy { folder }.into())
}

/// Whether a sweep is at work in a folder; asks, and locks nothing.
pub fn is_busy(folder: &Path) -> bool {
    is_locked(&folder.join(LOCK_FILE))
}

/// The file that holds the error of a failed case.
fn error_file(run_file: &Path) -> PathBuf {
    run_file.with_extension("error.txt")
}

/// The error of a failed case.
pub(super) fn read_failure(run_file: &Path) -> Option<String> {
    let file = open_plain(&error_file(run_file), File::options().read(true));
    io::read_to_string(file.ok()?).ok()
}

/// Records an error in one step, so that a killed process leaves a whole text or none.
pub(super) fn record_failure(run_file: &Path, error: &str) -> io::Result<()> {
    let target = error_file(run_file);
    remove_left_overs(&target);
    let create = |path: &Path| File::create_new(path).map(drop);
    let (temporary, mut file, ()) = Temporary::beside(&target, create)?;
    file.write_all(error.as_bytes())?;
    temporary.publish(&target)
}

/// Forgets the error of a case.
pub(super) fn forget_failure(run_file: &Path) -> io::Result<()> {
    match fs::remove_file(error_file(run_file)) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(sweep_file: &str, planned: &[&str]) -> TableOwner {
        let planned: Vec<String> = planned.iter().map(|id| (*id).to_owned()).collect();
        TableOwner {
            sweep_file: sweep_file.to_owned(),
            ids: planned.clone(),
            planned,
        }
    }

    #[test]
    fn a_table_belongs_to_its_sweep_file_or_to_whoever_has_all_its_cases() {
        let plan = BTreeSet::from(["a", "b"]);
        let own =
            |owner: &str, planned: &[&str]| is_own(&table(owner, planned), &plan, "../sweep.toml");
        assert!(own("../sweep.toml", &["x"]));
        assert!(own("../renamed.toml", &["a"]));
        assert!(!own("../other.toml", &["a", "x"]));
    }

    #[test]
    fn the_way_to_the_sweep_file_moves_with_the_project() {
        let path = |folder: &str, file: &str| relative(Path::new(folder), Path::new(file));
        assert_eq!(path("/a/b/out", "/a/b/s.toml"), Path::new("../s.toml"));
        assert_eq!(path("/a/out", "/b/s.toml"), Path::new("../../b/s.toml"));
        assert_eq!(path("/a", "/a/s.toml"), Path::new("s.toml"));
    }
}

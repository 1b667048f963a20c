//! The lock of a sweep's folder: one sweep, or any number of processes that run single cases.

use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;

use super::StageError;

const LOCK_FILE: &str = ".sweep.lock";

/// Who else may work in the folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Access {
    /// Nobody.
    Sweep,
    /// Others that run single cases; each run file has its own lock.
    SingleCase,
}

/// Waits for the turn to prepare an operator, so that of many processes one computes and the others
/// read.
pub(super) fn operator_turn(folder: &Path, key: &str) -> io::Result<File> {
    let name = format!(".operator-{}.lock", key.get(..16).unwrap_or(key));
    let file = File::options()
        .create(true)
        .truncate(false)
        .write(true)
        .open(folder.join(name))?;
    file.lock()?;
    Ok(file)
}

/// Locks a folder until the file is dropped; a killed process leaves no lock.
pub(super) fn lock(folder: &Path, access: Access) -> Result<File, StageError> {
    let io = |action| {
        move |source| StageError::Io {
            action,
            file: folder.to_owned(),
            source,
        }
    };
    let file = File::options()
        .create(true)
        .truncate(false)
        .write(true)
        .open(folder.join(LOCK_FILE))
        .map_err(io("open the lock file in"))?;
    let locked = match access {
        Access::Sweep => file.try_lock(),
        Access::SingleCase => file.try_lock_shared(),
    };
    match locked {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(StageError::Busy {
            folder: folder.to_owned(),
        }),
        Err(TryLockError::Error(source)) => Err(io("lock")(source)),
    }
}

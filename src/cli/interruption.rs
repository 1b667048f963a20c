//! What an interrupted command says: what is kept, and how to go on.

use std::{
    io::{self, IsTerminal},
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError, mpsc},
    thread,
    time::Duration,
};

use runfile::{Group, last_commit};

use super::terminal;

/// The run file or the folder that the program is at work on, and what it keeps; a run file keeps its stages where nothing is said.
static WORK: Mutex<Option<(PathBuf, Option<String>)>> = Mutex::new(None);

/// Says which run file is at work.
pub(super) fn on_run_file(file: &Path) {
    *work() = Some((file.to_owned(), None));
}

/// Says how many levels of an adaptive mesh the run file at work holds.
pub(super) fn levels_kept(count: usize) {
    if let Some((_, kept)) = &mut *work() {
        *kept = Some(format!("the meshes up to level {}", count - 1));
    }
}

/// Says which sweep is at work, and how many of its cases have ended.
pub(super) fn on_sweep(folder: &Path, ended: usize, cases: usize) {
    let kept = format!("all cases that ended ({ended} of {cases} in this run) and checkpoints");
    *work() = Some((folder.to_owned(), Some(kept)));
}

fn work() -> MutexGuard<'static, Option<(PathBuf, Option<String>)>> {
    WORK.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Says what is kept; called when a signal is about to end the process. Another thread writes,
/// since standard error may be blocked by a reader that has stopped.
pub(super) fn farewell() {
    let (said, wait) = mpsc::channel();
    let spawned = thread::Builder::new().spawn(move || {
        // A spinner leaves the cursor behind itself.
        let start = if io::stderr().is_terminal() { "\n" } else { "" };
        terminal::message(&format!("{start}{}", words()));
        let _ = said.send(());
    });
    if spawned.is_ok() {
        // How long a blocked standard error may hold up the end of the process.
        let _ = wait.recv_timeout(Duration::from_millis(300));
    }
}

fn words() -> String {
    let Some((file, kept)) = work().clone() else {
        return "interrupted".into();
    };
    let kept = kept.or_else(|| last_commit().map(|(_, groups)| names(&groups)));
    let state = match kept {
        Some(kept) => format!("{} keeps {kept}", file.display()),
        None if file.exists() => format!("{} is as it was", file.display()),
        None => return "interrupted: nothing was stored yet".into(),
    };
    format!("interrupted: {state}; the same command goes on from there")
}

fn names(groups: &[Group]) -> String {
    let names: Vec<&str> = groups.iter().map(|group| group.name()).collect();
    names.join(", ")
}

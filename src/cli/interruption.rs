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

/// What the program is at work on.
#[derive(Debug, Clone)]
enum CurrentWork {
    /// The stages of a run file.
    RunFile(PathBuf),
    /// The levels of an adaptive mesh of a run file, and how many of them it holds.
    Levels(PathBuf, usize),
    /// The cases of a sweep: its folder, how many have ended, how many there are.
    Sweep(PathBuf, usize, usize),
}

static WORK: Mutex<Option<CurrentWork>> = Mutex::new(None);

/// How an adaptive run ends with results in time.
const BUDGET: &str =
    "a run with --budget SECONDS ends by itself, with the results of the last level that fits";

/// Says which run file is at work.
pub(super) fn on_run_file(file: &Path) {
    *work() = Some(CurrentWork::RunFile(file.to_owned()));
}

/// Says which run file is at work on an adaptive mesh.
pub(super) fn on_levels(file: &Path) {
    *work() = Some(CurrentWork::Levels(file.to_owned(), 0));
}

/// Says how many levels the run file holds.
pub(super) fn levels_kept(count: usize) {
    if let Some(CurrentWork::Levels(_, kept)) = &mut *work() {
        *kept = count;
    }
}

/// Says which sweep is at work.
pub(super) fn on_sweep(folder: &Path, cases: usize) {
    *work() = Some(CurrentWork::Sweep(folder.to_owned(), 0, cases));
}

/// Counts a case of the sweep that has ended.
pub(super) fn case_ended() {
    if let Some(CurrentWork::Sweep(_, ended, _)) = &mut *work() {
        *ended += 1;
    }
}

fn work() -> MutexGuard<'static, Option<CurrentWork>> {
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
    let work = work().clone();
    let kept = match &work {
        None => return "interrupted".into(),
        Some(CurrentWork::Sweep(folder, ended, cases)) => format!(
            "{} keeps all cases that ended ({ended} of {cases} in this run) and checkpoints",
            folder.display()
        ),
        Some(CurrentWork::Levels(file, kept @ 1..)) => {
            return format!(
                "interrupted: {} keeps the meshes up to level {}; the same command goes on from there, and {BUDGET}",
                file.display(),
                kept - 1
            );
        }
        Some(CurrentWork::Levels(file, _)) if file.exists() => {
            return format!("interrupted: {} is as it was; {BUDGET}", file.display());
        }
        Some(CurrentWork::Levels(..)) => {
            return format!("interrupted: nothing was stored yet; {BUDGET}");
        }
        Some(CurrentWork::RunFile(file)) => match last_commit() {
            Some((_, groups)) => format!("{} keeps {}", file.display(), names(&groups)),
            None if file.exists() => format!("{} is as it was", file.display()),
            None => return "interrupted: nothing was stored yet".into(),
        },
    };
    format!("interrupted: {kept}; the same command goes on from there")
}

fn names(groups: &[Group]) -> String {
    let names: Vec<&str> = groups.iter().map(|group| group.name()).collect();
    names.join(", ")
}

//! What is said while stages are at work: spinners, one line for each stage done, and what an interrupted command keeps.

use std::{
    fmt::Write,
    io::{self, IsTerminal},
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc},
    thread,
    time::{Duration, Instant},
};

use contact3d::{
    RunStep,
    dual::OperatorEstimate,
    linalg::{Precision, RemoteFactor, Work},
    solver::Progress,
};
use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use runfile::{Group, last_commit};
use studies::StudyStep;

use super::{arguments::Output, terminal};
use crate::{pipeline::StageTiming, report::shown_time};

/// Starts a spinner with the elapsed time on a terminal; elsewhere, and when quiet, nothing.
pub(super) fn spinner(name: &'static str, output: &Output) -> ProgressBar {
    // The bar has a thread of its own, and ends the program where the system does not give it.
    let has_thread = || {
        thread::Builder::new()
            .spawn(|| ())
            .is_ok_and(|it| it.join().is_ok())
    };
    if output.quiet || !io::stderr().is_terminal() || !has_thread() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {prefix:<9} {elapsed} {msg}") {
        bar.set_style(style);
    }
    bar.set_prefix(name);
    bar.enable_steady_tick(Duration::from_millis(250));
    bar
}

/// Lets a spinner say what a stage is at, and says where a load history goes on.
pub(super) fn show(spinner: &ProgressBar, output: &Output, step: RunStep<'_>) {
    match step {
        RunStep::Resuming(last, [done, of]) => spinner.suspend(|| {
            let (step, time) = (last.step + 1, shown_time(last.time));
            let line = format!(
                "solve     goes on after increment {done} of {of} (step {step}, time {time} s)"
            );
            terminal::say(output, &line);
        }),
        RunStep::Assembling(step) => spinner.set_message(step),
        RunStep::Counting(step, work) => count(spinner, step, work),
        RunStep::Solving(None, progress) => spinner.set_message(words(progress)),
        RunStep::Solving(Some(increment), progress) => spinner.set_message(format!(
            "load step {}, increment {}: {}",
            increment.step + 1,
            increment.number,
            words(progress)
        )),
    }
}

/// Lets a spinner say how far a step is whose operations are counted, and when it will end, as long as it is at work.
fn count(spinner: &ProgressBar, step: &'static str, work: &Arc<Work>) {
    let (work, started) = (work.clone(), Instant::now());
    let counted = move || words_of(work.share(), started.elapsed().as_secs_f64());
    say_with(spinner, step.to_owned(), counted);
}

/// Lets a spinner say some words and others that change while it spins.
fn say_with(
    spinner: &ProgressBar,
    words: String,
    changing: impl Fn() -> String + Clone + Send + Sync + 'static,
) {
    let Ok(style) = ProgressStyle::with_template("{spinner} {prefix:<9} {elapsed} {msg}{changing}")
    else {
        return;
    };
    let changing = move |_: &ProgressState, text: &mut dyn Write| {
        let _ = text.write_str(&changing());
    };
    spinner.set_style(style.with_key("changing", changing));
    spinner.set_message(words);
}

/// Lets a spinner say what a study is at, and shows its first figures as soon as they are there.
pub(super) fn show_study(spinner: &ProgressBar, output: &Output, step: StudyStep) {
    match step {
        StudyStep::Begin(words) => spinner.set_message(words),
        StudyStep::Figure(text) => spinner.suspend(|| terminal::say(output, &text)),
    }
}

/// Lets a spinner say which piece of how many a study is at, and count down the time that was left at some time.
pub(super) fn piece(
    spinner: &ProgressBar,
    words: &str,
    [number, of]: [usize; 2],
    seconds_left: Option<f64>,
    then: Instant,
) {
    let left = move || {
        let left = seconds_left.map(|seconds| seconds - then.elapsed().as_secs_f64());
        let left = left.filter(|left| *left >= 0.5);
        left.map_or_else(String::new, |left| format!(", about {left:.0} s left"))
    };
    say_with(spinner, format!("{number} of {of}: {words}"), left);
}

/// How far a step is, and the time left if it goes on as it did; empty once nothing of it is left.
fn words_of(share: f64, seconds: f64) -> String {
    match share {
        1.0 => String::new(),
        // Seconds after which the time left of counted work is worth saying.
        share if share > 0.0 && seconds >= 1.0 => {
            let left = seconds * (1.0 - share) / share;
            format!(", {:.0} %, about {left:.0} s left", 100.0 * share)
        }
        share => format!(", {:.0} %", 100.0 * share),
    }
}

/// One line per stage done.
pub(super) fn stage_line(performed: &StageTiming) -> String {
    let stage = performed.stage.word();
    let computed = format!("{stage:<9} done in {:.3} s", performed.compute_seconds);
    match performed.store_seconds {
        0.0 => format!("{computed}, stored with the next stage"),
        seconds => format!("{computed}, stored in {seconds:.3} s"),
    }
}

/// How the dual operator is held, and what either form costs.
pub(super) fn operator_line(
    estimate: &OperatorEstimate,
    dense: bool,
    precision: Precision,
) -> String {
    let share = precision.bytes() as f64 / Precision::Double.bytes() as f64;
    format!(
        "{:<9} {} (dense: {:.1} MB and {:.2e} operations to form; factor: {:.1} MB in {} precision, {:.2e} operations per application)",
        "dual",
        if dense { "explicit" } else { "implicit" },
        estimate.forming_bytes(precision) / 1e6,
        estimate.explicit_operations,
        share * estimate.factor_bytes / 1e6,
        precision.word(),
        estimate.action_operations,
    )
}

/// What an engine says of the factor that it holds.
pub(super) fn engine_line(factor: &RemoteFactor) -> String {
    let report = factor.report();
    let [largest, all] = [report.largest_process, report.bytes].map(|bytes| bytes as f64 / 1e9);
    format!(
        "{:<9} {} holds {:.2e} coefficients of the factor in {all:.1} GB, {largest:.1} GB in its largest process",
        "engine",
        factor.name(),
        report.coefficients as f64,
    )
}

/// Progress of a solve.
fn words(progress: Progress<'_>) -> String {
    match progress {
        Progress::Outer(k, step) => {
            format!(
                "outer step {}, change {:.1e}, {} applications",
                k + 1,
                step.change,
                step.applications
            )
        }
        Progress::Newton(k, step) => {
            let how = if step.safeguard {
                "safeguard"
            } else {
                "Newton"
            };
            format!("{how} step {}, residual {:.1e}", k + 1, step.residual)
        }
        Progress::Between(_) => String::new(),
    }
}

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
        terminal::message(&format!("{start}{}", words_of_interruption()));
        let _ = said.send(());
    });
    if spawned.is_ok() {
        // How long a blocked standard error may hold up the end of the process.
        let _ = wait.recv_timeout(Duration::from_millis(300));
    }
}

fn words_of_interruption() -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counted_work_ends_when_what_is_left_takes_as_long_as_its_share() {
        assert_eq!(words_of(0.25, 6.0), ", 25 %, about 18 s left");
        assert_eq!(words_of(0.25, 0.5), ", 25 %");
        assert_eq!(words_of(0.0, 6.0), ", 0 %");
        assert_eq!(words_of(1.0, 6.0), "");
    }
}

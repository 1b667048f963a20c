//! What is said while stages are at work: spinners, forecasts, one line for each stage done.

use std::{
    fmt::Write,
    sync::Arc,
    time::{Duration, Instant},
};

use contact3d::{
    RunStep,
    dual::OperatorEstimate,
    linalg::{Precision, RemoteFactor, Work},
    solver::Progress,
};
use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use studies::StudyStep;

use super::{arguments::Output, terminal};
use crate::pipeline::StageTiming;

/// Steps that a forecast looks back on: enough to even out, few enough to follow.
const WINDOW: usize = 4;

/// Starts a spinner with the elapsed time on a terminal; elsewhere, and when quiet, nothing.
pub(super) fn spinner(name: &'static str, output: &Output) -> ProgressBar {
    if output.quiet {
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

/// Lets a spinner say what a stage is at.
pub(super) fn show(spinner: &ProgressBar, forecast: &mut Forecast, step: RunStep<'_>) {
    match step {
        RunStep::Assembling(step) => spinner.set_message(step),
        RunStep::Counting(step, work) => count(spinner, step, work),
        RunStep::Solving(None, progress) => {
            spinner.set_message(words(progress) + &forecast.words(progress));
        }
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
    let Ok(style) = ProgressStyle::with_template("{spinner} {prefix:<9} {elapsed} {msg}{counted}")
    else {
        return;
    };
    let counted = move |_: &ProgressState, text: &mut dyn Write| {
        let _ = text.write_str(&words_of(work.share(), started.elapsed().as_secs_f64()));
    };
    spinner.set_style(style.with_key("counted", counted));
    spinner.set_message(step);
}

/// Lets a spinner say what a study is at, and shows its first figures as soon as they are there.
pub(super) fn show_study(spinner: &ProgressBar, output: &Output, step: StudyStep) {
    match step {
        StudyStep::Piece {
            words,
            number,
            of,
            seconds_left,
        } => piece(spinner, &words, [number, of], seconds_left, Instant::now()),
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
    let Ok(style) = ProgressStyle::with_template("{spinner} {prefix:<9} {elapsed} {msg}{left}")
    else {
        return;
    };
    let left = move |_: &ProgressState, text: &mut dyn Write| {
        let left = seconds_left.map(|seconds| seconds - then.elapsed().as_secs_f64());
        if let Some(left) = left.filter(|left| *left >= 0.5) {
            let _ = write!(text, ", about {left:.0} s left");
        }
    };
    spinner.set_style(style.with_key("left", left));
    spinner.set_message(format!("{number} of {of}: {words}"));
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

/// When successive approximations will end, if their changes go on to fall as they do.
#[derive(Debug)]
pub(super) struct Forecast {
    epsilon: f64,
    /// Change and seconds of the last steps.
    steps: Vec<(f64, f64)>,
}

impl Forecast {
    /// Of a solve to the relative accuracy ε.
    pub(super) fn new(epsilon: f64) -> Self {
        Self {
            epsilon,
            steps: Vec::new(),
        }
    }

    /// The time left in words; empty as long as it cannot be known.
    pub(super) fn words(&mut self, progress: Progress<'_>) -> String {
        let Progress::Outer(_, step) = progress else {
            return String::new();
        };
        match self.seconds_left(step.change, step.seconds) {
            Some(seconds) => format!(", about {seconds:.0} s left"),
            None => String::new(),
        }
    }

    /// Linear convergence: the change falls by the same factor in each step.
    fn seconds_left(&mut self, change: f64, seconds: f64) -> Option<f64> {
        self.steps.push((change, seconds));
        let first = self.steps.len().checked_sub(WINDOW + 1)?;
        let (earlier, _) = self.steps[first];
        let recent = &self.steps[first + 1..];
        let mean = recent.iter().map(|(_, seconds)| seconds).sum::<f64>() / WINDOW as f64;
        let rate = (change / earlier).ln() / WINDOW as f64;
        let steps = ((self.epsilon / change).ln() / rate).ceil();
        (rate < 0.0 && steps.is_finite()).then(|| steps.max(0.0) * mean)
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
            let how = if step.fallback { "safeguard" } else { "Newton" };
            let law = match step.law_share {
                1.0 => String::new(),
                share => format!(", law F^{share:.3}"),
            };
            format!("{how} step {}, residual {:.1e}{law}", k + 1, step.residual)
        }
        Progress::Between(_) => String::new(),
    }
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

    #[test]
    fn changes_that_fall_tenfold_end_when_expected() {
        let mut forecast = Forecast::new(1e-8);
        let left: Vec<_> = (1..=6)
            .map(|k| forecast.seconds_left(0.9 * 10.0_f64.powi(-k), 2.0))
            .collect();
        assert_eq!(left, [None, None, None, None, Some(6.0), Some(4.0)]);
    }

    #[test]
    fn nothing_is_promised_where_changes_do_not_fall() {
        for change in [1.0, f64::NAN] {
            let mut forecast = Forecast::new(1e-8);
            let left: Vec<_> = (0..9).map(|_| forecast.seconds_left(change, 1.0)).collect();
            assert!(left.iter().all(Option::is_none), "{change}: {left:?}");
        }
    }
}

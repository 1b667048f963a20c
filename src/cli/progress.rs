use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::arguments::Output;
use crate::store::Stage;

/// Starts a spinner with the elapsed time on a terminal; elsewhere, and when quiet, nothing.
pub(super) fn spinner(stage: Stage, output: &Output) -> ProgressBar {
    if output.quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {prefix:<9} {elapsed} {msg}") {
        bar.set_style(style);
    }
    bar.set_prefix(stage.group());
    bar.enable_steady_tick(Duration::from_millis(250));
    bar
}

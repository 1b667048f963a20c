//! `bound`: a bound of the discretisation error of a solved run file, stored and printed.

use std::path::PathBuf;

use clap::Args;

use super::{arguments::Output, exit::Exit, progress, study};
use crate::{
    pipeline::{StageError, bound_error},
    report,
};

/// Arguments of `bound`.
#[derive(Debug, Args)]
pub struct BoundArguments {
    /// The run file, solved
    pub file: PathBuf,
}

/// `bound`: computes, stores and prints.
pub(super) fn bound(
    arguments: &BoundArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    let spinner = progress::spinner("bound", output);
    let bounded = bound_error(&arguments.file, threads);
    spinner.finish_and_clear();
    let (scene, bound, estimate) = bounded?;
    let figures = report::bound::figures(&bound, &scene, estimate);
    study::finish(
        output,
        None,
        scene.units,
        |_| Ok(Vec::new()),
        || figures.json(),
        || figures.text(0, 28),
    )?;
    Ok(Exit::Done)
}

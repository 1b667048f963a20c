//! `report`: one HTML page.

use std::path::PathBuf;

use clap::Args;

use super::{
    arguments::Output,
    exit::Exit,
    terminal::{self, say},
};
use crate::{
    output::{self, Inputs, OutputFile, OutputKind},
    pipeline::StageError,
    views::{ReportKind, report, sweep_table},
};

/// Arguments of `report`.
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// A run file, or the folder of a sweep
    pub input: PathBuf,
    /// The page to write
    #[arg(default_value = "report.html")]
    pub page: PathBuf,
    /// The body in 3D, with fields, increments or cases, and panes at hand, by one script in the page
    #[arg(long)]
    pub interactive: bool,
}

/// `report`: one HTML page; reads only and takes no lock.
pub(super) fn report_page(
    arguments: &ReportArguments,
    output: &Output,
) -> Result<Exit, StageError> {
    let inputs = Inputs::of([arguments.input.clone(), sweep_table(&arguments.input)]);
    output::admit(&arguments.page, OutputKind::Page, &inputs)?;
    let kind = if arguments.interactive {
        ReportKind::Interactive
    } else {
        ReportKind::Still
    };
    let page = OutputFile {
        path: arguments.page.clone(),
        kind: OutputKind::Page,
        bytes: report(&arguments.input, kind)?.into_bytes(),
    };
    let bytes = page.bytes.len();
    output::write(&[page], &inputs)?;
    if output.json {
        let summary = serde_json::json!({ "report": arguments.page, "bytes": bytes });
        terminal::json(&summary);
    } else {
        say(output, &terminal::wrote(&arguments.page, bytes as u64));
    }
    Ok(Exit::Done)
}

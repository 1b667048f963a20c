//! `report` and `export`: a page about a run file, and files for other programs.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::{
    arguments::Output,
    exit::Exit,
    terminal::{self, say},
};
use crate::{
    exchange::{export as write_problem, export_grid},
    output::{self, Inputs, OutputFile, OutputKind},
    pipeline::StageError,
    views::{report, sweep_table},
};

/// Arguments of `report`.
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// A run file, or the folder of a sweep
    pub input: PathBuf,
    /// The page to write
    #[arg(default_value = "report.html")]
    pub page: PathBuf,
    /// The body in 3D, with fields, increments, and panes at hand, by one script in the page
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
    let page = OutputFile {
        path: arguments.page.clone(),
        kind: OutputKind::Page,
        bytes: report(&arguments.input, arguments.interactive)?.into_bytes(),
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

/// Arguments of `export`.
#[derive(Debug, Args)]
pub struct ExportArguments {
    /// A solved run file
    pub file: PathBuf,
    /// The file to write
    pub target: PathBuf,
    /// What it is to be
    #[arg(long, value_enum)]
    pub kind: ExportKind,
}

/// What a run file is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ExportKind {
    /// Grid and fields for ParaView and PyVista, which go by the ending .vtkhdf
    Vtkhdf,
    /// The frictional contact problem of the contacts alone (dense), for the Friction Contact Library
    Fclib,
    /// The same with the unknowns of the body (sparse)
    FclibGlobal,
}

/// `export`: reads only, takes no lock, writes one file.
pub(super) fn export(arguments: &ExportArguments, output: &Output) -> Result<Exit, StageError> {
    let (file, target) = (&arguments.file, &arguments.target);
    match arguments.kind {
        ExportKind::Vtkhdf => grid(file, target, output),
        ExportKind::Fclib => problem(file, target, false, output),
        ExportKind::FclibGlobal => problem(file, target, true, output),
    }
}

fn grid(run_file: &Path, target: &Path, output: &Output) -> Result<Exit, StageError> {
    let bytes = export_grid(run_file, target)?;
    if output.json {
        terminal::json(&serde_json::json!({ "vtkhdf": target, "bytes": bytes }));
        return Ok(Exit::Done);
    }
    say(output, &terminal::wrote(target, bytes));
    Ok(Exit::Done)
}

fn problem(
    run_file: &Path,
    target: &Path,
    global: bool,
    output: &Output,
) -> Result<Exit, StageError> {
    let exported = write_problem(run_file, target, global)?;
    if output.json {
        terminal::json(&serde_json::json!({
            "fclib": target,
            "form": if global { "global" } else { "local" },
            "contacts": exported.contacts,
            "unknowns": exported.unknowns,
            "mu": exported.mu,
            "error": exported.error,
            "bytes": exported.bytes,
        }));
        return Ok(Exit::Done);
    }
    // As many digits as anyone measures; means of coefficients end in 0.30000000000000004.
    let [least, most] = exported
        .mu
        .map(|mu| format!("{mu:.5e}").parse().unwrap_or(mu));
    let contacts = exported.contacts;
    say(output, &terminal::wrote(target, exported.bytes as u64));
    let mu = format!("mu {least} to {most}");
    if let Some(unknowns) = exported.unknowns {
        let words = format!("global problem: {contacts} contacts, {unknowns} unknowns, {mu}");
        say(output, &words);
    }
    if let Some(error) = exported.error {
        let error = format!("error of the solution {error:.1e}");
        let words = format!("local problem: {contacts} contacts, {mu}, {error}");
        say(output, &words);
    }
    Ok(Exit::Done)
}

//! `report` and `export`: a page about a run file, and files for other programs.

use std::path::Path;

use clap::ValueEnum;
use serde_json::json;

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

/// `report`: one HTML page; reads only and takes no lock.
pub(super) fn report_page(
    input: &Path,
    path: &Path,
    is_interactive: bool,
    output: &Output,
) -> Result<Exit, StageError> {
    let inputs = Inputs::of([input.to_owned(), sweep_table(input)]);
    output::admit(path, OutputKind::Page, &inputs)?;
    let page = OutputFile {
        path: path.to_owned(),
        kind: OutputKind::Page,
        bytes: report(input, is_interactive)?.into_bytes(),
    };
    let bytes = page.bytes.len() as u64;
    output::write(&[page], &inputs)?;
    let summary = json!({ "report": path, "bytes": bytes });
    terminal::wrote(output, path, bytes, &summary);
    Ok(Exit::Done)
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
pub(super) fn export(
    file: &Path,
    target: &Path,
    kind: ExportKind,
    output: &Output,
) -> Result<Exit, StageError> {
    match kind {
        ExportKind::Vtkhdf => {
            let bytes = export_grid(file, target)?;
            let summary = json!({ "vtkhdf": target, "bytes": bytes });
            terminal::wrote(output, target, bytes, &summary);
            Ok(Exit::Done)
        }
        ExportKind::Fclib => problem(file, target, false, output),
        ExportKind::FclibGlobal => problem(file, target, true, output),
    }
}

fn problem(
    run_file: &Path,
    target: &Path,
    global: bool,
    output: &Output,
) -> Result<Exit, StageError> {
    let exported = write_problem(run_file, target, global)?;
    let summary = json!({
        "fclib": target,
        "form": if global { "global" } else { "local" },
        "contacts": exported.contacts,
        "unknowns": exported.unknowns,
        "mu": exported.mu,
        "error": exported.error,
        "bytes": exported.bytes,
    });
    terminal::wrote(output, target, exported.bytes as u64, &summary);
    if output.json {
        return Ok(Exit::Done);
    }
    // As many digits as anyone measures; means of coefficients end in 0.30000000000000004.
    let [least, most] = exported.mu.map(|mu| units::rounded(mu, 6));
    let contacts = exported.contacts;
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

//! `export`: frictional contact problems in the files of FCLIB, grids in files for viewers.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};

use super::{
    arguments::Output,
    exit::Exit,
    terminal::{self, say},
};
use crate::{
    exchange::{FclibForm, export as write_problem, export_grid},
    pipeline::StageError,
};

/// Arguments of `export`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("target").required(true).args(["fclib", "vtkhdf"]))]
pub struct ExportArguments {
    /// A solved run file
    pub file: PathBuf,
    /// A file of FCLIB, the Friction Contact Library, with the frictional contact problem
    #[arg(long, value_name = "FILE")]
    pub fclib: Option<PathBuf>,
    /// Write the problem with the unknowns of the body (sparse), not that of the contacts alone (dense)
    #[arg(long, conflicts_with = "vtkhdf")]
    pub global: bool,
    /// A file for ParaView and PyVista, which holds their part of the run file alone; name it NAME.vtkhdf
    #[arg(long, value_name = "FILE")]
    pub vtkhdf: Option<PathBuf>,
}

/// `export`: reads only, takes no lock, writes one file.
pub(super) fn export(arguments: &ExportArguments, output: &Output) -> Result<Exit, StageError> {
    match (&arguments.fclib, &arguments.vtkhdf) {
        (Some(target), _) => export_problem(arguments, target, output),
        (None, Some(target)) => grid(&arguments.file, target, output),
        (None, None) => Ok(Exit::BadInput),
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

fn export_problem(
    arguments: &ExportArguments,
    target: &Path,
    output: &Output,
) -> Result<Exit, StageError> {
    let form = if arguments.global {
        FclibForm::Global
    } else {
        FclibForm::Local
    };
    let exported = write_problem(&arguments.file, target, form)?;
    if output.json {
        terminal::json(&serde_json::json!({
            "fclib": target,
            "form": match form { FclibForm::Local => "local", FclibForm::Global => "global" },
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

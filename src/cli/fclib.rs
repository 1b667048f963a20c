//! `export` and `solve-fclib`: frictional contact problems in the files of FCLIB, grids in files for viewers.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args, ValueEnum};
use contact3d::solver::{
    DelassusMethod, DelassusSettings, DelassusSolution, DelassusSolver, DelassusStatus, Obstruction,
};
use units::{Dimension, Units};

use super::{
    arguments::Output,
    exit::Exit,
    progress,
    terminal::{self, say},
};
use crate::{
    exchange::{
        FclibAnswer, FclibForm, SolutionFile, export as write_problem, export_grid, solve_file,
    },
    pipeline::StageError,
    report::{
        Digits::{Fixed, Scientific},
        Figures,
    },
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

/// Arguments of `solve-fclib`.
#[derive(Debug, Args)]
pub struct SolveFclibArguments {
    /// A file with /fclib_local in 3D
    pub file: PathBuf,
    /// Write a copy of the file with the solution
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Put the solution into the file itself, in place of the one that is there
    #[arg(long, conflicts_with = "out")]
    pub in_place: bool,
    /// The algorithm: auto, newton (dense or sparse as W is), gpcg or nsgs
    #[arg(long, value_enum, default_value_t = MethodArgument::Auto)]
    pub method: MethodArgument,
    /// Largest error, as fc3d_compute_error of Siconos measures it
    #[arg(long, default_value_t = 1e-10, value_parser = tolerance)]
    pub tolerance: f64,
}

/// How to solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MethodArgument {
    /// Gauss-Seidel while it converges fast, then Newton's method, then GPCG
    Auto,
    /// Newton's method
    Newton,
    /// Successive approximations with GPCG
    Gpcg,
    /// Nonlinear Gauss-Seidel, contact by contact
    Nsgs,
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("expected a number between 0 and 1".into()),
    }
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

/// `solve-fclib`: solves, stores where asked, and says how good the forces are.
pub(super) fn solve_fclib(
    arguments: &SolveFclibArguments,
    output: &Output,
) -> Result<Exit, StageError> {
    let target = match (&arguments.out, arguments.in_place) {
        (Some(path), _) => SolutionFile::Copy(path.clone()),
        (None, true) => SolutionFile::InPlace,
        (None, false) => SolutionFile::Nowhere,
    };
    let settings = DelassusSettings {
        method: match arguments.method {
            MethodArgument::Auto => DelassusMethod::Auto,
            MethodArgument::Newton => DelassusMethod::Newton,
            MethodArgument::Gpcg => DelassusMethod::Gpcg,
            MethodArgument::Nsgs => DelassusMethod::Nsgs,
        },
        tolerance: arguments.tolerance,
    };
    let spinner = progress::spinner("solve-fclib", output);
    let answer = solve_file(&arguments.file, &target, &settings);
    spinner.finish_and_clear();
    let answer = answer?;
    let figures = figures(&answer);
    terminal::print(output, || figures.json(), || figures.text(0, 33));
    let stored = match &target {
        SolutionFile::Nowhere => None,
        SolutionFile::Copy(path) => Some(path),
        SolutionFile::InPlace => Some(&arguments.file),
    };
    if let Some(path) = stored {
        say(output, &format!("wrote {}", path.display()));
    }
    if answer.solution.status == DelassusStatus::Converged {
        return Ok(Exit::Done);
    }
    terminal::message(&failure(&answer.solution));
    Ok(Exit::NotConverged)
}

/// What did not work, and what is known about why.
fn failure(solution: &DelassusSolution) -> String {
    let word = status_word(solution.status);
    let error = solution.worst_error();
    let why = solution.separation.as_ref().map(|separation| {
        let contacts = contacts_of(&separation.direction);
        match separation.obstruction {
            Obstruction::Penetration => format!(
                "; no forces keep these {contacts} contacts from penetrating, whatever the friction: \
                 normal forces p with W p = 0 and p.q < 0 prove it"
            ),
            Obstruction::Sticking => format!(
                "; whether there is a solution is not known, but no solution lets these {contacts} contacts stick: \
                 forces p within friction with W p = 0 and p.q < 0 prove it"
            ),
        }
    });
    format!(
        "NOT CONVERGED: {word}, error {error:.1e}{}",
        why.unwrap_or_default()
    )
}

fn contacts_of(direction: &[f64]) -> usize {
    let contacts = direction.chunks_exact(3);
    contacts.filter(|p| p.iter().any(|p| *p != 0.0)).count()
}

fn obstruction_word(obstruction: Obstruction) -> &'static str {
    match obstruction {
        Obstruction::Penetration => "penetration",
        Obstruction::Sticking => "sticking",
    }
}

fn status_word(status: DelassusStatus) -> &'static str {
    match status {
        DelassusStatus::Converged => "converged",
        DelassusStatus::NotConverged => "not_converged",
        DelassusStatus::NoSolution => "no_solution",
        DelassusStatus::NumericalError => "numerical_error",
    }
}

fn solver_word(solver: DelassusSolver) -> &'static str {
    match solver {
        DelassusSolver::Newton => "newton",
        DelassusSolver::Gpcg => "gpcg",
        DelassusSolver::Nsgs => "nsgs",
    }
}

/// What came of a problem.
fn figures(answer: &FclibAnswer) -> Figures {
    let solution = &answer.solution;
    let (status, solver) = (status_word(solution.status), solver_word(solution.solver));
    let obstruction = solution.separation.as_ref().map(|separation| {
        serde_json::json!({
            "kind": obstruction_word(separation.obstruction),
            "direction": separation.direction,
            "force_bound": Some(separation.force_bound).filter(|bound| bound.is_finite()),
        })
    });
    let mut figures = Figures::new(Units::SI);
    let before = "error of the solution in the file";
    figures.number("error_before", before, Scientific(1), answer.error_before);
    figures.plain("contacts", "contacts", answer.contacts);
    figures.plain("entries", "entries of W", answer.entries);
    let ended = Some(format!("{status} by {solver}"));
    figures.described("status", "status", ended, status);
    figures.json_only("solver", solver);
    figures.add("seconds", "time", Dimension::Time, Fixed(3), answer.seconds);
    figures.plain("newton_steps", "Newton steps", solution.newton_steps);
    figures.plain("outer_steps", "outer steps", solution.outer_steps);
    let applications = "applications of W";
    figures.plain("applications", applications, solution.applications);
    figures.number("error", "error", Scientific(1), solution.error);
    let scaled = "error scaled to a unit diagonal";
    figures.number("scaled_error", scaled, Scientific(1), solution.scaled_error);
    figures.json_only("obstruction", obstruction);
    figures
}

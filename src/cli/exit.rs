use std::process::{ExitCode, Termination};

use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};

use super::arguments::Output;
use crate::{stages::StageError, sweep::SweepError};

/// How the program ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Everything that was asked for is done.
    Done = 0,
    /// The solver did not converge; what it found is stored with its status.
    NotConverged = 1,
    /// Unusable or stale input; nothing on disk was changed.
    BadInput = 2,
    /// A fault of the program itself.
    Internal = 3,
}

impl Termination for Exit {
    fn report(self) -> ExitCode {
        ExitCode::from(self as u8)
    }
}

/// Prints an error once, with its causes, and chooses the exit code.
pub(super) fn explain(error: StageError, output: &Output) -> Exit {
    let exit = if error.is_internal() {
        Exit::Internal
    } else {
        Exit::BadInput
    };
    if output.json {
        let message = serde_json::json!({ "error": chain(&error), "exit_code": exit as u8 });
        println!("{message}");
    }
    match &error {
        StageError::Scene(scene) => draw(scene),
        StageError::Mesh(mesh) => draw(mesh),
        other => eprintln!("error: {}", chain(other)),
    }
    exit
}

/// Prints what stopped a sweep, and chooses the exit code.
pub(super) fn explain_sweep(error: SweepError, output: &Output) -> Exit {
    match error {
        SweepError::Stage(error) => explain(error, output),
        SweepError::Scene(error) => explain(error.into(), output),
        error => {
            let message = chain(&error);
            if output.json {
                println!(
                    "{}",
                    serde_json::json!({ "error": message, "exit_code": 2 })
                );
            }
            eprintln!("error: {message}");
            Exit::BadInput
        }
    }
}

/// Draws the offending line of a scene, and says what to do about a scene or a mesh.
fn draw(error: &dyn Diagnostic) {
    let theme = if std::io::IsTerminal::is_terminal(&std::io::stderr()) {
        GraphicalTheme::unicode()
    } else {
        GraphicalTheme::unicode_nocolor()
    };
    let mut text = String::new();
    match GraphicalReportHandler::new_themed(theme).render_report(&mut text, error) {
        Ok(()) => eprint!("error:{text}"),
        Err(_) => eprintln!("error: {error}"),
    }
}

/// An error and its causes, each said once.
fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let message = error.to_string();
        if !text.contains(&message) {
            text = format!("{text}: {message}");
        }
        cause = error.source();
    }
    text
}

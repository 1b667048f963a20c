//! Exit codes, and errors in words.

use std::{
    io::{self, IsTerminal},
    process::{ExitCode, Termination},
};

use contact3d::scene::escape_control_lines;
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};

use super::{arguments::Output, terminal};
use crate::pipeline::StageError;

/// How the program ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Everything that was asked for is done.
    Done = 0,
    /// The solver did not converge, or the machine failed midway; what was found is stored, and said.
    NotConverged = 1,
    /// Unusable or stale input, and nothing on disk was changed; or pictures that cannot be written, and results are stored.
    BadInput = 2,
    /// A fault of the program itself, or a standard output that does not take the results.
    Internal = 3,
}

impl Exit {
    /// [`Self::Done`], or [`Self::NotConverged`] where something did not converge.
    pub(super) fn of(is_converged: bool) -> Self {
        match is_converged {
            true => Self::Done,
            false => Self::NotConverged,
        }
    }
}

impl Termination for Exit {
    fn report(self) -> ExitCode {
        ExitCode::from(self as u8)
    }
}

/// Prints an error once, with its causes, and chooses the exit code.
pub(super) fn explain(error: StageError, output: &Output) -> Exit {
    let exit = match &error {
        error if error.is_internal() => Exit::Internal,
        error if error.is_after_storing() => Exit::NotConverged,
        _ => Exit::BadInput,
    };
    json_refusal(output.json, &chain(&error), exit);
    match &error {
        StageError::Scene(scene) => draw(scene),
        StageError::Mesh(mesh) => draw(mesh),
        other => terminal::message(&format!("error: {}", chain(other))),
    }
    exit
}

/// Draws the offending line of a scene, and says what to do about a scene or a mesh.
///
/// Colours are control characters themselves, so a drawing that quotes other ones is in black and white.
fn draw(error: &dyn Diagnostic) {
    let render = |theme| {
        let mut text = String::from("error:");
        let drawn = GraphicalReportHandler::new_themed(theme).render_report(&mut text, error);
        drawn.map_or_else(|_| format!("error: {error}"), |()| text)
    };
    let plain = render(GraphicalTheme::unicode_nocolor());
    let is_harmless = escape_control_lines(&plain) == plain;
    if is_harmless && io::stderr().is_terminal() {
        terminal::coloured_message(&render(GraphicalTheme::unicode()));
    } else {
        terminal::message(&plain);
    }
}

/// Prints what the parser of the command line has to say, help and version included, and chooses the exit code.
pub(super) fn explain_usage(error: clap::Error) -> Exit {
    let printed = error.print();
    if !error.use_stderr() {
        if let Err(failure) = printed {
            terminal::lose(failure);
        }
        return Exit::Done;
    }
    json_refusal(
        asks_for_json(),
        error.to_string().trim_end(),
        Exit::BadInput,
    );
    Exit::BadInput
}

/// Says why nothing can be done at all, before the arguments are known.
pub(super) fn refuse(message: &str) -> Exit {
    json_refusal(asks_for_json(), message, Exit::BadInput);
    terminal::message(&format!("error: {message}"));
    Exit::BadInput
}

/// Whether programs read the output, as long as the arguments are not known.
fn asks_for_json() -> bool {
    std::env::args_os().any(|argument| argument == "--json")
}

/// The error for programs, where they read the output.
fn json_refusal(is_read: bool, message: &str, exit: Exit) {
    if is_read {
        terminal::json(&serde_json::json!({ "error": message, "exit_code": exit as u8 }));
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

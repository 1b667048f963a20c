//! The only module that writes to standard output and standard error. It never panics: a reader
//! that goes away ends nothing, and a standard output that takes no more is reported at the end,
//! when all files are written.

use std::{
    fmt::Write as _,
    io::{self, ErrorKind, Write},
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

use contact3d::scene::{Warning, escape_control_lines, is_hidden_control};

use super::{arguments::Output, exit::Exit};

/// What kept results from standard output; nothing more is written there once it is set.
static LOST: Mutex<Option<io::Error>> = Mutex::new(None);

/// Results for people, on standard output; a missing end of line is added.
pub(super) fn result(text: &str) {
    write_out(&line(escape_control_lines(text)));
}

/// Results for programs, on standard output.
pub(super) fn json(value: &serde_json::Value) {
    write_out(&line(escaped_json(&format!("{value:#}"))));
}

/// Results for programs or for people, as they are asked for.
pub(super) fn print(
    output: &Output,
    for_programs: impl FnOnce() -> serde_json::Value,
    for_people: impl FnOnce() -> String,
) {
    if output.json {
        json(&for_programs());
    } else if !output.quiet {
        result(&for_people());
    }
}

/// A message on standard error. Nobody may be there to read it, which stops no work.
pub(super) fn message(text: &str) {
    let _ = io::stderr().write_all(line(escape_control_lines(text)).as_bytes());
}

/// A message that has the colours of a terminal; the caller has escaped what is not ours.
pub(super) fn coloured_message(text: &str) {
    let _ = io::stderr().write_all(line(text.to_owned()).as_bytes());
}

/// A line for the person at the terminal, on standard error.
pub(super) fn say(output: &Output, text: &str) {
    if !output.quiet {
        message(text);
    }
}

/// A line about the work, for who asks for more.
pub(super) fn detail(output: &Output, text: &str) {
    if output.verbose {
        say(output, text);
    }
}

/// Names the files that a command has written.
pub(super) fn written<'a>(output: &Output, files: impl IntoIterator<Item = &'a PathBuf>) {
    let files: Vec<&PathBuf> = files.into_iter().collect();
    for file in &files {
        say(output, &format!("wrote {}", file.display()));
    }
    if output.json {
        json(&serde_json::json!({ "written": files }));
    }
}

/// Says how many files of a kind went into a folder.
pub(super) fn say_files(output: &Output, kind: &str, files: &[PathBuf], folder: &Path) {
    let folder = folder.display();
    say(
        output,
        &format!("{kind:<9} {} files in {folder}", files.len()),
    );
}

/// What a command has written: for programs as they know it, or the file and its size.
pub(super) fn wrote(output: &Output, file: &Path, bytes: u64, for_programs: &serde_json::Value) {
    if output.json {
        return json(for_programs);
    }
    let megabytes = bytes as f64 / 1e6;
    say(
        output,
        &format!("wrote {} ({megabytes:.2} MB)", file.display()),
    );
}

/// Lines about what is allowed and probably not meant, on standard error.
pub(super) fn warn(output: &Output, warnings: &[Warning]) {
    for warning in warnings {
        say(output, &format!("warning: {warning}"));
    }
}

fn lost() -> MutexGuard<'static, Option<io::Error>> {
    LOST.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Remembers that standard output failed.
pub(super) fn lose(error: io::Error) {
    lost().get_or_insert(error);
}

/// The exit code of the program, once all its work is done: that of the work, unless results are
/// missing on a standard output that failed. A reader that has gone, as in `status FILE | head -1`,
/// wants no more and is no failure.
pub(super) fn close(exit: Exit) -> Exit {
    match (lost().as_ref(), exit) {
        (None, _) => exit,
        (Some(error), _) if error.kind() == ErrorKind::BrokenPipe => exit,
        (Some(error), _) => {
            message(&format!(
                "error: cannot write the results to standard output: {error}; the files that the command writes are complete"
            ));
            match exit {
                Exit::Done | Exit::NotConverged => Exit::Internal,
                Exit::BadInput | Exit::Internal => exit,
            }
        }
    }
}

fn write_out(text: &str) {
    if lost().is_some() {
        return;
    }
    let mut out = io::stdout().lock();
    if let Err(error) = out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        lose(error);
    }
}

fn line(mut text: String) -> String {
    if !text.ends_with('\n') {
        text.push('\n');
    }
    text
}

/// JSON in which control characters that JSON allows in strings are written with their numbers.
fn escaped_json(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if is_hidden_control(c) && c != '\n' {
            let _ = write!(shown, "\\u{:04x}", u32::from(c));
        } else {
            shown.push(c);
        }
    }
    shown
}

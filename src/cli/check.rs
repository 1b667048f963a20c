//! `check`: whether every stage of a file is what was written.

use runfile::Reader;

use super::{
    arguments::{Output, StageArguments},
    exit::Exit,
    terminal::{self, say},
};
use crate::{
    format::{self, LAYOUT},
    pipeline::{StageError, contradictions},
};

/// `check`: whether every stage of a file is what was written; reads only and takes no lock.
pub(super) fn check(arguments: &StageArguments, output: &Output) -> Result<Exit, StageError> {
    let problems = format::problems(&Reader::open(&arguments.file, LAYOUT)?);
    let mut problems: Vec<String> = problems.iter().map(ToString::to_string).collect();
    if problems.is_empty() {
        problems = contradictions(&arguments.file)?;
    }
    if output.json {
        terminal::json(&serde_json::json!({ "problems": problems }));
    }
    for problem in &problems {
        terminal::message(&format!("error: {problem}"));
    }
    if problems.is_empty() {
        say(output, "every dataset is what was written");
        return Ok(Exit::Done);
    }
    Ok(Exit::BadInput)
}

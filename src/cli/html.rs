use std::fs;

use super::{
    arguments::{Output, ReportArguments},
    exit::Exit,
    terminal::{self, say},
};
use crate::stages::{StageError, report};

/// `report`: one HTML page; reads only and takes no lock.
pub(super) fn report_page(
    arguments: &ReportArguments,
    output: &Output,
) -> Result<Exit, StageError> {
    let page = report(&arguments.input)?;
    fs::write(&arguments.out, &page).map_err(|source| StageError::WriteReport {
        file: arguments.out.clone(),
        source,
    })?;
    if output.json {
        let summary = serde_json::json!({ "report": arguments.out, "bytes": page.len() });
        terminal::json(&summary);
    } else {
        let megabytes = page.len() as f64 / 1e6;
        let line = format!("wrote {} ({megabytes:.2} MB)", arguments.out.display());
        say(output, &line);
    }
    Ok(Exit::Done)
}

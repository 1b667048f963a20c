//! The report and the pictures of a sweep: its table, and charts of what varies in it.

use std::path::{Path, PathBuf};

use plots::html::{Page, Part, Section, Table};

use super::{
    PictureFolder,
    report::footer,
    sweep_charts::charts,
    sweep_table::{SweepTable, rounded},
};
use crate::pipeline::StageError;

/// The name of the table.
const SUMMARY: &str = "summary.csv";

/// The table of a sweep's folder.
#[must_use]
pub fn sweep_table(folder: &Path) -> PathBuf {
    folder.join(SUMMARY)
}

/// Draws what varies in the table of a sweep's folder, SVG and PNG; returns the files.
///
/// # Errors
/// A folder without that table, a folder for pictures that cannot be written.
pub fn draw_sweep(sweep: &Path, figures: &PictureFolder) -> Result<Vec<PathBuf>, StageError> {
    let table = SweepTable::read(&sweep_table(sweep))?;
    let charts = charts(&table).into_iter();
    figures.save_charts(charts.map(|drawn| (drawn.column, drawn.chart)))
}

/// The page of a folder with a `summary.csv`.
///
/// # Errors
/// A folder without that table, or one that is no table.
pub(super) fn page(folder: &Path) -> Result<Page, StageError> {
    let table = SweepTable::read(&sweep_table(folder))?;
    let charts = charts(&table);
    let mut sections = Vec::new();
    if !charts.is_empty() {
        let figures = charts
            .iter()
            .map(|drawn| Part::Figure(drawn.chart.figure().svg()));
        sections.push(Section {
            name: "charts",
            heading: "What varies".into(),
            parts: figures.collect(),
        });
    }
    let rows = table.rows.iter();
    sections.push(Section {
        name: "summary",
        heading: "Runs".into(),
        parts: vec![Part::Table(Table {
            caption: format!("Rounded; {SUMMARY} has every digit."),
            head: table.titles(),
            rows: rows
                .map(|row| row.iter().map(|cell| rounded(cell)).collect())
                .collect(),
        })],
    });
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    Ok(Page {
        title: format!("Sweep {name}"),
        subtitle: format!("{} runs", table.rows.len()),
        footer: footer(folder),
        sections,
    })
}

//! The report and the pictures of a sweep: its table, and charts of what varies in it.

use std::path::{Path, PathBuf};

use super::{
    StageError,
    picture::save_charts,
    report::footer,
    sweep_charts::charts,
    sweep_table::{SweepTable, rounded},
};
use crate::report::{Page, Part, Section, Table};

/// The table of a sweep's folder.
const SUMMARY: &str = "summary.csv";

/// Draws what varies in the table of a sweep's folder, SVG and PNG; returns the files.
///
/// # Errors
/// A folder without that table, a folder for pictures that cannot be written.
pub fn draw_sweep(sweep: &Path, figures: &Path) -> Result<Vec<PathBuf>, StageError> {
    let table = SweepTable::read(&sweep.join(SUMMARY))?;
    let charts = charts(&table);
    save_charts(
        figures,
        charts.into_iter().map(|drawn| (drawn.column, drawn.chart)),
    )
}

/// The page of a folder with a `summary.csv`.
///
/// # Errors
/// A folder without that table, or one that is no table.
pub(super) fn page(folder: &Path) -> Result<Page, StageError> {
    let table = SweepTable::read(&folder.join(SUMMARY))?;
    let charts = charts(&table);
    let mut sections = Vec::new();
    if !charts.is_empty() {
        let figures = charts.iter().map(|drawn| Part::Figure(drawn.chart.svg()));
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

//! The report and the pictures of a sweep: its table, and charts of what varies in it.

use std::path::{Path, PathBuf};

use plots::html::{Page, PagePart, PageTable, Section};
use runfile::Reader;

use super::{PictureFolder, report::footer, sweep_charts::charts, sweep_table::rounded};
use crate::{
    format::SWEEP_LAYOUT,
    pipeline::StageError,
    report::{Column, SweepTable},
};

/// The table of a sweep's folder.
pub fn sweep_table(folder: &Path) -> PathBuf {
    folder.join("summary.h5")
}

fn read(folder: &Path) -> Result<SweepTable, StageError> {
    let reader = Reader::open(&sweep_table(folder), SWEEP_LAYOUT)?;
    Ok(SweepTable::read(&reader)?)
}

/// Draws what varies in the table of a sweep's folder, SVG and PNG; returns the files.
pub fn draw_sweep(sweep: &Path, figures: &PictureFolder) -> Result<Vec<PathBuf>, StageError> {
    let table = read(sweep)?;
    figures.save_charts(charts(&table))
}

/// The page of a folder with a `summary.h5`.
pub(super) fn page(folder: &Path) -> Result<Page, StageError> {
    let table = read(folder)?;
    let charts = charts(&table);
    let mut sections = Vec::new();
    if !charts.is_empty() {
        let figures = charts.iter().map(|(_, chart)| PagePart::chart(chart));
        sections.push(Section::new("charts", "What varies", figures.collect()));
    }
    let row = |case: usize| {
        let cells = table.columns.iter().map(|column| &column.cells[case]);
        cells.map(rounded).collect()
    };
    let cases = PagePart::Table(PageTable {
        caption: "Rounded; summary.csv has every digit.".to_owned(),
        head: table.columns.iter().map(Column::title).collect(),
        rows: (0..table.n_cases).map(row).collect(),
    });
    sections.push(Section::new("summary", "Runs", vec![cases]));
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    Ok(Page {
        title: format!("Sweep {name}"),
        subtitle: format!("{} runs", table.n_cases),
        footer: footer(folder),
        sections,
    })
}

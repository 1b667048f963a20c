//! `summary.csv`: the table of a sweep for spreadsheets.

use std::path::Path;

use units::Units;

use super::{CSV_FILE, Plan, StageError};
use crate::{
    output::{self, OutputFile, OutputKind},
    report::SweepTable,
};

/// The last columns, so that every row says what its numbers are in.
const UNIT_COLUMNS: [&str; 4] = ["length_unit", "force_unit", "stress_unit", "energy_unit"];

/// Writes the table of some cases: texts of the user with their control characters escaped, numbers in the shortest
/// form that reads back to the same bits, nothing where a case has no result.
pub(super) fn write(plan: &Plan, folder: &Path, table: &SweepTable) -> Result<(), StageError> {
    let path = folder.join(CSV_FILE);
    let failed = |source: csv::Error| StageError::Csv {
        file: path.clone(),
        source,
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names = table
        .columns
        .iter()
        .map(|column| as_text(column.name.clone()));
    let head = names.chain(UNIT_COLUMNS.map(str::to_owned));
    writer.write_record(head).map_err(failed)?;
    for row in 0..table.n_cases {
        let cells = table.columns.iter().map(|column| match &column.cells[row] {
            cell if cell.is_word() => as_text(cell.text()),
            cell => cell.text(),
        });
        let record = cells.chain(unit_cells(table.units));
        writer.write_record(record).map_err(failed)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| failed(error.into_error().into()))?;
    let table = OutputFile {
        path,
        kind: OutputKind::SweepTable,
        bytes,
    };
    Ok(output::write(&[table], &plan.inputs)?)
}

/// The words for the units of each row's results.
fn unit_cells(units: Units) -> [String; UNIT_COLUMNS.len()] {
    [
        units.length().to_owned(),
        units.force().to_owned(),
        units.stress(),
        units.energy(),
    ]
}

/// What begins a formula in a spreadsheet.
const FORMULA: [char; 4] = ['=', '+', '-', '@'];

/// A text with the apostrophe that spreadsheets know it by where they would compute it.
fn as_text(text: String) -> String {
    if text.starts_with(FORMULA) {
        format!("'{text}")
    } else {
        text
    }
}

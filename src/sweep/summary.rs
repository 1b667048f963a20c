//! The tables of a sweep: `summary.h5` and `summary.csv`.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use contact3d::{adaptation::AdaptiveStatus, scene::unit_of_key};
use runfile::{GroupRecord, IfMissing, Reader, RunFile, Transaction};
use units::Units;

use super::{
    Plan, StageError, folder,
    plan::{UNITS_KEY, as_json},
};
use crate::{
    format::{self, CaseRow, LAYOUT, SWEEP_LAYOUT, get_key, scene_table_of_text},
    output::{self, OutputFile, OutputKind},
    report::{SweepTable, failure},
};

/// Name of the table for h5py in the sweep's folder.
pub const SUMMARY_FILE: &str = "summary.h5";
/// Name of the table for spreadsheets.
pub const CSV_FILE: &str = "summary.csv";

/// Writes both tables from the run files of a folder: the cases of the plan in its order, then older
/// ones in the same units. Returns the planned cases whose solve did not
/// converge, or whose mesh does not meet its target, with their status.
pub fn write(plan: &Plan, folder: &Path) -> Result<Vec<(usize, String)>, StageError> {
    folder::refuse_others(plan, folder)?;
    let rows = rows(plan, folder)?;
    write_table(plan, folder, &rows)?;
    let reader = Reader::open(&folder.join(SUMMARY_FILE), SWEEP_LAYOUT)?;
    write_csv(plan, folder, &SweepTable::read(&reader)?)?;
    // The planned cases come first, in the order of the plan.
    let planned = plan.cases.iter().zip(&rows).enumerate();
    let not_converged = planned.filter_map(|(number, (case, row))| {
        let results = row.results.as_ref()?;
        if !results.status.is_success(&case.scene.scene.solve) {
            return Some((number, results.status.word().to_owned()));
        }
        let target = results
            .adaptation
            .filter(|status| *status != AdaptiveStatus::Met)?;
        Some((number, target.word().to_owned()))
    });
    Ok(not_converged.collect())
}

fn rows(plan: &Plan, folder: &Path) -> Result<Vec<CaseRow>, StageError> {
    let mut rows = Vec::new();
    for case in &plan.cases {
        let file = case.file(folder);
        rows.push(row(plan, &case.id, &case.settings, true, &file)?);
    }
    let planned: BTreeSet<&str> = plan.cases.iter().map(|case| case.id.as_str()).collect();
    for (id, file) in run_files(folder)? {
        if planned.contains(id.as_str()) {
            continue;
        }
        let scene = Reader::open(&file, LAYOUT).and_then(|reader| reader.read_text("/scene/toml"));
        let Some(table) = scene.ok().and_then(|text| scene_table_of_text(&text)) else {
            continue;
        };
        if units(&table) != plan.units {
            continue;
        }
        let value = |key: &String| Some((key.clone(), get_key(&table, key)?.clone()));
        let settings: Vec<(String, toml::Value)> = plan.keys.iter().filter_map(value).collect();
        // What is damaged and not planned is no reason to lose the table of what is.
        let old = row(plan, &id, &settings, false, &file).ok();
        rows.extend(old.filter(|old| old.results.is_some()));
    }
    Ok(rows)
}

/// The units that a stored scene names.
fn units(scene: &toml::Table) -> Units {
    let named = scene.get(UNITS_KEY).cloned();
    named.map_or(Units::SI, |named| named.try_into().unwrap_or_default())
}

/// All run files of a folder with their names, sorted.
fn run_files(folder: &Path) -> Result<Vec<(String, PathBuf)>, StageError> {
    let entries = fs::read_dir(folder).map_err(|source| StageError::Io {
        action: "list the folder",
        file: folder.to_owned(),
        source,
    })?;
    let mut files: Vec<(String, PathBuf)> = entries
        .filter_map(|entry| {
            let name = entry.ok()?.file_name().into_string().ok()?;
            let id = name.strip_suffix(".h5")?;
            let is_case = id.bytes().all(|c| c.is_ascii_hexdigit());
            is_case.then(|| (id.to_owned(), folder.join(&name)))
        })
        .collect();
    files.sort();
    Ok(files)
}

fn row(
    plan: &Plan,
    id: &str,
    settings: &[(String, toml::Value)],
    planned: bool,
    file: &Path,
) -> Result<CaseRow, StageError> {
    let error = folder::read_failure(file);
    let results = match error {
        Some(_) => None,
        None => match Reader::open_if_there(file, LAYOUT)? {
            Some(reader) => format::read_case(&reader)?,
            None => None,
        },
    };
    let status = match (&results, &error) {
        (_, Some(_)) => "failed",
        (Some(results), None) => results.status.word(),
        (None, None) => "missing",
    };
    let solved = results.as_ref();
    let why = || solved.and_then(|it| failure(it.status, it.accuracy));
    // An older case may leave a key out.
    let value = |key: &String| settings.iter().find(|(name, _)| name == key);
    let number_at = |key: &String| value(key).map_or(f64::NAN, |(_, value)| number(value));
    Ok(CaseRow {
        id: id.to_owned(),
        planned,
        settings: as_json(settings).to_string(),
        setting_values: plan.keys.iter().map(number_at).collect(),
        status: status.to_owned(),
        error: error.or_else(why).unwrap_or_default(),
        results,
    })
}

/// The number of a setting; NaN for what is none.
pub(super) fn number(value: &toml::Value) -> f64 {
    match value {
        toml::Value::Float(float) => *float,
        toml::Value::Integer(integer) => *integer as f64,
        _ => f64::NAN,
    }
}

fn write_table(plan: &Plan, folder: &Path, rows: &[CaseRow]) -> Result<(), StageError> {
    let layout = SWEEP_LAYOUT.in_units(plan.units);
    let file = RunFile::lock(&folder.join(SUMMARY_FILE), layout, IfMissing::Create)?;
    let mut transaction = Transaction::begin(&file)?;
    let mut writer = transaction.group(format::CASES)?;
    let sweep_file = plan.sweep_file_from(folder);
    let units = plan.keys.iter().map(|key| unit_of_key(key, plan.units));
    let units: Vec<String> = units.map(|unit| unit.word().to_owned()).collect();
    let keys = [plan.keys.as_slice(), &units];
    format::write_cases(&mut writer, &sweep_file, keys, rows)?;
    writer.finish(&GroupRecord::gathered(String::new()))?;
    Ok(transaction.commit()?)
}

/// The last columns, so that every row says what its numbers are in.
const UNIT_COLUMNS: [&str; 4] = ["length_unit", "force_unit", "stress_unit", "energy_unit"];

/// Writes the table of some cases: texts of the user with their control characters escaped, numbers in the shortest
/// form that reads back to the same bits, nothing where a case has no result.
fn write_csv(plan: &Plan, folder: &Path, table: &SweepTable) -> Result<(), StageError> {
    let path = folder.join(CSV_FILE);
    let failed = |source: csv::Error| StageError::Io {
        action: "write",
        file: path.clone(),
        source: source.into(),
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

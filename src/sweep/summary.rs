//! The tables of a sweep: `summary.h5` and `summary.csv`.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use contact3d::{
    adaptation::AdaptiveStatus,
    solver::{Goal, Status},
};
use runfile::{GroupRecord, Home, IfMissing, Reader, RunFile, StoreError, Transaction, timestamp};
use units::Units;

use super::{Plan, SweepError, failure, keys, ownership, plan::UNITS_KEY};
use crate::{
    format::{self, CERTIFICATE, CaseResults, CaseRow, LAYOUT, SWEEP_LAYOUT},
    output::{self, Kind, OutputFile},
};

/// Name of the table for h5py in the sweep's folder.
pub const SUMMARY_FILE: &str = "summary.h5";
/// Name of the table for spreadsheets.
pub const CSV_FILE: &str = "summary.csv";

/// The last columns, so that every row says what its numbers are in.
const UNIT_COLUMNS: [&str; 4] = ["length_unit", "force_unit", "stress_unit", "energy_unit"];

/// Writes both tables from the run files of a folder: the cases of the plan in its order, then older
/// ones in the same units. Returns how many planned cases have a solve that did not converge.
///
/// # Errors
/// Tables that cannot be written, a run file with altered results.
pub fn write(plan: &Plan, folder: &Path) -> Result<usize, SweepError> {
    ownership::refuse_others(plan, folder)?;
    let rows = rows(plan, folder)?;
    write_table(plan, folder, &rows)?;
    write_csv(plan, folder, &rows)?;
    // The planned cases come first, in the order of the plan.
    let planned = plan.cases.iter().zip(&rows);
    let solved = planned.filter_map(|(case, row)| Some((case, row.results.as_ref()?)));
    let not_converged = solved.filter(|(case, results)| {
        let goal = Goal::of(&case.scene.scene.solve);
        let is_met = results
            .adaptation
            .is_none_or(|status| status == AdaptiveStatus::Met);
        let status = Status::of_word(&results.status);
        !(is_met && status.is_some_and(|status| status.is_success(goal)))
    });
    Ok(not_converged.count())
}

fn rows(plan: &Plan, folder: &Path) -> Result<Vec<CaseRow>, SweepError> {
    let mut rows = Vec::new();
    for case in &plan.cases {
        rows.push(row(&case.id, &case.settings, true, &case.file(folder))?);
    }
    let planned: BTreeSet<&str> = plan.cases.iter().map(|case| case.id.as_str()).collect();
    for (id, file) in run_files(folder)? {
        if planned.contains(id.as_str()) {
            continue;
        }
        let scene = Reader::open(&file, LAYOUT).and_then(|reader| reader.read_text("/scene/toml"));
        let Some(table) = scene.ok().and_then(|text| text.parse::<toml::Table>().ok()) else {
            continue;
        };
        if units(&table) != plan.units {
            continue;
        }
        let settings: Vec<(String, toml::Value)> = plan
            .keys
            .iter()
            .filter_map(|key| Some((key.clone(), keys::get(&table, key)?.clone())))
            .collect();
        // What is damaged and not planned is no reason to lose the table of what is.
        let old = row(&id, &settings, false, &file).ok();
        rows.extend(old.filter(|old| old.results.is_some()));
    }
    for row in &mut rows {
        row.setting_values.resize(plan.keys.len(), f64::NAN);
    }
    Ok(rows)
}

/// The units that a stored scene names.
fn units(scene: &toml::Table) -> Units {
    let named = scene.get(UNITS_KEY).cloned();
    named.map_or(Units::SI, |named| named.try_into().unwrap_or_default())
}

/// All run files of a folder with their names, sorted.
fn run_files(folder: &Path) -> Result<Vec<(String, PathBuf)>, SweepError> {
    let entries = fs::read_dir(folder).map_err(|source| SweepError::Io {
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
    id: &str,
    settings: &[(String, toml::Value)],
    planned: bool,
    file: &Path,
) -> Result<CaseRow, SweepError> {
    let error = failure::read(file);
    let results = match error {
        Some(_) => None,
        None => match Reader::open(file, LAYOUT) {
            Ok(reader) => format::read_case(&reader)?,
            Err(StoreError::NotFound { .. }) => None,
            Err(other) => return Err(other.into()),
        },
    };
    let status = match (&results, &error) {
        (_, Some(_)) => "failed",
        (Some(results), None) => &results.status,
        (None, None) => "missing",
    };
    let object: serde_json::Map<String, serde_json::Value> = settings
        .iter()
        .map(|(key, value)| (key.clone(), serde_json::json!(value)))
        .collect();
    Ok(CaseRow {
        id: id.to_owned(),
        planned,
        settings: serde_json::Value::Object(object).to_string(),
        setting_values: settings.iter().map(|(_, value)| number(value)).collect(),
        status: status.to_owned(),
        error: error.unwrap_or_default(),
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

fn write_table(plan: &Plan, folder: &Path, rows: &[CaseRow]) -> Result<(), SweepError> {
    let layout = SWEEP_LAYOUT.in_units(plan.units);
    let file = RunFile::lock(&folder.join(SUMMARY_FILE), layout, IfMissing::Create)?;
    let mut transaction = Transaction::begin(&file)?;
    let mut writer = transaction.group(format::CASES, Home::RunFile)?;
    let sweep_file = plan.sweep_file_from(folder);
    format::write_cases(&mut writer, sweep_file.as_deref(), &plan.keys, rows)?;
    writer.finish(&GroupRecord {
        settings: String::new(),
        input_digest: String::new(),
        seconds: 0.0,
        threads: 1,
        date: timestamp(),
    })?;
    Ok(transaction.commit()?)
}

fn write_csv(plan: &Plan, folder: &Path, rows: &[CaseRow]) -> Result<(), SweepError> {
    let path = folder.join(CSV_FILE);
    let failed = |source: csv::Error| SweepError::Csv {
        file: path.clone(),
        source,
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header(plan)).map_err(failed)?;
    for row in rows {
        writer.write_record(record(plan, row)).map_err(failed)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| failed(error.into_error().into()))?;
    let table = OutputFile {
        path,
        kind: Kind::SweepTable,
        bytes,
    };
    Ok(output::write(&[table], &plan.inputs)?)
}

fn header(plan: &Plan) -> Vec<String> {
    let mut names = vec!["id".to_owned(), "planned".to_owned()];
    names.extend(plan.keys.iter().cloned());
    let results = [
        "status",
        "error",
        "method",
        "outer_steps",
        "newton_steps",
        "actions",
        "seconds",
        "accuracy",
        "open",
        "stick",
        "slip",
        "normal_force",
        "tangential_force_1",
        "tangential_force_2",
        "contact_force_x",
        "contact_force_y",
        "contact_force_z",
        "largest_pressure",
        "largest_displacement_x",
        "largest_displacement_y",
        "largest_displacement_z",
        "strain_energy",
    ];
    names.extend(results.map(str::to_owned));
    names.extend(CERTIFICATE.map(|name| format!("certificate_{name}")));
    names.push("solve_digest".to_owned());
    names.extend(UNIT_COLUMNS.map(str::to_owned));
    names
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

fn record(plan: &Plan, row: &CaseRow) -> Vec<String> {
    let settings: serde_json::Value = serde_json::from_str(&row.settings).unwrap_or_default();
    let mut cells = vec![row.id.clone(), u8::from(row.planned).to_string()];
    cells.extend(plan.keys.iter().map(|key| match &settings[key] {
        serde_json::Value::String(text) => text.clone(),
        serde_json::Value::Null => String::new(),
        value => value.to_string(),
    }));
    cells.extend([row.status.clone(), row.error.clone()]);
    match &row.results {
        Some(results) => cells.extend(result_cells(results)),
        None => cells.resize(header(plan).len() - UNIT_COLUMNS.len(), String::new()),
    }
    cells.extend(unit_cells(plan.units));
    cells
}

/// The cells after status and error; numbers in the shortest form that reads back to the same bits.
fn result_cells(results: &CaseResults) -> Vec<String> {
    let mut cells = vec![results.method.clone()];
    cells.extend(results.counts.map(|count| count.to_string()));
    let measure = |value: f64| match value.is_nan() {
        true => String::new(),
        false => format!("{value:?}"),
    };
    cells.extend([results.seconds, results.accuracy].map(measure));
    cells.extend(results.zones.map(|count| match count {
        -1 => String::new(),
        count => count.to_string(),
    }));
    cells.push(measure(results.normal_force));
    cells.extend(results.tangential_force.map(measure));
    cells.extend(results.contact_force.map(measure));
    cells.push(measure(results.largest_pressure));
    cells.extend(results.largest_displacement.map(measure));
    cells.push(measure(results.strain_energy));
    cells.extend(results.certificate.map(measure));
    cells.push(results.solve_digest.clone());
    cells
}

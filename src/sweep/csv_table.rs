//! `summary.csv`: the table of a sweep for spreadsheets.

use std::path::Path;

use contact3d::scene::shown;
use units::Units;

use super::{CSV_FILE, Plan, SweepError};
use crate::{
    format::{self, CERTIFICATE, CaseFace, CaseResults, CaseRow},
    output::{self, Kind, OutputFile},
};

/// The last columns, so that every row says what its numbers are in.
const UNIT_COLUMNS: [&str; 4] = ["length_unit", "force_unit", "stress_unit", "energy_unit"];

/// Results of each of several contact faces.
const FACE_COLUMNS: [&str; 7] = [
    "open",
    "stick",
    "slip",
    "normal_force",
    "tangential_force_1",
    "tangential_force_2",
    "largest_pressure",
];

/// Writes the table of some cases.
///
/// # Errors
/// A table that cannot be written.
pub(super) fn write(plan: &Plan, folder: &Path, rows: &[CaseRow]) -> Result<(), SweepError> {
    let path = folder.join(CSV_FILE);
    let failed = |source: csv::Error| SweepError::Csv {
        file: path.clone(),
        source,
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    let faces = format::case_face_names(
        rows.iter()
            .filter_map(|row| Some(&row.results.as_ref()?.faces[..])),
    );
    writer.write_record(header(plan, &faces)).map_err(failed)?;
    for row in rows {
        writer
            .write_record(record(plan, &faces, row))
            .map_err(failed)?;
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

/// The titles of the columns; results of each of several contact faces end in its name.
fn header(plan: &Plan, faces: &[String]) -> Vec<String> {
    let mut names = vec!["id".to_owned(), "planned".to_owned()];
    names.extend(plan.keys.iter().map(|key| words(key)));
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
    for face in faces {
        names.extend(FACE_COLUMNS.map(|name| shown(&format!("{name}_{face}"))));
    }
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

fn record(plan: &Plan, faces: &[String], row: &CaseRow) -> Vec<String> {
    let settings: serde_json::Value = serde_json::from_str(&row.settings).unwrap_or_default();
    let mut cells = vec![row.id.clone(), u8::from(row.planned).to_string()];
    cells.extend(plan.keys.iter().map(|key| match &settings[key] {
        serde_json::Value::String(text) => words(text),
        serde_json::Value::Null => String::new(),
        value => shown(&value.to_string()),
    }));
    cells.extend([row.status.clone(), words(&row.error)]);
    match &row.results {
        Some(results) => {
            cells.extend(result_cells(results));
            for face in faces {
                cells.extend(face_cells(&format::case_face(&results.faces, face)));
            }
        }
        None => cells.resize(
            header(plan, faces).len() - UNIT_COLUMNS.len(),
            String::new(),
        ),
    }
    cells.extend(unit_cells(plan.units));
    cells
}

/// The cells after status and error; numbers in the shortest form that reads back to the same bits.
fn result_cells(results: &CaseResults) -> Vec<String> {
    let mut cells = vec![results.method.clone()];
    cells.extend(results.counts.map(|count| count.to_string()));
    cells.extend([results.seconds, results.accuracy].map(measure));
    cells.extend(results.zones.map(counted));
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

/// The cells of one of several contact faces, in the order of [`FACE_COLUMNS`].
fn face_cells(face: &CaseFace) -> Vec<String> {
    let mut cells = face.zones.map(counted).to_vec();
    cells.push(measure(face.normal_force));
    cells.extend(face.tangential_force.map(measure));
    cells.push(measure(face.largest_pressure));
    cells
}

/// What begins a formula in a spreadsheet.
const FORMULA: [char; 4] = ['=', '+', '-', '@'];

/// A text of the user: control characters by their escapes, and with the apostrophe that spreadsheets know a text by where
/// they would compute it.
fn words(text: &str) -> String {
    let shown = shown(text);
    if shown.starts_with(FORMULA) {
        format!("'{shown}")
    } else {
        shown
    }
}

/// A number, and nothing for NaN.
fn measure(value: f64) -> String {
    match value.is_nan() {
        true => String::new(),
        false => format!("{value:?}"),
    }
}

/// A count, and nothing for -1.
fn counted(count: i64) -> String {
    match count {
        -1 => String::new(),
        count => count.to_string(),
    }
}

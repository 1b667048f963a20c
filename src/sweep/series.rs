//! The cases of a sweep as series that ParaView plays, one for each mesh.

use std::path::{Path, PathBuf};

use runfile::{GroupRecord, IfMissing, Reader, RunFile, Transaction};

use super::{Plan, StageError, summary::number};
use crate::{
    format::{self, LAYOUT, SERIES_LAYOUT, SeriesCase, Stage},
    pipeline::SeriesFolder,
};

/// Finished cases on one mesh, with the same fields.
#[derive(Debug)]
struct Sheet {
    /// Digest of the mesh.
    mesh: String,
    fields: Vec<&'static str>,
    /// The cases, by their places in the plan.
    cases: Vec<usize>,
}

/// Writes the finished cases of a plan, in its order, and removes series of before; returns the files.
///
/// Cases that differ in the mesh or in what they have to show are in different files. The time of a case is the value of the
/// one key that varies among the cases of its file, if it grows from each to the next, else the number of the case in the plan.
pub fn write(
    plan: &Plan,
    folder: &Path,
    target: &SeriesFolder,
) -> Result<Vec<PathBuf>, StageError> {
    let mut files = Vec::new();
    for (index, sheet) in sheets(plan, folder)?.iter().enumerate() {
        let file = target.file(index);
        write_sheet(plan, folder, sheet, &file)?;
        files.push(file);
    }
    target.keep_only(&files)?;
    Ok(files)
}

fn sheets(plan: &Plan, folder: &Path) -> Result<Vec<Sheet>, StageError> {
    let mut sheets: Vec<Sheet> = Vec::new();
    for (place, case) in plan.cases.iter().enumerate() {
        let Some(reader) = Reader::open_if_there(&case.file(folder), LAYOUT)? else {
            continue;
        };
        let Some(mesh) = reader.group_record(Stage::Mesh.group())? else {
            continue;
        };
        let fields = format::field_paths(&reader);
        if fields.is_empty() {
            continue;
        }
        match sheets
            .iter_mut()
            .find(|sheet| sheet.mesh == mesh.digest && sheet.fields == fields)
        {
            Some(sheet) => sheet.cases.push(place),
            None => sheets.push(Sheet {
                mesh: mesh.digest,
                fields,
                cases: vec![place],
            }),
        }
    }
    Ok(sheets)
}

fn write_sheet(plan: &Plan, folder: &Path, sheet: &Sheet, path: &Path) -> Result<(), StageError> {
    let open = |place: usize| Reader::open(&plan.cases[place].file(folder), LAYOUT);
    let first = open(sheet.cases[0])?;
    let file = RunFile::lock(path, SERIES_LAYOUT.in_units(plan.units), IfMissing::Create)?;
    let mut transaction = Transaction::begin(&file)?;
    let mut writer = transaction.group(format::VTKHDF)?;
    let mut series = format::begin_sweep_series(&mut writer, &first, &steps(plan, &sheet.cases))?;
    for &place in &sheet.cases {
        format::step_sweep_series(&mut series, &open(place)?)?;
    }
    series.finish()?;
    let keys = toml::Value::from(plan.keys.clone());
    writer.finish(&GroupRecord::gathered(format!("keys = {keys}\n")))?;
    Ok(transaction.commit()?)
}

/// When each case is shown, and with which settings.
fn steps(plan: &Plan, cases: &[usize]) -> Vec<SeriesCase> {
    let settings: Vec<Vec<f64>> = cases
        .iter()
        .map(|&place| {
            let settings = plan.cases[place].settings.iter();
            let mut values: Vec<f64> = settings.map(|(_, value)| number(value)).collect();
            values.resize(plan.keys.len(), f64::NAN);
            values
        })
        .collect();
    let differs = |pair: &[usize], key: usize| {
        let [one, other] = [pair[0], pair[1]].map(|place| plan.cases[place].settings.get(key));
        one != other
    };
    let varies = |key: &usize| cases.windows(2).any(|pair| differs(pair, *key));
    let varying: Vec<usize> = (0..plan.keys.len()).filter(varies).collect();
    let grows = |key: usize| settings.windows(2).all(|pair| pair[0][key] < pair[1][key]);
    let time = |step: usize| match varying[..] {
        [key] if grows(key) => settings[step][key],
        _ => cases[step] as f64 + 1.0,
    };
    let case = |step: usize| SeriesCase {
        row: cases[step],
        time: time(step),
        settings: settings[step].clone(),
    };
    (0..cases.len()).map(case).collect()
}

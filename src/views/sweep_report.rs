//! The report and the pictures of a sweep: its table, and charts of what varies in it.

use std::path::{Path, PathBuf};

use contact3d::{
    history::StepRecord,
    scene::{Scene, unit_of_key},
};
use plots::{
    Chart,
    html::{BodyView, Page, PagePart, PageTable, Section},
};
use runfile::{Reader, StoreError};

use super::{
    PictureFolder, ReportKind, body3d, history_charts,
    report::footer,
    sweep_charts::{charts, lines},
    sweep_table::{names, rounded, varying_settings},
};
use crate::{
    format::SWEEP_LAYOUT,
    pipeline::{OpenRun, Results, StageError, StageState, read_results},
    report::{Cell, Column, SweepTable},
};

/// Most histories in one chart, as many as its colours.
const MOST_LOOPS: usize = 7;

/// How many of the cases that a page leaves out are named.
const MOST_NAMED_CASES: usize = 20;

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
pub(super) fn page(folder: &Path, kind: ReportKind) -> Result<Page, StageError> {
    let table = read(folder)?;
    let charts = charts(&table);
    let mut sections = Vec::new();
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    if kind == ReportKind::Interactive {
        let parts = bodies(folder, &table, &format!("Sweep {name}"))?;
        sections.push(Section::new("view3d", "The bodies in 3D", parts));
    }
    if !charts.is_empty() {
        let figures = charts.iter().map(|(_, chart)| PagePart::chart(chart));
        sections.push(Section::new("charts", "What varies", figures.collect()));
    }
    let (legend, lines) = lines(&varying_settings(&table), &table);
    let histories = histories(folder, &table, &lines)?;
    if let Some(chart) = history_charts::loops(&histories, table.units) {
        let chart = Chart { legend, ..chart };
        let mut parts = vec![PagePart::chart(&chart)];
        if histories.len() == MOST_LOOPS {
            let words = format!(
                "The first {MOST_LOOPS} cases; the run file of each has a page of its own."
            );
            parts.push(PagePart::Text(words));
        }
        sections.push(Section::new("load-history", "Load histories", parts));
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
    Ok(Page {
        title: format!("Sweep {name}"),
        subtitle: format!("{} runs", table.n_cases),
        footer: footer(folder),
        sections,
    })
}

/// The load histories of the first planned cases that have one, by their names.
fn histories(
    folder: &Path,
    table: &SweepTable,
    names: &[String],
) -> Result<Vec<(String, Vec<StepRecord>)>, StageError> {
    let mut found = Vec::new();
    for (case, id) in planned_cases(table) {
        let Some((scene, results)) = solved_case(&folder.join(format!("{id}.h5")))? else {
            continue;
        };
        if !scene.has_history() || found.len() == MOST_LOOPS {
            break;
        }
        found.push((names[case].clone(), results.increments));
    }
    Ok(found)
}

/// The planned cases that share shape and fields with the first solved one, and the names of the others.
fn bodies(folder: &Path, table: &SweepTable, title: &str) -> Result<Vec<PagePart>, StageError> {
    let settings = case_settings(table);
    let mut body: Option<BodyView> = None;
    let (mut unsolved, mut others) = (Vec::new(), Vec::new());
    for (case, id) in planned_cases(table) {
        let Some((scene, results)) = solved_case(&folder.join(format!("{id}.h5")))? else {
            unsolved.push(id);
            continue;
        };
        let status = results.solution.status;
        let mut name = settings[case].clone();
        if name.is_empty() {
            name.clone_from(&id);
        }
        if !status.is_solved() {
            name = format!("{name} ({})", status.word());
        }
        let view = body3d::case_view(&scene, &results, name);
        match &mut body {
            None => body = Some(view),
            Some(body) => others.extend(body.append(view).is_err().then_some(id)),
        }
    }
    let body = body.ok_or_else(|| no_case(folder))?;
    let left_out = [
        (
            others,
            "on another mesh than the first or with other fields",
        ),
        (unsolved, "without a solution"),
    ];
    let left_out = left_out.iter().filter(|(ids, _)| !ids.is_empty());
    let left_out = left_out.map(|(ids, why)| PagePart::Text(left_out_words(ids, why)));
    let body = BodyView {
        title: title.to_owned(),
        ..body
    };
    Ok([PagePart::Body(body)].into_iter().chain(left_out).collect())
}

/// Number and name of each planned case.
fn planned_cases(table: &SweepTable) -> Vec<(usize, String)> {
    let column = |name: &str| table.columns.iter().find(|column| column.name == name);
    let (Some(ids), Some(planned)) = (column("id"), column("planned")) else {
        return Vec::new();
    };
    let cases = 0..table.n_cases;
    cases
        .filter(|&case| planned.cells[case] == Cell::Count(Some(1)))
        .map(|case| (case, ids.cells[case].text()))
        .collect()
}

fn no_case(folder: &Path) -> StageError {
    StageError::Unfit {
        file: folder.to_owned(),
        reason: "no planned case of this sweep is solved, so there is no body to show; run `contact3d-pipe sweep` first, or leave out --interactive".into(),
    }
}

fn left_out_words(ids: &[String], why: &str) -> String {
    let named = ids[..ids.len().min(MOST_NAMED_CASES)].join(", ");
    let more = match ids.len().saturating_sub(MOST_NAMED_CASES) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!(
        "Not among these bodies, {why}: {named}{more}. The run file of a solved case has a page of its own."
    )
}

/// What each case was set to where cases differ: key = value unit.
fn case_settings(table: &SweepTable) -> Vec<String> {
    let varying = varying_settings(table);
    let parts = varying.iter().map(|column| {
        let unit = unit_of_key(&column.name, table.units).beside();
        let word =
            |value: String| (!value.is_empty()).then(|| format!("{} = {value}{unit}", column.name));
        names(column).into_iter().map(word).collect()
    });
    let parts: Vec<Vec<Option<String>>> = parts.collect();
    let of_case = |case: usize| {
        let words = parts.iter().filter_map(|of_key| of_key[case].as_deref());
        words.collect::<Vec<_>>().join(", ")
    };
    (0..table.n_cases).map(of_case).collect()
}

/// A case with a solution that can be drawn; `None` where it has none yet, or failed.
fn solved_case(file: &Path) -> Result<Option<(Scene, Results)>, StageError> {
    let run = match OpenRun::open(file) {
        Err(StageError::Store(StoreError::NotFound { .. })) => return Ok(None),
        opened => opened?,
    };
    run.require_undamaged()?;
    if !run.states.iter().all(StageState::is_fresh) {
        return Ok(None);
    }
    let results = read_results(&run.reader, &run.input)?;
    let is_drawn = !results.report.is_broken();
    Ok(is_drawn.then_some((run.input.scene, results)))
}

//! What varies in a sweep: its charts, and its page.

use std::path::{Path, PathBuf};

use contact3d::{scene::unit_of_key, solver::Status};
use plots::{
    Chart, ChartAxis, ChartPoint, Series,
    html::{Page, PagePart, PageTable, Section},
};
use runfile::Reader;
use units::Unit;

use super::{
    PictureFolder,
    report::footer,
    sweep_table::{names, numbers, rounded, varying_settings},
};
use crate::{
    format::SWEEP_LAYOUT,
    pipeline::StageError,
    report::{Column, SweepTable},
};

/// The table of a sweep's folder.
pub fn sweep_table(folder: &Path) -> PathBuf {
    folder.join("summary.h5")
}

/// Reads it.
pub fn read_sweep(folder: &Path) -> Result<SweepTable, StageError> {
    let reader = Reader::open(&sweep_table(folder), SWEEP_LAYOUT)?;
    Ok(SweepTable::read(&reader)?)
}

/// Draws what varies in the table of a sweep's folder, SVG and PNG; returns the files.
pub fn draw_sweep(sweep: &Path, figures: &PictureFolder) -> Result<Vec<PathBuf>, StageError> {
    let table = read_sweep(sweep)?;
    figures.save_charts(charts(&table))
}

/// The page of a folder with a `summary.h5`.
pub(super) fn page(folder: &Path, interactive: bool) -> Result<Page, StageError> {
    if interactive {
        return Err(StageError::Unfit {
            file: folder.to_owned(),
            reason: "a sweep has no body of its own; take the run file of a case, or leave out --interactive".into(),
        });
    }
    let table = read_sweep(folder)?;
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
    sections.push(Section::new("summary", "Cases", vec![cases]));
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    Ok(Page {
        title: format!("Sweep {name}"),
        subtitle: table.counts_in_words(),
        warning: String::new(),
        footer: footer(folder),
        sections,
    })
}

/// Results worth a chart: column, quantity.
const RESULTS: [(&str, &str); 15] = [
    ("normal_force", "normal force"),
    (
        "tangential_force_1",
        "friction force on the foundation along t1",
    ),
    (
        "tangential_force_2",
        "friction force on the foundation along t2",
    ),
    ("open", "open panes"),
    ("stick", "sticking panes"),
    ("slip", "slipping panes"),
    ("quantity_contact_area", "contact area"),
    ("quantity_stick_area", "stick area"),
    ("largest_pressure", "largest contact pressure"),
    ("largest_von_mises", "largest von Mises stress"),
    ("largest_displacement_along_x", "largest |u_x|"),
    ("largest_displacement_along_y", "largest |u_y|"),
    ("largest_displacement_along_z", "largest |u_z|"),
    ("strain_energy", "strain energy"),
    ("cycle_dissipation", "energy of a cycle"),
];

/// Errors of the solves: column, quantity. They are drawn, by their logarithms, where the sweep is about solvers.
const ERRORS: [(&str, &str); 2] = [
    ("accuracy", "relative error of the multipliers"),
    ("certificate_fixed_point", "distance to the fixed point"),
];

/// What the solves took, drawn with [`ERRORS`].
const COSTS: [(&str, &str); 4] = [
    ("outer_steps", "outer steps"),
    ("newton_steps", "Newton steps"),
    ("applications", "applications of the dual operator"),
    ("seconds", "time of the solve"),
];

/// The columns of all results that may be drawn.
pub(super) fn columns() -> impl Iterator<Item = &'static str> {
    let all = RESULTS.iter().chain(&ERRORS).chain(&COSTS);
    all.map(|(column, ..)| *column)
}

/// One chart for each result that varies, with the name of its column, over the setting with the most different numbers; the
/// other varying settings tell the lines apart.
fn charts(table: &SweepTable) -> Vec<(&'static str, Chart)> {
    let mut settings = varying_settings(table);
    let most_values = (0..settings.len())
        .rev()
        .max_by_key(|k| numbers(settings[*k]).len());
    let Some(most) = most_values.filter(|k| numbers(settings[*k]).len() > 1) else {
        return Vec::new();
    };
    let x = settings.remove(most);
    let is_of_solvers = |key: &&Column| {
        ["solve.", "assemble."]
            .iter()
            .any(|s| key.name.starts_with(s))
    };
    let is_of_solvers = settings.iter().chain([&x]).any(is_of_solvers);
    let solves = ERRORS.iter().chain(&COSTS).filter(|_| is_of_solvers);
    let (legend, names) = lines(&settings, table);
    // Forces below this share of the largest force of a sweep are rounding, and not drawn.
    let least_force = 1e-10 * largest_force(table);
    let statuses = table.statuses();
    let drawn = RESULTS.iter().chain(solves).filter_map(|&(column, label)| {
        let y = table.columns.iter().find(|other| other.name == column)?;
        let values = numbers(y);
        let is_rounding = is_force(y) && largest(&values) <= least_force;
        (values.len() > 1 && !is_rounding).then(|| {
            let x = (x, unit_of_key(&x.name, table.units));
            let chart = chart((&names, &statuses), x, y, label);
            (
                column,
                Chart {
                    legend: legend.clone(),
                    ..chart
                },
            )
        })
    });
    drawn.collect()
}

fn is_force(column: &Column) -> bool {
    column.name == "normal_force" || column.name.starts_with("tangential_force_")
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

fn largest_force(table: &SweepTable) -> f64 {
    let forces = table.columns.iter().filter(|column| is_force(column));
    forces
        .map(|column| largest(&numbers(column)))
        .fold(0.0, f64::max)
}

/// The settings that tell lines apart, and the name of the line that each case belongs to.
fn lines(settings: &[&Column], table: &SweepTable) -> (String, Vec<String>) {
    let parts: Vec<Vec<String>> = settings.iter().map(|column| names(column)).collect();
    let name = |case: usize| {
        let words: Vec<&str> = parts.iter().map(|names| names[case].as_str()).collect();
        words.join(" · ")
    };
    let title = |key: &&Column| {
        let unit = unit_of_key(&key.name, table.units);
        let words = key_words(&key.name);
        match unit.is_none() {
            true => words,
            false => format!("{words} [{}]", unit.word()),
        }
    };
    let keys: Vec<String> = settings.iter().map(title).collect();
    (keys.join(" · "), (0..table.n_cases).map(name).collect())
}

/// A key of the scene in words: the end of it that is a name of its own.
fn key_words(key: &str) -> String {
    let says_little = |word: &str| {
        ["value", "constant", "expression"].contains(&word) || word.parse::<usize>().is_ok()
    };
    let words: Vec<&str> = key.split('.').collect();
    let named = words.iter().rposition(|word| !says_little(word));
    let (name, rest) = words[named.unwrap_or(0)..]
        .split_first()
        .unwrap_or((&key, &[]));
    if let Some(axis) = name.strip_prefix("coefficient") {
        return format!("coefficient of friction F{}", axis.trim_start_matches('_'));
    }
    let rest = match *rest {
        [number, "value"] => format!(" {number}"),
        [number, "value", "0"] => format!(" {number} along x"),
        [number, "value", "1"] => format!(" {number} along y"),
        [number, "value", "2"] => format!(" {number} along z"),
        _ => String::new(),
    };
    name.replace('_', " ") + &rest
}

fn chart(
    (names, statuses): (&[String], &[String]),
    (x, x_unit): (&Column, Unit),
    y: &Column,
    label: &str,
) -> Chart {
    let mut series: Vec<Series> = Vec::new();
    let points = names.iter().zip(statuses).zip(x.cells.iter().zip(&y.cells));
    for ((name, status), (at, value)) in points {
        let Some(at) = at.number() else {
            continue;
        };
        // A case that is yet to be run is no gap, nor is a quantity that its scene does not have.
        let is_solved = Status::named(status).is_some_and(Status::is_solved);
        if value.number().is_none() && (is_solved || status == "missing") {
            continue;
        }
        let (along, across) = (&x.name, &y.name);
        let (at_unit, unit) = (x_unit.beside(), y.unit.beside());
        let found = match value.number() {
            Some(value) => format!("{across} {value}{unit}"),
            None => format!("no solution: {status}"),
        };
        let point = ChartPoint {
            x: at,
            y: value.number().unwrap_or(f64::NAN),
            text: format!("{name}\n{along} {at}{at_unit}\n{found}"),
        };
        match series.iter_mut().find(|series| series.name == *name) {
            Some(series) => series.points.push(point),
            None => series.push(Series::new(name, [point])),
        }
    }
    for series in &mut series {
        series.points.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    let is_error = ERRORS.iter().any(|(column, _)| *column == y.name);
    let along = axis(
        &key_words(&x.name),
        x_unit.clone(),
        is_geometric(&numbers(x)),
    );
    let across = axis(label, y.unit.clone(), is_error);
    Chart::new(label, along, across, series)
}

fn axis(label: &str, unit: Unit, is_logarithmic: bool) -> ChartAxis {
    match is_logarithmic {
        true => ChartAxis::logarithmic(label, unit),
        false => ChartAxis::linear(label, unit),
    }
}

/// Whether the values of an axis have equal ratios, as those of a range with the scale `log`.
fn is_geometric(rising: &[f64]) -> bool {
    let [first, second, _, ..] = *rising else {
        return false;
    };
    let ratio = second / first;
    // Ratios of one range differ by rounding, with margin.
    first > 0.0
        && rising
            .windows(2)
            .all(|pair| (pair[1] / (pair[0] * ratio) - 1.0).abs() < 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_ratios_ask_for_a_logarithmic_axis() {
        assert!(is_geometric(&[1e-8, 1e-6, 1e-4]));
        for linear in [
            &[0.1, 0.2, 0.3][..],
            &[0.05, 0.1, 0.3],
            &[1.0, 31.0],
            &[-1.0, -2.0, -4.0],
        ] {
            assert!(!is_geometric(linear), "{linear:?}");
        }
    }

    #[test]
    fn keys_are_named_in_words() {
        let words = [
            ("friction.coefficient_2", "coefficient of friction F2"),
            (
                "contact.0.friction.coefficient.constant",
                "coefficient of friction F",
            ),
            ("traction.0.value", "traction 0"),
            ("traction.0.value.2", "traction 0 along z"),
            ("material.isotropic.young_modulus", "young modulus"),
            ("contact.gap.expression", "gap"),
            ("title", "title"),
        ];
        for (key, expected) in words {
            assert_eq!(key_words(key), expected);
        }
    }
}

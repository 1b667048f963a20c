//! `summary.csv` of a sweep: the column `id`, settings, `status`, results.

use std::{collections::BTreeSet, path::Path};

use serde_json::Value;
use units::{Dimension, Unit, Units};

use crate::pipeline::StageError;

/// The column that parts settings, before it, from results, after it.
const STATUS: &str = "status";

/// The columns that name the units of length and force; a table without them is in the default
/// units.
const UNITS: [&str; 2] = ["length_unit", "force_unit"];

/// The beginnings of the names of results that have a unit.
const DIMENSIONS: [(&str, Dimension); 7] = [
    ("normal_force", Dimension::FORCE),
    ("tangential_force_", Dimension::FORCE),
    ("contact_force_", Dimension::FORCE),
    ("largest_pressure", Dimension::STRESS),
    ("largest_displacement_", Dimension::LENGTH),
    ("strain_energy", Dimension::Energy),
    ("seconds", Dimension::Time),
];

/// Columns before [`STATUS`] that are no settings.
const LABELS: [&str; 2] = ["id", "planned"];

/// A table of texts, every row as long as the head.
pub(super) struct SweepTable {
    pub(super) head: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

impl SweepTable {
    /// Reads a CSV file with a head.
    pub(super) fn read(path: &Path) -> Result<Self, StageError> {
        let refuse = |error: csv::Error| StageError::Sweep {
            file: path.to_owned(),
            reason: error.to_string(),
        };
        let mut reader = csv::Reader::from_path(path).map_err(refuse)?;
        let head = reader.headers().map_err(refuse)?;
        let head = head.iter().map(str::to_owned).collect();
        let rows = reader.records().map(|record| {
            let record = record.map_err(refuse)?;
            Ok(record.iter().map(str::to_owned).collect())
        });
        Ok(Self {
            head,
            rows: rows.collect::<Result<_, StageError>>()?,
        })
    }

    pub(super) fn column(&self, name: &str) -> Option<usize> {
        self.head.iter().position(|head| head == name)
    }

    /// The units of the results, which are the same in all rows.
    fn units(&self) -> Units {
        let word = |name: &str| {
            let column = self.column(name)?;
            self.rows.first().map(|row| row[column].as_str())
        };
        let [length, force] = UNITS.map(word);
        let named = length.zip(force).map(|(l, f)| format!("{l}, {f}"));
        named.and_then(|text| text.parse().ok()).unwrap_or_default()
    }

    /// The unit of a column of results.
    pub(super) fn unit(&self, name: &str) -> Unit {
        let known = DIMENSIONS.iter().find(|(start, _)| name.starts_with(start));
        let dimension = known.map_or(Dimension::Number, |(_, dimension)| *dimension);
        self.units().of(dimension)
    }

    /// The head for people: every result with its unit.
    pub(super) fn titles(&self) -> Vec<String> {
        let title = |name: &String| match self.unit(name) {
            unit if unit.is_none() => name.clone(),
            unit => format!("{name} [{}]", unit.word()),
        };
        self.head.iter().map(title).collect()
    }

    /// The settings that are not the same in all rows.
    pub(super) fn varying_settings(&self) -> Vec<usize> {
        let status = self.column(STATUS).unwrap_or(0);
        let is_setting = |column: &usize| !LABELS.contains(&self.head[*column].as_str());
        (0..status)
            .filter(is_setting)
            .filter(|&column| self.distinct(column).len() > 1)
            .collect()
    }

    /// The different texts of a column.
    fn distinct(&self, column: usize) -> BTreeSet<&str> {
        self.rows.iter().map(|row| row[column].as_str()).collect()
    }

    pub(super) fn number(&self, row: usize, column: usize) -> Option<f64> {
        let value: f64 = self.rows[row][column].trim().parse().ok()?;
        value.is_finite().then_some(value)
    }

    /// The different numbers of a column, rising; none where a cell is neither a number nor empty.
    pub(super) fn numbers(&self, column: usize) -> Vec<f64> {
        let texts = self.rows.iter().map(|row| row[column].trim());
        let mut filled = texts.filter(|text| !text.is_empty());
        if !filled.all(|text| text.parse::<f64>().is_ok()) {
            return Vec::new();
        }
        let values = (0..self.rows.len()).filter_map(|row| self.number(row, column));
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    }

    /// A short name for each row's value of a column: a word or a rounded number where that tells
    /// all values apart, else the whole value.
    pub(super) fn names(&self, column: usize) -> Vec<String> {
        let short = |text: &str| {
            let value = serde_json::from_str(text);
            value.map_or_else(|_| text.to_owned(), |value| in_short(&value, 3))
        };
        let distinct = self.distinct(column);
        let shorts: BTreeSet<String> = distinct.iter().map(|text| short(text)).collect();
        let tells_apart = shorts.len() == distinct.len();
        let texts = self.rows.iter().map(|row| row[column].as_str());
        texts
            .map(|text| {
                if tells_apart {
                    short(text)
                } else {
                    text.to_owned()
                }
            })
            .collect()
    }
}

/// A cell for people: numbers rounded, also those inside lists and tables.
pub(super) fn rounded(cell: &str) -> String {
    match cell.parse::<f64>() {
        Ok(number) => in_digits(number, 4),
        Err(_) => match serde_json::from_str(cell) {
            Ok(value) => whole(&value, 4),
            Err(_) => cell.to_owned(),
        },
    }
}

fn whole(value: &Value, digits: usize) -> String {
    match value {
        Value::Object(table) => {
            let parts = table.iter();
            let parts = parts.map(|(key, v)| format!("{key} {}", whole(v, digits)));
            parts.collect::<Vec<_>>().join(", ")
        }
        value => in_short(value, digits),
    }
}

/// The name of a table's only key, a list of rounded numbers, a rounded number.
fn in_short(value: &Value, digits: usize) -> String {
    match value {
        Value::Object(table) => match table.iter().next() {
            Some((key, Value::Object(_))) if table.len() == 1 => key.clone(),
            _ => whole(value, digits),
        },
        Value::Array(list) => {
            let parts: Vec<String> = list.iter().map(|v| in_short(v, digits)).collect();
            format!("({})", parts.join(", "))
        }
        Value::Number(number) => number
            .as_f64()
            .map_or_else(|| number.to_string(), |number| in_digits(number, digits)),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// So many significant digits, plain from 10⁻³ to 10⁵; whole numbers in full up to there.
fn in_digits(number: f64, digits: usize) -> String {
    let size = number.abs();
    if number == 0.0 || (number.fract() == 0.0 && size < 1e5) {
        return format!("{number}");
    }
    let scientific = format!("{number:.0$e}", digits - 1);
    let rounded: f64 = scientific.parse().unwrap_or(number);
    if (1e-3..1e5).contains(&size) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(cells: &[&str]) -> SweepTable {
        SweepTable {
            head: ["id", "law", "status"].map(str::to_owned).to_vec(),
            rows: cells
                .iter()
                .map(|cell| vec!["a".to_owned(), (*cell).to_owned(), "converged".to_owned()])
                .collect(),
        }
    }

    #[test]
    fn names_are_short_as_long_as_they_differ() {
        let laws = [
            r#"{"constant":0.3}"#,
            r#"{"ramp":{"initial":0.3,"rate":6e4}}"#,
        ];
        assert_eq!(table(&laws).names(1), ["constant 0.3", "ramp"]);
        let ramps = [r#"{"ramp":{"rate":1.0}}"#, r#"{"ramp":{"rate":2.0}}"#];
        assert_eq!(table(&ramps).names(1), ramps);
        let pulls = ["[9396926.0,3420201.0,20000000.0]", "[5000000.0,0.0,2e7]"];
        assert_eq!(
            table(&pulls).names(1),
            ["(9.4e6, 3.42e6, 2e7)", "(5e6, 0, 2e7)"]
        );
    }

    #[test]
    fn cells_are_rounded_and_texts_left() {
        assert_eq!(rounded("0.08128067965282493"), "0.08128");
        assert_eq!(rounded("58108182.19191703"), "5.811e7");
        assert_eq!(rounded("12"), "12");
        assert_eq!(rounded("18fd5d04ec11833d"), "18fd5d04ec11833d");
        assert_eq!(
            rounded(r#"{"ramp":{"initial":0.3,"onset":0.00001}}"#),
            "ramp initial 0.3, onset 1e-5"
        );
    }

    #[test]
    fn a_column_with_a_word_has_no_numbers() {
        assert_eq!(table(&["2", "1", "", "2"]).numbers(1), [1.0, 2.0]);
        assert!(table(&["2", "panes"]).numbers(1).is_empty());
    }
}

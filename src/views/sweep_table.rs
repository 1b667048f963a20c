//! What the columns of a sweep's table tell people: short names, rounded cells, what varies.

use std::collections::BTreeSet;

use contact3d::scene::escape_control;
use serde_json::Value;

use crate::report::{Cell, Column, SweepTable};

/// The settings that are not the same in all cases.
pub(super) fn varying_settings(table: &SweepTable) -> Vec<&Column> {
    let settings = table.columns.iter().filter(|column| column.is_setting);
    settings
        .filter(|column| distinct(column).len() > 1)
        .collect()
}

/// The different texts of a column.
fn distinct(column: &Column) -> BTreeSet<String> {
    column.cells.iter().map(Cell::text).collect()
}

/// The different numbers of a column, rising; none where a cell is neither a number nor empty.
pub(super) fn numbers(column: &Column) -> Vec<f64> {
    if column.cells.iter().any(Cell::is_word) {
        return Vec::new();
    }
    let mut values: Vec<f64> = column.cells.iter().filter_map(Cell::number).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// A short name for each case's value of a column: a word or a rounded number where that tells all values apart, else the
/// whole value.
pub(super) fn names(column: &Column) -> Vec<String> {
    let short = |cell: &Cell| match cell {
        Cell::Setting(value) if !value.is_null() => in_short(value, 3),
        other => other.text(),
    };
    let shorts: BTreeSet<String> = column.cells.iter().map(short).collect();
    let tells_apart = shorts.len() == distinct(column).len();
    let name = |cell: &Cell| match tells_apart {
        true => short(cell),
        false => cell.text(),
    };
    column.cells.iter().map(name).collect()
}

/// A cell for people: numbers rounded, also those inside lists and tables.
pub(super) fn rounded(cell: &Cell) -> String {
    match (cell, cell.number()) {
        (_, Some(number)) => in_digits(number, 4),
        (Cell::Setting(value), None) if !value.is_null() => whole(value, 4),
        (cell, None) => cell.text(),
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
        Value::String(text) => escape_control(text),
        other => other.to_string(),
    }
}

/// So many significant digits, plain from 10⁻³ to 10⁵; whole numbers in full up to there.
fn in_digits(number: f64, digits: usize) -> String {
    let size = number.abs();
    if number == 0.0 || (number.fract() == 0.0 && size < 1e5) {
        return format!("{number}");
    }
    let rounded = units::rounded(number, digits);
    if (1e-3..1e5).contains(&size) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;
    use units::Unit;

    use super::*;

    fn column(values: &[Value]) -> Column {
        Column {
            name: "law".to_owned(),
            is_setting: true,
            unit: Unit::none(),
            cells: values.iter().cloned().map(Cell::Setting).collect(),
        }
    }

    #[test]
    fn names_are_short_as_long_as_they_differ() {
        let laws = [
            json!({"constant": 0.3}),
            json!({"ramp": {"initial": 0.3, "rate": 6e4}}),
        ];
        assert_eq!(names(&column(&laws)), ["constant 0.3", "ramp"]);
        let ramps = [
            json!({"ramp": {"rate": 1.0}}),
            json!({"ramp": {"rate": 2.0}}),
        ];
        let whole = [r#"{"ramp":{"rate":1.0}}"#, r#"{"ramp":{"rate":2.0}}"#];
        assert_eq!(names(&column(&ramps)), whole);
        let pulls = [
            json!([9_396_926.0, 3_420_201.0, 2e7]),
            json!([5e6, 0.0, 2e7]),
        ];
        let short = ["(9.4e6, 3.42e6, 2e7)", "(5e6, 0, 2e7)"];
        assert_eq!(names(&column(&pulls)), short);
    }

    #[test]
    fn cells_are_rounded_and_texts_left() {
        assert_eq!(rounded(&Cell::Number(0.081_280_679_652_824_93)), "0.08128");
        assert_eq!(rounded(&Cell::Number(58_108_182.191_917_03)), "5.811e7");
        assert_eq!(rounded(&Cell::Count(Some(12))), "12");
        let id = "18fd5d04ec11833d";
        assert_eq!(rounded(&Cell::Text(id.to_owned())), id);
        let ramp = json!({"ramp": {"initial": 0.3, "onset": 0.00001}});
        let shown = "ramp initial 0.3, onset 1e-5";
        assert_eq!(rounded(&Cell::Setting(ramp)), shown);
    }

    #[test]
    fn a_column_with_a_word_has_no_numbers() {
        let values = [json!(2), json!(1), Value::Null, json!(2)];
        assert_eq!(numbers(&column(&values)), [1.0, 2.0]);
        assert!(numbers(&column(&[json!(2), json!("panes")])).is_empty());
    }
}

//! The sinks of figures: text, Markdown, HTML, JSON.

use std::fmt::Write;

use plots::html::PageTable;
use serde_json::{Map, Value};

use super::figure::{Figure, Figures};

impl Figure {
    /// The name of its column, with the unit.
    fn title(&self) -> Option<String> {
        let words = self.words.as_ref()?;
        Some(if self.unit.is_empty() {
            words.clone()
        } else {
            format!("{words} [{}]", self.unit)
        })
    }

    /// Name and value with the unit; `None` where there is nothing to read.
    fn pair(&self) -> Option<(String, String)> {
        let (words, shown) = self.words.as_ref().zip(self.shown.as_ref())?;
        let value = format!("{shown} {}", self.unit).trim_end().to_owned();
        Some((words.clone(), value))
    }
}

impl Figures {
    /// Names and values of what there is to read.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = (String, String)> {
        self.list.iter().filter_map(Figure::pair)
    }

    /// One line for each figure, the values in a column of their own.
    pub fn text(&self, indent: usize, width: usize) -> String {
        let mut text = String::new();
        for (name, value) in self.pairs() {
            let _ = writeln!(text, "{:indent$}{name:<width$} {value}", "");
        }
        text
    }

    /// A table of names and values.
    pub fn html(&self) -> PageTable {
        PageTable::of_pairs(self.pairs())
    }

    /// One object; keys with dots are objects in it.
    pub fn json(&self) -> Value {
        let mut object = Map::new();
        for (key, value) in self.list.iter().flat_map(|figure| &figure.values) {
            put(&mut object, key, value.clone());
        }
        Value::Object(object)
    }

    /// What a table shows of them.
    fn cells(&self) -> Vec<String> {
        let shown = self.list.iter().filter(|figure| figure.words.is_some());
        shown
            .map(|figure| figure.shown.clone().unwrap_or_else(|| "-".to_owned()))
            .collect()
    }

    fn titles(&self) -> Vec<String> {
        self.list.iter().filter_map(Figure::title).collect()
    }
}

fn put(object: &mut Map<String, Value>, key: &str, value: Value) {
    let Some((first, rest)) = key.split_once('.') else {
        object.insert(key.to_owned(), value);
        return;
    };
    let inner = object
        .entry(first)
        .or_insert_with(|| Value::Object(Map::new()));
    if let Value::Object(inner) = inner {
        put(inner, rest, value);
    }
}

/// A table: rows that have the same figures.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureTable {
    /// What it shows.
    pub caption: String,
    /// Its rows.
    pub rows: Vec<Figures>,
    /// What is to be said below it; empty for nothing.
    pub note: String,
}

impl FigureTable {
    /// A table with nothing to be said below it.
    pub fn new(caption: &str, rows: impl IntoIterator<Item = Figures>) -> Self {
        Self {
            caption: caption.to_owned(),
            rows: rows.into_iter().collect(),
            note: String::new(),
        }
    }

    /// The table with something to be said below it.
    pub fn with_note(self, note: impl Into<String>) -> Self {
        let note = note.into();
        Self { note, ..self }
    }

    /// For a terminal: caption, titles, one line a row, note.
    pub fn text(&self) -> String {
        let lines = self.lines().concat();
        format!("{}\n{lines}{}", self.caption, self.note)
    }

    /// For a page.
    pub fn html(&self) -> PageTable {
        PageTable {
            caption: self.caption.clone(),
            head: self.titles(),
            rows: self.cells(),
        }
    }

    /// Titles and rows as Markdown.
    pub fn markdown(&self) -> String {
        let titles = self.titles();
        let mut text = format!(
            "| {} |\n|{}\n",
            titles.join(" | "),
            "---|".repeat(titles.len())
        );
        for row in self.cells() {
            let _ = writeln!(text, "| {} |", row.join(" | "));
        }
        text
    }

    /// An object for each row.
    pub fn json(&self) -> Value {
        self.rows.iter().map(Figures::json).collect()
    }

    fn titles(&self) -> Vec<String> {
        self.rows.first().map(Figures::titles).unwrap_or_default()
    }

    fn cells(&self) -> Vec<Vec<String>> {
        self.rows.iter().map(Figures::cells).collect()
    }

    /// The titles and each row as a line: columns of numbers are set to the right.
    pub(crate) fn lines(&self) -> Vec<String> {
        let (titles, cells) = (self.titles(), self.cells());
        let column = |(k, title): (usize, &String)| {
            let column = cells.iter().map(|row| row[k].as_str());
            let width = column.clone().chain([title.as_str()]);
            let width = width.map(|cell| cell.chars().count()).max();
            (width.unwrap_or(0), column.clone().all(is_figure))
        };
        let columns: Vec<(usize, bool)> = titles.iter().enumerate().map(column).collect();
        let line = |cells: &Vec<String>| {
            let mut text = String::new();
            for (cell, (width, to_the_right)) in cells.iter().zip(&columns) {
                let _ = if *to_the_right {
                    write!(text, "  {cell:>width$}")
                } else {
                    write!(text, "  {cell:<width$}")
                };
            }
            text.trim_end().to_owned() + "\n"
        };
        [&titles].into_iter().chain(&cells).map(line).collect()
    }
}

/// A number, numbers or nothing.
fn is_figure(cell: &str) -> bool {
    let begins = |c: char| c.is_ascii_digit() || "+-−.>*".contains(c);
    cell.is_empty() || cell.starts_with(begins) || ["NaN", "inf"].contains(&cell)
}

#[cfg(test)]
mod tests {
    use units::{Dimension, Units};

    use super::*;
    use crate::report::Digits::{Fixed, Scientific};

    fn figures(force: Option<f64>) -> Figures {
        let mut figures = Figures::new(Units::SI);
        figures.add("force", "force", Dimension::FORCE, Scientific(2), force);
        figures.number("cost.seconds", "cost", Fixed(1), 2.0);
        figures.counts("open, stick", [("open", 3), ("", 4)]);
        figures.described("status", "status", Some("ended".to_owned()), "converged");
        figures.json_only("digest", "abc");
        figures
    }

    #[test]
    fn one_list_feeds_every_sink() {
        let list = figures(Some(1234.0));
        let text =
            "  force       1.23e3 N\n  cost        2.0\n  open, stick 3, 4\n  status      ended\n";
        assert_eq!(list.text(2, 11), text);
        let json = serde_json::json!({
            "force": 1234.0, "cost": { "seconds": 2.0 }, "open": 3, "status": "converged", "digest": "abc",
        });
        assert_eq!(list.json(), json);
        let page = list.html();
        assert_eq!(page.rows[0], ["force", "1.23e3 N"]);
        assert_eq!(page.rows.len(), 4);
    }

    /// What is not there is no line of a list, a dash in a table and null for programs.
    #[test]
    fn what_is_missing_is_said_so() {
        let rows = [
            figures(Some(1234.0)),
            figures(None),
            figures(Some(f64::NAN)),
        ];
        assert_eq!(rows[1].text(0, 11).lines().count(), 3);
        let table = FigureTable::new("both", rows);
        assert!(table.json()[1]["force"].is_null() && table.json()[2]["force"].is_null());
        let lines = [
            "both",
            "  force [N]  cost  open, stick  status",
            "     1.23e3   2.0         3, 4  ended",
            "          -   2.0         3, 4  ended",
            "        NaN   2.0         3, 4  ended",
        ];
        assert_eq!(table.text().lines().collect::<Vec<_>>(), lines);
        let page = table.html();
        assert_eq!(page.head, ["force [N]", "cost", "open, stick", "status"]);
        assert_eq!(page.rows[1], ["-", "2.0", "3, 4", "ended"]);
    }
}

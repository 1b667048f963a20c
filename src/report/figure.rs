//! A figure, one entry, and the sinks that show lists of them: text, Markdown, HTML, JSON.

use std::fmt::Write;

use plots::html::PageTable;
use serde::Serialize;
use serde_json::{Map, Value};
use units::{Dimension, Units};

/// How many digits people see; programs get all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Digits {
    /// The shortest text that reads back to the same number.
    All,
    /// So many after the point.
    Fixed(usize),
    /// So many after the point, and a power of ten.
    Scientific(usize),
}

/// The value of a figure.
pub trait FigureValue: Serialize {
    /// The value for people; `None` where there is none.
    fn shown(&self, digits: Digits) -> Option<String>;
}

impl FigureValue for f64 {
    fn shown(&self, digits: Digits) -> Option<String> {
        Some(match digits {
            Digits::All => self.to_string(),
            Digits::Fixed(n) => format!("{self:.n$}"),
            Digits::Scientific(n) => format!("{self:.n$e}"),
        })
    }
}

macro_rules! shown_in_full {
    ($($kind:ty),*) => {$(
        impl FigureValue for $kind {
            fn shown(&self, _: Digits) -> Option<String> {
                Some(self.to_string())
            }
        }
    )*};
}
shown_in_full!(usize, i8, i32, i64, &str, String);

impl<T: FigureValue> FigureValue for Option<T> {
    fn shown(&self, digits: Digits) -> Option<String> {
        self.as_ref()?.shown(digits)
    }
}

impl<T: FigureValue, const N: usize> FigureValue for [T; N]
where
    Self: Serialize,
{
    fn shown(&self, digits: Digits) -> Option<String> {
        let parts: Option<Vec<String>> = self.iter().map(|part| part.shown(digits)).collect();
        Some(parts?.join(", "))
    }
}

/// One figure: a line of a list, a cell of a table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Figure {
    /// Keys and values for programs; dots lead into objects. Several where people read them in one line, none where
    /// only people want it.
    pub(super) values: Vec<(String, Value)>,
    /// The name for people; `None` where only programs want it.
    pub(super) words: Option<String>,
    /// The word for the unit; empty for none.
    pub(super) unit: String,
    /// The value for people; `None` where there is none.
    pub(super) shown: Option<String>,
}

/// Figures that belong together: what a run came to, or one row of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    units: Units,
    pub(super) list: Vec<Figure>,
}

impl Figures {
    /// No figures yet, of a scene in some units.
    pub fn new(units: Units) -> Self {
        let list = Vec::new();
        Self { units, list }
    }

    /// A quantity with a dimension.
    pub fn add(
        &mut self,
        key: &str,
        words: &str,
        dimension: Dimension,
        digits: Digits,
        value: impl FigureValue,
    ) {
        let unit = self.units.of(dimension);
        self.list.push(Figure {
            values: keyed(key, &value),
            words: Some(words.to_owned()),
            unit: if unit.is_none() {
                String::new()
            } else {
                unit.word().to_owned()
            },
            shown: value.shown(digits),
        });
    }

    /// A number without unit.
    pub fn number(&mut self, key: &str, words: &str, digits: Digits, value: impl FigureValue) {
        self.add(key, words, Dimension::Number, digits, value);
    }

    /// A count or a word.
    pub fn plain(&mut self, key: &str, words: &str, value: impl FigureValue) {
        self.number(key, words, Digits::All, value);
    }

    /// Counts that people read side by side, separated by commas.
    pub fn counts<const N: usize>(&mut self, words: &str, counts: [(&str, usize); N]) {
        let shown = counts.map(|(_, count)| count.to_string()).join(", ");
        self.human_only(words, Some(shown));
        if let Some(figure) = self.list.last_mut() {
            let values = counts.iter();
            figure.values = values.flat_map(|(key, count)| keyed(key, count)).collect();
        }
    }

    /// How many panes are open, stick and slip, as far as people are told; without friction those that slip are in contact.
    pub(super) fn zones(&mut self, has_friction: bool, zones: [usize; 3], is_told: bool) {
        let [open, stick, slip] = zones;
        let (words, shown) = match has_friction {
            true => ("open, stick, slip", format!("{open}, {stick}, {slip}")),
            false => ("open, in contact", format!("{open}, {slip}")),
        };
        self.human_only(words, is_told.then_some(shown));
        for (key, count) in ["open", "stick", "slip"].into_iter().zip(zones) {
            self.json_only(key, count);
        }
    }

    /// A value that people read in words of its own.
    pub fn described(
        &mut self,
        key: &str,
        words: &str,
        shown: Option<String>,
        value: impl Serialize,
    ) {
        self.human_only(words, shown);
        if let Some(figure) = self.list.last_mut() {
            figure.values = keyed(key, &value);
        }
    }

    /// What only people are told.
    pub fn human_only(&mut self, words: &str, shown: Option<String>) {
        self.list.push(Figure {
            values: Vec::new(),
            words: Some(words.to_owned()),
            unit: String::new(),
            shown,
        });
    }

    /// Values with a dimension as people read them: four digits, with a prefix.
    pub fn told(&mut self, words: &str, dimension: Dimension, values: Option<impl AsRef<[f64]>>) {
        let shown = values.map(|values| self.units.of(dimension).told(values.as_ref()));
        self.human_only(words, shown);
    }

    /// What only programs want.
    pub fn json_only(&mut self, key: &str, value: impl Serialize) {
        self.list.push(Figure {
            values: keyed(key, &value),
            words: None,
            unit: String::new(),
            shown: None,
        });
    }

    /// The same for programs alone.
    pub fn for_programs(mut self) -> Self {
        self.list.iter_mut().for_each(|figure| figure.words = None);
        self
    }

    /// The figures of another list after these.
    pub fn with(mut self, others: Self) -> Self {
        self.list.extend(others.list);
        self
    }
}

/// A key and its value; none for a figure without a key. What is not finite is null.
fn keyed(key: &str, value: &impl Serialize) -> Vec<(String, Value)> {
    if key.is_empty() {
        return Vec::new();
    }
    let value = serde_json::to_value(value).unwrap_or_default();
    vec![(key.to_owned(), value)]
}

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

    /// Names and values of what there is to read, for programs that show them.
    pub fn words_json(&self) -> Value {
        self.pairs().map(|(name, words)| [name, words]).collect()
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
    let begins = |c: char| c.is_ascii_digit() || "+-−.>*(".contains(c);
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

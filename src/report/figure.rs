//! A figure: one entry that every sink shows in its own way.

use serde::Serialize;
use serde_json::Value;
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

    /// What only programs want.
    pub fn json_only(&mut self, key: &str, value: impl Serialize) {
        self.list.push(Figure {
            values: keyed(key, &value),
            words: None,
            unit: String::new(),
            shown: None,
        });
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

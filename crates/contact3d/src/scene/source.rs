//! A text of TOML, read once, with the places of its keys for messages.

use std::ops::Range;

use miette::{NamedSource, SourceSpan};
use schemars::JsonSchema;
use serde::Deserialize;
use toml::de::{DeTable, Deserializer};

use super::{
    InvalidValue, SceneError,
    error::SyntaxProblem,
    schema::{Checker, Place, SchemaTree},
};

/// Longest line that is drawn and longest value that is quoted, in characters: some lines of a screen.
const LONGEST_QUOTED: usize = 300;

/// A text of TOML that holds what its schema asks for, with its name for messages.
#[derive(Debug, Clone)]
pub struct Source {
    name: String,
    text: String,
    /// The keys that it gives, tables before what is in them.
    places: Vec<Place>,
}

impl Source {
    /// Reads TOML; `name` is the file's name and `page` the page of `contact3d-pipe help` about its keys, for messages.
    ///
    /// # Errors
    /// [`SceneError::Syntax`] for text that is not TOML or has an unknown, missing or mistyped key, a list in the place of a
    /// table, a list of another length.
    pub fn read<T: for<'de> Deserialize<'de> + JsonSchema>(
        name: &str,
        text: &str,
        page: &str,
    ) -> Result<(T, Self), SceneError> {
        let keys =
            format!("`contact3d-pipe help {page}` lists the keys with their types and defaults");
        let mut source = Self {
            name: name.to_owned(),
            text: text.to_owned(),
            places: Vec::new(),
        };
        let table = DeTable::parse(text).map_err(|error| source.unreadable(&error, &keys))?;
        let schema = SchemaTree::of::<T>();
        let mut checker = Checker {
            schema: &schema,
            keys: &keys,
            text,
            places: Vec::new(),
        };
        let checked = checker.table(&schema.0, "", table.get_ref(), 0..0);
        source.places = checker.places;
        checked.map_err(|problem| source.syntax(problem))?;
        let value = T::deserialize(Deserializer::from(table));
        let value = value.map_err(|error| source.unreadable(&error, &keys))?;
        Ok((value, source))
    }

    /// Whether the text itself gives a key, its default or not.
    #[must_use]
    pub fn gives(&self, key: &str) -> bool {
        self.places.iter().any(|place| place.key == key)
    }

    /// An error that shows the line of an unusable value.
    #[must_use]
    pub fn refuse(&self, mut invalid: InvalidValue) -> SceneError {
        invalid.found = shortened(invalid.found);
        let span = self.place(&invalid.key).map(|place| place.value.clone());
        SceneError::Invalid {
            text: NamedSource::new(&self.name, self.text.clone()),
            span: drawn(&self.text, span),
            invalid: Box::new(invalid),
        }
    }

    /// Text that is not TOML, a formula that is none, a number that is too large.
    fn unreadable(&self, error: &toml::de::Error, help: &str) -> SceneError {
        let span = error.span().unwrap_or_default();
        let message = match number_limit(error) {
            Some(limit) => format!("expected {limit}, found {}", &self.text[span.clone()]),
            None => error.message().to_owned(),
        };
        let help = match error.message() {
            "duplicate key" => &super::schema::help_for_second(&self.text[span.clone()], help),
            _ => help,
        };
        let key = self.key_at(span.start).unwrap_or_default();
        self.syntax(SyntaxProblem::new(key, span, message, help))
    }

    fn syntax(&self, problem: SyntaxProblem) -> SceneError {
        SceneError::Syntax {
            text: NamedSource::new(&self.name, self.text.clone()),
            span: drawn(&self.text, Some(problem.span.clone())),
            problem: Box::new(problem),
        }
    }

    /// The key of the innermost name or value at a byte of the text.
    fn key_at(&self, byte: usize) -> Option<&str> {
        let has = |place: &&Place| place.name.contains(&byte) || place.value.contains(&byte);
        let place = self.places.iter().rev().find(has)?;
        Some(&place.key)
    }

    /// The place of a key, or of its nearest table that is written out.
    fn place(&self, key: &str) -> Option<&Place> {
        let mut places = self.places.iter();
        let own = places.find(|place| place.key == key);
        own.or_else(|| self.place(&key[..key.rfind('.')?]))
    }
}

impl SyntaxProblem {
    /// What is wrong at a key, which is empty for the text as a whole.
    pub(super) fn new(
        key: &str,
        span: Range<usize>,
        message: String,
        help: impl Into<String>,
    ) -> Self {
        let message = shortened(message);
        Self {
            message: match key {
                "" => message,
                key => format!("{key}: {message}"),
            },
            help: help.into(),
            span,
        }
    }
}

/// What a number that no scene can hold should be; `None` where something else is wrong.
#[must_use]
pub fn number_limit(error: &toml::de::Error) -> Option<String> {
    match error.message() {
        "floating-point number overflowed" => {
            Some(format!("numbers up to {:e}, the largest double", f64::MAX))
        }
        // The second is of numbers that the parser knows and the format does not.
        message
            if message == "integer number overflowed"
                || message.starts_with("invalid type: integer") =>
        {
            Some(whole_limit())
        }
        _ => None,
    }
}

/// The whole numbers that TOML can hold.
pub(super) fn whole_limit() -> String {
    format!("whole numbers up to {}", i64::MAX)
}

fn shortened(found: String) -> String {
    match found.char_indices().nth(LONGEST_QUOTED) {
        Some((end, _)) => format!("{} … ({} bytes)", &found[..end], found.len()),
        None => found,
    }
}

/// The place to draw; none when its line or one beside it is too long for a screen.
fn drawn(text: &str, span: Option<Range<usize>>) -> Option<SourceSpan> {
    let span = span.filter(|_| !text.is_empty())?;
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let end = start + line.len();
        // Two lines of context are drawn on each side; three leave room.
        let near = span.start <= end + 3 * LONGEST_QUOTED && start <= span.end + 3 * LONGEST_QUOTED;
        if near && line.len() > LONGEST_QUOTED {
            return None;
        }
        start = end;
    }
    Some(span.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_found_in_tables_and_arrays() {
        let text = "[a.b]\nc = 1.5\n[[d]]\ne = 2\n[[d]]\ne = 3\n";
        let (_, source) = Source::read::<Nested>("test", text, "").expect("of the schema");
        let locate = |key: &str| source.place(key).map(|place| &text[place.value.clone()]);
        assert_eq!(locate("a.b.c"), Some("1.5"));
        assert_eq!(locate("d.1.e"), Some("3"));
        assert_eq!(locate("a.b.c.0"), Some("1.5"));
        assert_eq!(locate("missing"), None);
        let at = |value: &str| source.key_at(text.find(value).unwrap());
        assert_eq!(at("1.5"), Some("a.b.c"));
        assert_eq!(at("3"), Some("d.1.e"));
    }

    #[derive(Deserialize, JsonSchema)]
    #[expect(dead_code, reason = "its keys alone are asked for")]
    struct Nested {
        a: std::collections::BTreeMap<String, std::collections::BTreeMap<String, f64>>,
        d: Vec<std::collections::BTreeMap<String, f64>>,
    }

    #[test]
    fn long_lines_and_values_are_not_drawn() {
        let text = format!("a = 1\n# {}\nb = 2\n", "x".repeat(5000));
        assert_eq!(drawn(&text, Some(0..1)), None);
        assert!(drawn("a = 1\n", Some(4..5)).is_some());
        assert!(shortened("é".repeat(5000)).len() < 1000);
    }
}

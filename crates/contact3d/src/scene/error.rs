//! Why a scene cannot be used, with the line that is at fault.

use std::{ops::Range, string::FromUtf8Error};

use miette::{Diagnostic, NamedSource, SourceSpan};
use thiserror::Error;
use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

use super::Written;

/// Why a scene file cannot be used; draws the offending line.
#[derive(Debug, Error, Diagnostic)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("cannot read the scene {path}")]
    #[diagnostic(help("give the path of a scene file, such as pipelines/hkl2011_table1.toml"))]
    Read {
        /// The path as given.
        path: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// Not text, or more of it than a scene has.
    #[error("{path}: {problem}")]
    #[diagnostic(help("{help}"))]
    NoScene {
        /// The path as given.
        path: String,
        /// What was expected and what was found.
        problem: String,
        /// What to do about it.
        help: &'static str,
    },
    /// Not TOML, or not the keys and types of a scene.
    #[error("{}: {}", text.name(), problem.message)]
    #[diagnostic(help("{}", problem.help))]
    Syntax {
        /// What is wrong, and what to do about it.
        problem: Box<SyntaxProblem>,
        /// The scene text.
        #[source_code]
        text: NamedSource<String>,
        /// Where it is.
        #[label("here")]
        span: Option<SourceSpan>,
    },
    /// A value that no problem of this kind can have.
    #[error("{}: {}: expected {}, found {}", text.name(), invalid.key, invalid.expected, invalid.found)]
    #[diagnostic(help("{}", invalid.help))]
    Invalid {
        /// The key, what was expected and what was found.
        invalid: Box<InvalidValue>,
        /// The scene text.
        #[source_code]
        text: NamedSource<String>,
        /// Where the key is.
        #[label("this value")]
        span: Option<SourceSpan>,
    },
}

/// What is wrong with a text that is no scene, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SyntaxProblem {
    /// The key, where the text is TOML, and what is wrong there.
    pub message: String,
    /// What to do about it.
    pub help: String,
}

/// An unusable value: the key, what it should be, what it is, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{key}: expected {expected}, found {found}; {help}")]
pub struct InvalidValue {
    /// Path of the key, such as `material.isotropic.poisson_ratio` or `traction.0.value`.
    pub key: String,
    /// What the model allows.
    pub expected: String,
    /// What the scene says.
    pub found: String,
    /// What to do about it.
    pub help: String,
}

/// A scene built in Rust that no text can say.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "{key}: expected a value that a scene file can hold, found {reason}; solve the scene in memory, or give a formula or a table"
)]
pub struct Unwritable {
    /// Path of the key.
    pub key: String,
    /// What stands there.
    pub reason: String,
}

/// What to do about a formula that is not finite somewhere.
pub(crate) const UNDEFINED: &str = "mind square roots, logarithms and divisions: sqrt(max(FORMULA, 0)) and if(x > 0, FORMULA, VALUE) are defined everywhere";

/// A place in words.
#[must_use]
pub(crate) fn place_words(at: [f64; 3]) -> String {
    format!("x, y, z = {}", numbers(&at))
}

/// Numbers in a row.
#[must_use]
pub fn numbers(values: &[f64]) -> String {
    let words: Vec<String> = values.iter().map(|v| Written(v).to_string()).collect();
    words.join(", ")
}

/// Longest line that is shown, in bytes.
const LONGEST_LINE: usize = 300;

/// Longest value that is quoted, in characters.
const LONGEST_FOUND: usize = 300;

/// What a text has that is no scene, and where.
pub(super) struct SchemaViolation {
    /// The key; empty for the text as a whole.
    pub(super) key: String,
    pub(super) message: String,
    /// What to do about it.
    pub(super) help: String,
    pub(super) span: Range<usize>,
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

impl SceneError {
    pub(super) fn syntax(name: &str, text: &str, violation: SchemaViolation) -> Self {
        let message = shortened(violation.message);
        Self::Syntax {
            problem: Box::new(SyntaxProblem {
                message: match violation.key.as_str() {
                    "" => message,
                    key => format!("{key}: {message}"),
                },
                help: violation.help,
            }),
            text: NamedSource::new(name, text.to_owned()),
            span: shown(text, Some(violation.span)),
        }
    }

    /// Text that is not TOML, a formula that is none, a number that is too large.
    pub(super) fn unreadable(name: &str, text: &str, error: &toml::de::Error, help: &str) -> Self {
        let span = error.span().unwrap_or_default();
        let message = match number_limit(error) {
            Some(limit) => format!("expected {limit}, found {}", &text[span.clone()]),
            None => error.message().to_owned(),
        };
        let violation = SchemaViolation {
            key: key_at(text, span.start).unwrap_or_default(),
            message,
            help: help.to_owned(),
            span,
        };
        Self::syntax(name, text, violation)
    }

    pub(super) fn invalid(name: &str, text: &str, mut invalid: InvalidValue) -> Self {
        let span = locate(text, &invalid.key);
        invalid.found = shortened(invalid.found);
        Self::Invalid {
            invalid: Box::new(invalid),
            text: NamedSource::new(name, text.to_owned()),
            span: shown(text, span),
        }
    }

    pub(super) fn no_text(path: String, error: &FromUtf8Error) -> Self {
        let bytes = error.as_bytes();
        let byte = error.utf8_error().valid_up_to();
        let line = 1 + bytes[..byte].iter().filter(|b| **b == b'\n').count();
        let found = bytes[byte];
        Self::NoScene {
            path,
            problem: format!(
                "line {line}: expected UTF-8 text, found byte 0x{found:02x} (byte {byte} of the file)"
            ),
            help: "a scene is a TOML file, such as pipelines/hkl2011_table1.toml; save it as UTF-8",
        }
    }
}

fn shortened(found: String) -> String {
    match found.char_indices().nth(LONGEST_FOUND) {
        Some((end, _)) => format!("{} … ({} bytes)", &found[..end], found.len()),
        None => found,
    }
}

/// The place to draw; none when its line or one beside it is too long for a screen.
fn shown(text: &str, span: Option<Range<usize>>) -> Option<SourceSpan> {
    let span = span.filter(|_| !text.is_empty())?;
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let end = start + line.len();
        // Two lines of context are drawn on each side; three leave room.
        let near = span.start <= end + 3 * LONGEST_LINE && start <= span.end + 3 * LONGEST_LINE;
        if near && line.len() > LONGEST_LINE {
            return None;
        }
        start = end;
    }
    Some(span.into())
}

/// The path of the innermost key or value at a byte of the text.
fn key_at(text: &str, byte: usize) -> Option<String> {
    let table = DeTable::parse(text).ok()?;
    key_in(table.get_ref(), byte)
}

fn key_in(table: &DeTable<'_>, byte: usize) -> Option<String> {
    table.iter().find_map(|(key, value)| {
        let inner = match value.get_ref() {
            DeValue::Table(table) => key_in(table, byte),
            DeValue::Array(items) => items.iter().enumerate().find_map(|(i, item)| {
                let DeValue::Table(table) = item.get_ref() else {
                    return None;
                };
                Some(format!("{i}.{}", key_in(table, byte)?))
            }),
            _ => None,
        };
        let here = key.span().contains(&byte) || value.span().contains(&byte);
        match inner {
            Some(inner) => Some(format!("{}.{inner}", key.get_ref())),
            None => here.then(|| key.get_ref().to_string()),
        }
    })
}

/// The bytes of the value at a dotted key path, or of its nearest parent that is written out.
fn locate(text: &str, key: &str) -> Option<Range<usize>> {
    let table = DeTable::parse(text).ok()?;
    Some(nearest(table.get_ref(), key)?.span())
}

/// The value at a dotted key path, or its nearest parent that is written out.
fn nearest<'a, 'i>(table: &'a DeTable<'i>, key: &str) -> Option<&'a Spanned<DeValue<'i>>> {
    let mut parts = key.split('.');
    let mut found = table.get(parts.next()?)?;
    for part in parts {
        let next = match found.get_ref() {
            DeValue::Table(table) => table.get(part),
            DeValue::Array(items) => part.parse::<usize>().ok().and_then(|i| items.get(i)),
            _ => None,
        };
        match next {
            Some(value) => found = value,
            None => break,
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_found_in_tables_and_arrays() {
        let text = "[a.b]\nc = 1.5\n[[d]]\ne = 2\n[[d]]\ne = 3\n";
        assert_eq!(&text[locate(text, "a.b.c").unwrap()], "1.5");
        assert_eq!(&text[locate(text, "d.1.e").unwrap()], "3");
        assert_eq!(locate(text, "missing"), None);
        let at = |value: &str| key_at(text, text.find(value).unwrap());
        assert_eq!(at("1.5").as_deref(), Some("a.b.c"));
        assert_eq!(at("3").as_deref(), Some("d.1.e"));
    }

    #[test]
    fn long_lines_and_values_are_not_drawn() {
        let text = format!("a = 1\n# {}\nb = 2\n", "x".repeat(5000));
        assert_eq!(shown(&text, Some(0..1)), None);
        assert!(shown("a = 1\n", Some(4..5)).is_some());
        assert!(shortened("é".repeat(5000)).len() < 1000);
    }
}

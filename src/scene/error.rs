use std::ops::Range;

use miette::{Diagnostic, NamedSource, SourceSpan};
use thiserror::Error;

/// Why a scene file cannot be used; draws the offending line.
#[derive(Debug, Error, Diagnostic)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("cannot read the scene {path}: {source}")]
    #[diagnostic(help("give the path of a scene file, such as pipelines/hkl2011_table1.toml"))]
    Read {
        /// The path as given.
        path: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// Not TOML, or not the keys and types of a scene.
    #[error("{}: {message}", text.name())]
    #[diagnostic(help("the keys, types and defaults are listed in schemas/scene.json"))]
    Syntax {
        /// What the parser says.
        message: String,
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
        invalid: Box<Invalid>,
        /// The scene text.
        #[source_code]
        text: NamedSource<String>,
        /// Where the key is.
        #[label("this value")]
        span: Option<SourceSpan>,
    },
}

/// An unusable value: the key, what it should be, what it is, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Invalid {
    /// Path of the key, such as `material.isotropic.poisson_ratio` or `traction.0.value`.
    pub key: String,
    /// What the model allows.
    pub expected: String,
    /// What the scene says.
    pub found: String,
    /// What to do about it.
    pub help: String,
}

impl SceneError {
    pub(super) fn syntax(name: &str, text: &str, error: &toml::de::Error) -> Self {
        Self::Syntax {
            message: error.message().to_owned(),
            text: NamedSource::new(name, text.to_owned()),
            span: error.span().map(SourceSpan::from),
        }
    }

    pub(super) fn invalid(name: &str, text: &str, invalid: Invalid) -> Self {
        let span = locate(text, &invalid.key).map(SourceSpan::from);
        Self::Invalid {
            invalid: Box::new(invalid),
            text: NamedSource::new(name, text.to_owned()),
            span,
        }
    }
}

/// The bytes of the value at a dotted key path, or of its nearest parent that is written out.
fn locate(text: &str, key: &str) -> Option<Range<usize>> {
    use toml::de::{DeTable, DeValue};
    let table = DeTable::parse(text).ok()?;
    let mut parts = key.split('.');
    let mut found = table.get_ref().get(parts.next()?)?;
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
    Some(found.span())
}

#[cfg(test)]
mod tests {
    use super::locate;

    #[test]
    fn keys_are_found_in_tables_and_arrays() {
        let text = "[a.b]\nc = 1.5\n[[d]]\ne = 2\n[[d]]\ne = 3\n";
        assert_eq!(&text[locate(text, "a.b.c").unwrap()], "1.5");
        assert_eq!(&text[locate(text, "d.1.e").unwrap()], "3");
        assert_eq!(locate(text, "missing"), None);
    }
}

//! Why a scene cannot be used, with the line that is at fault.

use std::{ops::Range, string::FromUtf8Error};

use miette::{Diagnostic, NamedSource, SourceSpan};
use thiserror::Error;

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
    /// Where it is, in bytes.
    pub(super) span: Range<usize>,
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

impl SceneError {
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

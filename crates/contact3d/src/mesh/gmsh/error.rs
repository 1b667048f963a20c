//! Why a Gmsh file cannot be used, with the place in the file.

use std::{fmt, path::PathBuf};

use miette::Diagnostic;
use thiserror::Error;

/// Where something stands in a mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilePosition {
    /// Line of a text file, from 1.
    Line(usize),
    /// Byte of a binary file, from 0.
    Byte(usize),
}

impl fmt::Display for FilePosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// Why a Gmsh mesh cannot be used.
#[derive(Debug, Error, Diagnostic)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum GmshError {
    /// The file cannot be read.
    #[error("cannot read the mesh {}: {source}", path.display())]
    #[diagnostic(help("check the path; one in a scene counts from the folder of the scene file"))]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The file is not the one the scene means.
    #[error("{}: expected the blake3 digest {expected}, found {found}", path.display())]
    #[diagnostic(help(
        "the mesh has changed since its digest was written down; check it and update the digest"
    ))]
    Digest {
        path: PathBuf,
        expected: String,
        found: String,
    },
    /// The unit of the file is no length.
    #[error("unit of the mesh: expected a positive length, found {found}")]
    #[diagnostic(help(
        "a mesh in millimetres has unit 0.001 in a scene in metres; coordinates times the unit must stay finite"
    ))]
    Unit { found: f64 },
    /// What is wrong in the file of this path.
    #[error("{}: {flaw}", path.display())]
    #[diagnostic(forward(flaw))]
    InFile { path: PathBuf, flaw: Box<GmshFlaw> },
}

/// What is wrong in a mesh file, and what to do about it; nodes and elements have the tags of the file.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
#[diagnostic(help("{help}"))]
pub struct GmshFlaw {
    /// Where it stands; `None` where no one place is at fault.
    pub place: Option<FilePosition>,
    /// The node, element or group it is about; none for the file itself.
    pub subject: Option<String>,
    /// What a usable file has there.
    pub expected: String,
    /// What this one has.
    pub found: String,
    /// What to do about it.
    pub help: &'static str,
}

impl GmshFlaw {
    pub(super) fn new(
        place: impl Into<Option<FilePosition>>,
        expected: impl Into<String>,
        found: impl Into<String>,
        help: &'static str,
    ) -> Self {
        Self {
            place: place.into(),
            subject: None,
            expected: expected.into(),
            found: found.into(),
            help,
        }
    }

    /// The same flaw of a node, an element or a group.
    pub(super) fn of(self, subject: impl Into<String>) -> Self {
        Self {
            subject: Some(subject.into()),
            ..self
        }
    }
}

impl fmt::Display for GmshFlaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = self.place {
            write!(f, "{place}: ")?;
        }
        if let Some(subject) = &self.subject {
            write!(f, "{subject}: ")?;
        }
        write!(f, "expected {}, found {}", self.expected, self.found)
    }
}

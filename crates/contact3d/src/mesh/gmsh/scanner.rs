//! The bytes of a mesh file, read value by value, text or binary, and what is wrong with them.

use std::fmt;

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

/// Walks through the bytes of a mesh file once, value by value.
///
/// In text a record is a line: its values are asked for between [`Self::begin_record`] and
/// [`Self::end_record`]. In binary (little-endian) the same values follow each other without marks.
pub(super) struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    pub(super) is_text: bool,
}

impl<'a> Scanner<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            line: 1,
            is_text: true,
        }
    }

    pub(super) fn place(&self) -> FilePosition {
        if self.is_text {
            FilePosition::Line(self.line)
        } else {
            FilePosition::Byte(self.at)
        }
    }

    pub(super) fn syntax(&self, expected: impl Into<String>, found: impl Into<String>) -> GmshFlaw {
        GmshFlaw::new(
            self.place(),
            expected,
            found,
            "the file is damaged or not an MSH file; save it again: gmsh part.geo -3 -format msh41 -o part.msh",
        )
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// Goes over white space to the next printed byte, on whichever line it is.
    pub(super) fn skip_blank_lines(&mut self) {
        while let Some(byte) = self.rest().first().filter(|b| b.is_ascii_whitespace()) {
            self.line += usize::from(*byte == b'\n');
            self.at += 1;
        }
    }

    fn skip_blanks(&mut self) {
        let blanks = self.rest().iter();
        self.at += blanks
            .take_while(|b| b.is_ascii_whitespace() && **b != b'\n')
            .count();
    }

    /// The next line that is not blank, trimmed; none at the end of the file.
    ///
    /// The scanner stays before the line's end, so that errors name this line.
    pub(super) fn text_line(&mut self) -> Option<&'a [u8]> {
        self.skip_blank_lines();
        let rest = self.rest();
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += length;
        Some(rest[..length].trim_ascii_end()).filter(|line| !line.is_empty())
    }

    /// Passes the one line break that stands between a header line and binary values.
    pub(super) fn end_text_line(&mut self) {
        if self.rest().first() == Some(&b'\n') {
            self.at += 1;
            self.line += 1;
        }
    }

    /// Goes behind the next place where `mark` begins a line; false when there is none.
    pub(super) fn skip_behind(&mut self, mark: &[u8]) -> bool {
        while self.at < self.bytes.len() {
            let line_start = self.at == 0 || self.bytes[self.at - 1] == b'\n';
            if line_start && self.rest().starts_with(mark) {
                self.at += mark.len();
                return true;
            }
            let rest = self.rest();
            let length = rest.iter().position(|&b| b == b'\n');
            self.at += length.map_or(rest.len(), |l| l + 1);
            self.line += usize::from(length.is_some());
        }
        false
    }

    pub(super) fn begin_record(&mut self) {
        if self.is_text {
            self.skip_blank_lines();
        }
    }

    pub(super) fn end_record(&mut self) -> Result<(), GmshFlaw> {
        if !self.is_text {
            return Ok(());
        }
        match self.token() {
            None => Ok(()),
            Some(token) => Err(self.syntax("the end of the line", shown(token))),
        }
    }

    /// The next word of this line.
    fn token(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks();
        let rest = self.rest();
        let length = rest.iter().take_while(|b| !b.is_ascii_whitespace()).count();
        self.at += length;
        Some(&rest[..length]).filter(|token| !token.is_empty())
    }

    fn word<T: std::str::FromStr>(&mut self, expected: &str) -> Result<T, GmshFlaw> {
        let Some(token) = self.token() else {
            let ended = if self.at == self.bytes.len() {
                "the end of the file"
            } else {
                "the end of the line"
            };
            return Err(self.syntax(expected, ended));
        };
        let value = std::str::from_utf8(token).ok().and_then(|t| t.parse().ok());
        value.ok_or_else(|| self.syntax(expected, shown(token)))
    }

    fn raw<const N: usize>(&mut self, expected: &str) -> Result<[u8; N], GmshFlaw> {
        let Some(value) = self.rest().first_chunk::<N>() else {
            return Err(self.syntax(expected, "the end of the file"));
        };
        self.at += N;
        Ok(*value)
    }

    /// An `int` of the format: a code, a dimension or an entity's tag.
    pub(super) fn int(&mut self, expected: &str) -> Result<i64, GmshFlaw> {
        if self.is_text {
            self.word(expected)
        } else {
            Ok(i32::from_le_bytes(self.raw(expected)?).into())
        }
    }

    /// A count, or the tag of a node or an element.
    pub(super) fn size(&mut self, expected: &str) -> Result<u64, GmshFlaw> {
        if self.is_text {
            self.word(expected)
        } else {
            Ok(u64::from_le_bytes(self.raw(expected)?))
        }
    }

    /// A `double` of the format.
    pub(super) fn real(&mut self, expected: &str) -> Result<f64, GmshFlaw> {
        if self.is_text {
            self.word(expected)
        } else {
            Ok(f64::from_le_bytes(self.raw(expected)?))
        }
    }

    /// The coordinates of a node.
    pub(super) fn node_place(&mut self) -> Result<[f64; 3], GmshFlaw> {
        let mut at = [0.0; 3];
        for x in &mut at {
            *x = self.real("a coordinate of the node")?;
        }
        Ok(at)
    }

    /// A count of items of at least `text` bytes each in text, `binary` bytes in binary, checked
    /// against the rest of the file so that it may be reserved.
    pub(super) fn count(
        &mut self,
        what: &str,
        text: usize,
        binary: usize,
    ) -> Result<usize, GmshFlaw> {
        let declared = self.size(&format!("the number of {what}"))?;
        let least = if self.is_text { text } else { binary };
        // The last line of a text may lack its line break.
        let possible = (self.rest().len() + 1) / least;
        match usize::try_from(declared) {
            Ok(count) if count <= possible => Ok(count),
            _ => Err(GmshFlaw::new(
                self.place(),
                format!("at most {possible} {what} in the rest of the file"),
                format!("the count {declared}"),
                "the file is cut off or its counts are wrong; save it again: gmsh part.geo -3 -format msh41 -o part.msh",
            )),
        }
    }
}

/// A word of the file as it goes into a message.
pub(super) fn shown(word: &[u8]) -> String {
    let longest = 40;
    let text = String::from_utf8_lossy(&word[..word.len().min(longest)]);
    let dots = if word.len() > longest { "..." } else { "" };
    format!("{:?}{dots}", text)
}

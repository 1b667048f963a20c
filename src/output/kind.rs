//! What this program writes, recognised by its contents.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
    path::Path,
};

/// Bytes looked at from either end of a file.
const END_BYTES: usize = 1 << 16;

/// Every PNG begins so.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
/// Every HDF5 file of ours begins so.
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Where the first chunk after the header of a PNG begins.
const AFTER_HEADER: usize = 33;
/// The first chunk of our PNG files: type, keyword, text.
const SOFTWARE: &[u8] = b"tEXtSoftware\0contact3d-pipe";

/// What an output is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputKind {
    /// A drawing.
    Svg,
    /// The same drawing in pixels, beside the SVG file of the same name.
    Png,
    /// The HTML page of a report.
    Page,
    /// `summary.csv` of a sweep.
    SweepTable,
    /// A generated schema as JSON.
    Schema,
    /// A generated schema as Markdown.
    SchemaPage,
    /// A frictional contact problem.
    Fclib,
    /// A page of the manual.
    ManualPage,
    /// A scene to start from. No scene is replaced, since its user may have changed it.
    Scene,
}

/// The type that files of FCLIB begin with.
pub(crate) const FCLIB_TYPE: &str = "contact3d-pipe FCLIB problem";

impl OutputKind {
    /// What messages call it.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Svg => "an SVG picture",
            Self::Png => "a PNG picture",
            Self::Page => "an HTML report",
            Self::SweepTable => "the CSV table of a sweep",
            Self::Schema => "a JSON schema",
            Self::SchemaPage => "a Markdown schema",
            Self::Fclib => "a file of FCLIB",
            Self::ManualPage => "a manual page",
            Self::Scene => "a scene",
        }
    }

    /// Whether this program wrote a file as one of this kind. An empty file holds nothing to lose.
    pub(super) fn is_of(self, path: &Path) -> io::Result<bool> {
        let first = first_bytes(path)?;
        let text = || std::str::from_utf8(&first).unwrap_or_default();
        Ok(first.is_empty()
            || match self {
                Self::Svg => is_svg(text()),
                Self::Png => is_png(&first),
                Self::Page => is_page(path, &first)?,
                Self::SweepTable => is_sweep_table(&first),
                Self::Schema => is_schema(path)?,
                Self::SchemaPage => text().starts_with(
                    "# The run file\n\nGenerated from the table of datasets; do not edit.\n",
                ),
                Self::Fclib => runfile::is_of_type(path, FCLIB_TYPE)?,
                Self::ManualPage => text().contains("\n.TH contact3d-pipe"),
                Self::Scene => false,
            })
    }
}

/// What a file seems to be, for messages.
pub(super) fn found(path: &Path) -> &'static str {
    let Ok(head) = first_bytes(path) else {
        return "a file that cannot be read";
    };
    let text = String::from_utf8_lossy(&head);
    let begins = |word: &str| text.trim_start().to_lowercase().starts_with(word);
    match () {
        () if head.starts_with(HDF5) => "an HDF5 file",
        () if head.starts_with(b"contact3d-pipe ") => "another HDF5 file of this program",
        () if head.starts_with(PNG) => "another PNG picture",
        () if begins("<svg") || (begins("<?xml") && text.contains("<svg")) => "another SVG picture",
        () if begins("<!doctype html") || begins("<html") => "another HTML page",
        () if head.contains(&0) => "a binary file",
        () => "another text",
    }
}

/// The beginning of a file.
fn first_bytes(path: &Path) -> io::Result<Vec<u8>> {
    let mut first = Vec::new();
    let file = File::open(path)?;
    file.take(END_BYTES as u64).read_to_end(&mut first)?;
    while let Err(error) = std::str::from_utf8(&first) {
        // The last character may be cut in two.
        if error.error_len().is_some() || first.len() < END_BYTES {
            break;
        }
        first.truncate(error.valid_up_to());
    }
    Ok(first)
}

/// The end of a file.
fn last_bytes(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let mut last = Vec::new();
    let length = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(length.saturating_sub(END_BYTES as u64)))?;
    file.read_to_end(&mut last)?;
    Ok(last)
}

/// The root element of our drawings, with its attributes in their order.
fn is_svg(text: &str) -> bool {
    let root = text
        .strip_prefix(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"",
        )
        .and_then(|rest| rest.split_once('>'));
    root.is_some_and(|(root, _)| {
        root.ends_with("font-family=\"'DejaVu Sans', Verdana, sans-serif\" fill=\"#1a1a1a\"")
    })
}

/// Marked by us.
fn is_png(bytes: &[u8]) -> bool {
    let chunk = bytes.get(AFTER_HEADER + 4..).unwrap_or_default();
    bytes.starts_with(PNG) && chunk.starts_with(SOFTWARE)
}

/// Our head, and our name at the end.
fn is_page(path: &Path, first: &[u8]) -> io::Result<bool> {
    let head = b"<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\">";
    if !first.starts_with(head) {
        return Ok(false);
    }
    let last = last_bytes(path)?;
    let last = String::from_utf8_lossy(&last);
    Ok(last.contains("<footer><p>contact3d-pipe ") && last.ends_with("</footer></body></html>\n"))
}

/// The columns of our table; those between belong to the sweep.
fn is_sweep_table(bytes: &[u8]) -> bool {
    let mut reader = csv::Reader::from_reader(bytes);
    let Ok(head) = reader.headers() else {
        return false;
    };
    let names: Vec<&str> = head.iter().collect();
    names.starts_with(&["id", "planned"])
        && names.contains(&"solve_digest")
        && names
            .windows(3)
            .any(|w| *w == ["status", "error", "method"])
}

/// A JSON object that describes one of our files.
fn is_schema(path: &Path) -> io::Result<bool> {
    let Ok(schema) =
        serde_json::from_reader::<_, serde_json::Value>(io::BufReader::new(File::open(path)?))
    else {
        return Ok(false);
    };
    let text = |key: &str| schema[key].as_str().unwrap_or_default();
    let has = |keys: &[&str]| {
        keys.iter()
            .all(|key| schema["properties"].get(key).is_some())
    };
    Ok(match text("title") {
        "Scene" => has(&["title", "body", "material", "clamp", "solve"]),
        "SweepFile" => has(&["scene", "set", "axis"]),
        _ => {
            text("filetype").starts_with("contact3d-pipe ")
                && schema.get("format_version").is_some()
                && schema.get("root_attributes").is_some()
        }
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// Whether a file with some bytes is of a kind.
    fn is(kind: OutputKind, bytes: &[u8]) -> bool {
        let folder = tempfile::tempdir().expect("scratch folder");
        let file = folder.path().join("file");
        fs::write(&file, bytes).expect("a file");
        kind.is_of(&file).expect("a readable file")
    }

    #[test]
    fn every_kind_knows_its_own_and_no_other() {
        let svg = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"4\" \
                   height=\"2\" viewBox=\"0 0 4 2\" font-family=\"'DejaVu Sans', Verdana, sans-serif\" fill=\"#1a1a1a\">";
        let mut png = [PNG, &[0; AFTER_HEADER - 4]].concat();
        png.extend(SOFTWARE);
        let samples = [
            (OutputKind::Svg, svg.as_bytes()),
            (OutputKind::Png, png.as_slice()),
            (
                OutputKind::Page,
                b"<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"></head><body>\
                  <footer><p>contact3d-pipe 0.1.0, from</p></footer></body></html>\n",
            ),
            (
                OutputKind::SweepTable,
                b"id,planned,a.b,status,error,method,seconds,solve_digest\n",
            ),
            (
                OutputKind::Schema,
                b"{\"title\": \"SweepFile\", \"properties\": {\"scene\": 1, \"set\": 1, \"axis\": 1}}",
            ),
            (
                OutputKind::SchemaPage,
                b"# The run file\n\nGenerated from the table of datasets; do not edit.\n\nmore",
            ),
        ];
        for (kind, _) in samples {
            for (other, bytes) in samples {
                assert_eq!(is(kind, bytes), kind == other, "{kind:?}, {other:?}");
            }
            assert!(is(kind, b""));
            assert!(!is(kind, b"my notes\n"), "{kind:?}");
            assert!(!is(kind, HDF5), "{kind:?}");
        }
    }

    /// A page that only speaks of this program is somebody else's.
    #[test]
    fn a_mention_makes_no_file_ours() {
        assert!(!is(
            OutputKind::Page,
            b"<!DOCTYPE html><html lang=\"en\"><p>contact3d-pipe 0.1.0</p></html>\n"
        ));
        assert!(!is(OutputKind::Svg, b"<svg><!-- contact3d-pipe --></svg>"));
        assert!(!is(OutputKind::Schema, b"{\"title\": \"Scene\"}"));
    }
}

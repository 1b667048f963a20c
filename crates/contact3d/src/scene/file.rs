//! A scene with the text it was read from: files of bounded size, and scenes written back as text.

use std::{
    fmt,
    fs::{self, File, FileType},
    io::{self, ErrorKind, Read},
    path::{Path, PathBuf},
};

use serde::Serialize;

use super::{InvalidValue, Scene, SceneError, Source};

/// Longest scene in bytes; a friction law of 1000 × 200 values stays below.
pub const LONGEST_SCENE: u64 = 4_000_000;

/// A scene with the text it was read from, so that later errors can still show the line.
#[derive(Debug, Clone)]
pub struct SceneFile {
    /// The validated scene.
    pub scene: Scene,
    /// The folder in which mesh files are looked for.
    pub folder: PathBuf,
    /// The file itself; the source is named by how it was changed, too.
    origin: String,
    source: Source,
}

impl SceneFile {
    /// Reads and validates a scene, from a file or a pipe.
    ///
    /// # Errors
    /// A folder or device, a file or pipe that cannot be read, is too long or no UTF-8 text, or is
    /// no scene.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let name = path.display().to_string();
        let bytes = read_bounded(path, LONGEST_SCENE).map_err(|source| SceneError::Read {
            path: name.clone(),
            source,
        })?;
        if let Some((found, help)) = other_file(&bytes, path) {
            return Err(SceneError::NoScene {
                path: name,
                problem: format!("expected a scene, found {found}"),
                help,
            });
        }
        if bytes.len() as u64 > LONGEST_SCENE {
            return Err(SceneError::NoScene {
                path: name,
                problem: format!("expected at most {LONGEST_SCENE} bytes, found more"),
                help: "is this a scene? Thin out long tables of friction coefficients",
            });
        }
        let text =
            String::from_utf8(bytes).map_err(|error| SceneError::no_text(name.clone(), &error))?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Self::parse(name, &text, folder)
    }

    /// Parses and validates a scene's text; `name` is the file's name for messages.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn parse(name: String, text: &str, folder: PathBuf) -> Result<Self, SceneError> {
        let (scene, source): (Scene, _) = Source::read(&name, text, "scene")?;
        let scene = scene.checked().map_err(|invalid| source.refuse(invalid))?;
        Ok(Self {
            scene,
            folder,
            origin: name,
            source,
        })
    }

    /// The scene with other text in its place; `changes` says, for messages, what is other than in
    /// the file.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn changed(&self, changes: &str, text: &str) -> Result<Self, SceneError> {
        let name = format!("{} with {changes}", self.origin);
        Ok(Self {
            origin: self.origin.clone(),
            ..Self::parse(name, text, self.folder.clone())?
        })
    }

    /// Whether the text itself gives a key, its default or not.
    #[must_use]
    pub fn gives(&self, key: &str) -> bool {
        self.source.gives(key)
    }

    /// An error that shows the line of an unusable value.
    #[must_use]
    pub fn refuse(&self, invalid: InvalidValue) -> SceneError {
        self.source.refuse(invalid)
    }
}

/// What a file is, by its first bytes or its name, that is no scene, and what to do with it.
pub(crate) fn other_file(bytes: &[u8], path: &Path) -> Option<(&'static str, &'static str)> {
    let is_stl = path
        .extension()
        .is_some_and(|it| it.eq_ignore_ascii_case("stl"));
    // HDF5 begins a file, or what follows 512 bytes of a program.
    let begins = |from: usize| {
        bytes
            .get(from..)
            .is_some_and(|rest| rest.starts_with(b"\x89HDF"))
    };
    if begins(0) || begins(512) {
        let help =
            "`contact3d-pipe status FILE` shows a run file, whose scene is its text /scene/toml";
        return Some(("an HDF5 file, perhaps a run file", help));
    }
    if bytes.starts_with(b"$MeshFormat") {
        let help = "`contact3d-pipe inspect MESH --scene part.toml` writes a scene for a mesh";
        return Some(("a mesh of Gmsh", help));
    }
    let help = "an STL has a surface alone: fill it with tetrahedra, as by `gmsh -3` of a .geo with Merge, Surface Loop and Volume, \
                then `contact3d-pipe inspect`";
    is_stl.then_some(("an STL", help))
}

/// Refuses what is not a regular file: a folder, a device, a pipe.
///
/// # Errors
/// What the system says about a path that cannot be looked at, `InvalidInput` for what is no
/// regular file.
pub fn require_regular(path: &Path) -> io::Result<()> {
    let kind = fs::metadata(path)?.file_type();
    if kind.is_file() {
        Ok(())
    } else {
        Err(refused("a regular file", kind))
    }
}

/// The bytes of a regular file or of a pipe such as `<(command)`: at most `longest` and one more,
/// by which the caller sees that there are too many.
///
/// # Errors
/// What the system says, `InvalidInput` for a folder or device.
pub fn read_bounded(path: &Path, longest: u64) -> io::Result<Vec<u8>> {
    let kind = fs::metadata(path)?.file_type();
    if !kind.is_file() && !is_pipe(kind) {
        return Err(refused("a regular file or a pipe", kind));
    }
    let mut bytes = Vec::new();
    File::open(path)?
        .take(longest + 1)
        .read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn refused(expected: &str, found: FileType) -> io::Error {
    let found = format!("expected {expected}, found {}", kind_words(found));
    io::Error::new(ErrorKind::InvalidInput, found)
}

/// What a path leads to, in words.
fn kind_words(kind: FileType) -> &'static str {
    if kind.is_file() {
        "a regular file"
    } else if kind.is_dir() {
        "a folder"
    } else if is_pipe(kind) {
        "a pipe"
    } else {
        special_words(kind)
    }
}

#[cfg(unix)]
fn special_words(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match (kind.is_socket(), kind.is_block_device()) {
        (true, _) => "a socket",
        (_, true) => "a block device",
        _ => "a character device",
    }
}

#[cfg(not(unix))]
fn special_words(_: FileType) -> &'static str {
    "something else"
}

#[cfg(unix)]
fn is_pipe(kind: FileType) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&kind)
}

#[cfg(not(unix))]
fn is_pipe(_: FileType) -> bool {
    false
}

/// A value as a scene writes it, in one line of TOML; numbers in their shortest form.
pub struct Written<'a, T>(pub &'a T);

impl<T: Serialize> fmt::Display for Written<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match toml::Value::try_from(self.0) {
            Ok(value) => f.write_str(&to_toml(&value)),
            Err(error) => write!(f, "{error}"),
        }
    }
}

/// A value of TOML as a scene writes it.
#[must_use]
pub fn to_toml(value: &toml::Value) -> String {
    let joined = |items: Vec<String>| items.join(", ");
    match value {
        toml::Value::Float(value) if value.is_nan() => "nan".to_owned(),
        toml::Value::Float(value) => format!("{value:?}"),
        toml::Value::Array(items) => format!("[{}]", joined(items.iter().map(to_toml).collect())),
        toml::Value::Table(table) => {
            let pairs = table.iter();
            let pairs = pairs.map(|(key, value)| format!("{key} = {}", to_toml(value)));
            format!("{{ {} }}", joined(pairs.collect()))
        }
        other => other.to_string(),
    }
}

/// Whether a character moves the cursor, gives the terminal a command or turns the direction of
/// text instead of being seen.
#[must_use]
pub fn is_hidden_control(c: char) -> bool {
    let turns_text =
        matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || turns_text
}

/// Text for one line of a page or a terminal: control characters are shown by their escapes, such
/// as `\n` and `\u{1b}`.
#[must_use]
pub fn escape_control(text: &str) -> String {
    with_escapes(text, is_hidden_control)
}

/// Text of several lines, as [`escape_control`] but with its ends of lines and tabs.
#[must_use]
pub fn escape_control_lines(text: &str) -> String {
    with_escapes(text, |c| is_hidden_control(c) && c != '\n' && c != '\t')
}

fn with_escapes(text: &str, is_hidden: impl Fn(char) -> bool) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if is_hidden(c) {
            shown.extend(c.escape_default())
        } else {
            shown.push(c)
        }
    }
    shown
}

impl Scene {
    /// The title as pages, pictures and terminals show it; files and JSON hold it as it is.
    #[must_use]
    pub fn shown_title(&self) -> String {
        escape_control(&self.title)
    }
}

//! What may be written where: not over the files that a command reads, nor over a file of another kind.

use std::{
    fs::{self, FileType, Permissions},
    io,
    path::{Path, PathBuf},
};

use runfile::follow_link;
use thiserror::Error;

use super::{OutputKind, kind};

/// Why an output cannot be written.
#[derive(Debug, Error)]
pub enum OutputError {
    /// The output is one of the files that the command reads.
    #[error("{}: this command reads that file ({}); nothing was changed, choose another output", file.display(), input.display())]
    IsInput { file: PathBuf, input: PathBuf },
    /// The file is there and this program did not write it as what it would be now.
    #[error("{}: expected {expected} of this program or no file, found {found}; nothing was changed, choose another output or move the file away", file.display())]
    Foreign {
        file: PathBuf,
        expected: &'static str,
        found: &'static str,
    },
    /// Something that cannot be written to.
    #[error("{}: expected a file, found {found}; nothing was changed, choose another output", file.display())]
    NotAFile { file: PathBuf, found: &'static str },
    /// A folder for outputs cannot be made or written to.
    #[error("{}: expected a folder to write to, found {found}; nothing was changed, choose another folder", folder.display())]
    Folder { folder: PathBuf, found: String },
    /// The file system failed.
    #[error("{}: cannot {action}: {source}; check the free space and the permissions of the folder, or choose another output", file.display())]
    Io {
        file: PathBuf,
        action: &'static str,
        source: io::Error,
    },
}

impl OutputError {
    /// Whether the machine failed rather than the input being at fault.
    pub fn is_of_machine(&self) -> bool {
        matches!(self, Self::Io { .. })
    }
}

/// The files that a command reads; those that do not exist cannot be written over and are left out.
#[derive(Debug, Clone, Default)]
pub struct Inputs(Vec<(PathBuf, Identity)>);

/// What two paths to one file have in common, links followed: its device and number where the system has them.
#[cfg(unix)]
type Identity = (u64, u64);
#[cfg(not(unix))]
type Identity = PathBuf;

#[cfg(unix)]
fn identity(path: &Path) -> io::Result<Identity> {
    use std::os::unix::fs::MetadataExt;
    let metadata = fs::metadata(path)?;
    Ok((metadata.dev(), metadata.ino()))
}

#[cfg(not(unix))]
fn identity(path: &Path) -> io::Result<Identity> {
    fs::canonicalize(path)
}

impl Inputs {
    /// The files at some paths.
    pub fn of<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) -> Self {
        let mut inputs = Self::default();
        for path in paths {
            inputs.add(path.as_ref());
        }
        inputs
    }

    /// One more file.
    pub fn add(&mut self, path: &Path) {
        if let Ok(identity) = identity(path) {
            self.0.push((path.to_owned(), identity));
        }
    }

    /// Refuses an output that is one of these files, by whatever path.
    pub fn refuse(&self, output: &Path) -> Result<(), OutputError> {
        let output_is = identity(output).ok();
        let mut inputs = self.0.iter();
        match inputs.find(|(_, input)| Some(input) == output_is.as_ref()) {
            None => Ok(()),
            Some((input, _)) => Err(OutputError::IsInput {
                file: output.to_owned(),
                input: input.clone(),
            }),
        }
    }
}

/// Where the bytes of an output go.
#[derive(Debug)]
pub(super) enum Destination {
    /// A file that is not there, or one of our own that is replaced, whose permissions stay; symbolic links are followed.
    File(PathBuf, Option<Permissions>),
    /// A terminal, a pipe or the like, which holds nothing to lose.
    Stream(PathBuf),
}

/// Refuses an output that is an input, or that is there and not of its own kind. Changes nothing.
pub fn admit(path: &Path, kind: OutputKind, inputs: &Inputs) -> Result<(), OutputError> {
    place(path, kind, inputs).map(drop)
}

pub(super) fn place(
    path: &Path,
    kind: OutputKind,
    inputs: &Inputs,
) -> Result<Destination, OutputError> {
    let failed = |action: &'static str| {
        move |source| OutputError::Io {
            file: path.to_owned(),
            action,
            source,
        }
    };
    inputs.refuse(path)?;
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return Ok(Destination::File(path.to_owned(), None));
        }
        looked => looked.map_err(failed("look at the file"))?,
    };
    let file = follow_link(path).map_err(failed("follow the symbolic link"))?;
    let metadata = fs::metadata(&file).map_err(failed("look at the file"))?;
    if is_stream(metadata.file_type()) {
        return Ok(Destination::Stream(file));
    }
    if !metadata.is_file() {
        let found = if metadata.is_dir() {
            "a folder"
        } else {
            "a device"
        };
        let file = path.to_owned();
        return Err(OutputError::NotAFile { file, found });
    }
    if !kind.is_of(&file).map_err(failed("read the file there"))? {
        return Err(OutputError::Foreign {
            file: path.to_owned(),
            expected: kind.name(),
            found: kind::found(&file),
        });
    }
    let permissions = metadata.permissions();
    if permissions.readonly() {
        let source = io::ErrorKind::PermissionDenied.into();
        return Err(failed("replace a write-protected file")(source));
    }
    Ok(Destination::File(file, Some(permissions)))
}

#[cfg(unix)]
fn is_stream(kind: FileType) -> bool {
    use std::os::unix::fs::FileTypeExt;
    kind.is_char_device() || kind.is_fifo() || kind.is_socket()
}

#[cfg(not(unix))]
fn is_stream(_: FileType) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_do_not_hide_an_input() {
        let folder = tempfile::tempdir().expect("scratch folder");
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a"), "text").expect("a file");
        fs::write(path("other"), "text").expect("a file");
        fs::hard_link(path("a"), path("hard")).expect("a hard link");
        #[cfg(unix)]
        std::os::unix::fs::symlink(path("a"), path("soft")).expect("a symbolic link");
        let inputs = Inputs::of([path("a"), path("missing")]);
        for name in [
            "a",
            "hard",
            #[cfg(unix)]
            "soft",
        ] {
            let refused = inputs.refuse(&path(name));
            assert!(
                matches!(refused, Err(OutputError::IsInput { .. })),
                "{name}"
            );
        }
        for name in ["other", "missing"] {
            inputs.refuse(&path(name)).expect("no input");
        }
    }
}

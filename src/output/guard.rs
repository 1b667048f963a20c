//! Where the bytes of an output go.

use std::{
    fs::{self, FileType, Permissions},
    io,
    path::{Path, PathBuf},
};

use super::{Inputs, OutputError, OutputKind, kind};

/// Where the bytes of an output go.
#[derive(Debug)]
pub(super) enum Destination {
    /// A file that is not there.
    New(PathBuf),
    /// A file of our own that is replaced; symbolic links are followed.
    Old(PathBuf, Permissions),
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
            return Ok(Destination::New(path.to_owned()));
        }
        looked => looked.map_err(failed("look at the file"))?,
    };
    let file = fs::canonicalize(path).map_err(failed("follow the symbolic link"))?;
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
    Ok(Destination::Old(file, permissions))
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

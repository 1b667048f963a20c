//! Files that belong together, written whole or not at all.

use std::{
    fs::{self, File},
    io::{self, Seek, Write},
    path::{Path, PathBuf},
};

use runfile::{Temporary, is_same, open_stream, remove_left_overs};

use super::{
    Inputs, OutputError, OutputKind,
    guard::{Destination, place},
};

/// A file to be written.
#[derive(Debug, Clone)]
pub struct OutputFile {
    /// Where.
    pub path: PathBuf,
    /// As what.
    pub kind: OutputKind,
    /// What.
    pub bytes: Vec<u8>,
}

/// Writes files that belong together: all are admitted before one is changed, and all are written
/// beside their places, synced and read back before the first is renamed, so that none is ever cut off.
///
/// # Errors
/// As [`super::admit`]; [`OutputError::Io`] if writing fails.
pub fn write(files: &[OutputFile], inputs: &Inputs) -> Result<(), OutputError> {
    let places = files
        .iter()
        .map(|file| place(&file.path, file.kind, inputs));
    let places = places.collect::<Result<Vec<Destination>, OutputError>>()?;
    let mut written = Vec::new();
    for (file, place) in files.iter().zip(places) {
        let failed = |source| OutputError::Io {
            file: file.path.clone(),
            action: "write the file",
            source,
        };
        match place {
            Destination::Stream(stream) => {
                let wrote =
                    open_stream(&stream).and_then(|mut stream| stream.write_all(&file.bytes));
                wrote.map_err(failed)?;
            }
            Destination::File(target, permissions) => {
                let hidden = hidden_copy(&target, file, permissions).map_err(failed)?;
                written.push((hidden, target));
            }
        }
    }
    for (hidden, target) in written {
        let published = hidden.publish(&target);
        published.map_err(|source| OutputError::Io {
            file: target,
            action: "write the file",
            source,
        })?;
    }
    Ok(())
}

/// A file written under a hidden name beside its place.
fn hidden_copy(
    target: &Path,
    file: &OutputFile,
    permissions: Option<fs::Permissions>,
) -> io::Result<Temporary> {
    remove_left_overs(target);
    let create = |path: &Path| File::create_new(path).map(drop);
    let (temporary, mut part, ()) = Temporary::beside(target, create)?;
    part.write_all(&file.bytes)?;
    part.sync_all()?;
    part.rewind()?;
    if !is_same(&part, &file.bytes[..])? {
        let what = "the disk gives back something else than was written";
        return Err(io::Error::other(what));
    }
    if let Some(permissions) = permissions {
        part.set_permissions(permissions)?;
    }
    Ok(temporary)
}

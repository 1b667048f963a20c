//! The text of a sweep or suite file.

use std::{
    io::{Error, ErrorKind},
    path::Path,
};

use contact3d::scene::{LONGEST_SCENE, read_bounded};

use super::StageError;

/// The text of a file that lists scenes, a sweep or a suite, which may come through a pipe and be
/// as long as a scene.
///
/// # Errors
/// `Io` for what cannot be read, is longer or no UTF-8 text.
pub fn read(path: &Path, action: &'static str) -> Result<String, StageError> {
    let text = read_bounded(path, LONGEST_SCENE).and_then(|bytes| {
        if bytes.len() as u64 > LONGEST_SCENE {
            let found = format!("expected at most {LONGEST_SCENE} bytes, found more");
            return Err(Error::new(ErrorKind::InvalidData, found));
        }
        String::from_utf8(bytes).map_err(|error| {
            let byte = error.utf8_error().valid_up_to();
            let found = format!("expected UTF-8 text, found something else at byte {byte}");
            Error::new(ErrorKind::InvalidData, found)
        })
    });
    text.map_err(|source| StageError::Io {
        action,
        file: path.to_owned(),
        source,
    })
}

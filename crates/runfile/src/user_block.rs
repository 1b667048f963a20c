//! How files of this program begin: with their type, and the digest of all bytes that follow.
//!
//! HDF5 leaves the first 512 bytes of a file to the program that writes it. A file that another program opens for writing and does
//! not change keeps them, and stays as it was written.

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use blake3::Hasher;

use crate::digest::{DIGEST_BLOCK_BYTES, add_bytes};
use crate::error::{AtFile, StoreError};
use crate::hdf5_file::FileState;

/// Bytes before those of HDF5: the fewest that it allows.
pub(super) const USER_BLOCK_BYTES: usize = 512;

/// How HDF5 files of other programs begin.
const HDF5_SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";

/// A file that was not changed for so long has another time of change once it is: clocks of file systems tick less often.
const TICK: Duration = Duration::from_millis(20);

/// Files that this process has read whole and found to be as they were written.
static UNALTERED: LazyLock<Mutex<HashSet<FileState>>> = LazyLock::new(Mutex::default);

/// Puts the user block into a file whose other bytes are written.
pub(super) fn write(file: &mut File, filetype: &str) -> io::Result<()> {
    let block = block_of(file, filetype)?;
    file.rewind()?;
    file.write_all(&block)?;
    if first_bytes(file)? == block {
        Ok(())
    } else {
        let what = "the disk gives back other bytes than were written";
        Err(io::Error::other(what))
    }
}

/// Refuses a file that is of another type, or not as it was written.
///
/// # Errors
/// `NotHdf5`, `NotOurs` or `Altered`; `Io` if the file cannot be read.
pub(super) fn check(path: &Path, filetype: &'static str) -> Result<(), StoreError> {
    let state = FileState::of(path);
    let read = |file: &mut File| {
        let first = first_bytes(file)?;
        let is_ours = type_of(&first) == Some(filetype);
        let is_known = unaltered().contains(&state);
        let is_unaltered = is_ours && (is_known || first == block_of(file, filetype)?);
        Ok((first, is_unaltered))
    };
    let read = File::open(path).and_then(|mut file| read(&mut file));
    let (first, is_unaltered) = read.at_file(path, "read the file")?;
    if is_unaltered {
        note_unaltered(state);
        return Ok(());
    }
    let file = path.into();
    Err(match type_of(&first) {
        Some(found) if found == filetype => StoreError::Altered { file },
        Some(found) => StoreError::NotOurs {
            file,
            expected: filetype,
            found: format!("\"{found}\""),
        },
        None if first.starts_with(HDF5_SIGNATURE) => StoreError::NotOurs {
            file,
            expected: filetype,
            found: "none (an HDF5 file of another program, or of a format before 2.0)".into(),
        },
        None => StoreError::NotHdf5 { file },
    })
}

fn unaltered() -> MutexGuard<'static, HashSet<FileState>> {
    UNALTERED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Has this process take files of a state as they were written, unless the last change is so recent that another could hide behind it.
pub(super) fn note_unaltered(state: FileState) {
    if state.is_older_than(TICK) {
        unaltered().insert(state);
    }
}

/// Whether a file begins as those of a type do, as it was written or altered since.
///
/// # Errors
/// Those of reading it.
pub fn is_of_type(path: &Path, filetype: &str) -> io::Result<bool> {
    let first = first_bytes(&mut File::open(path)?)?;
    Ok(type_of(&first) == Some(filetype))
}

/// The second line of a user block.
const DIGEST_LINE: &str = "BLAKE3 of all bytes from 512 on:";

/// The type that a user block names.
fn type_of(block: &[u8]) -> Option<&str> {
    let mut lines = block.split(|byte| *byte == b'\n');
    let filetype = std::str::from_utf8(lines.next()?).ok()?;
    (lines.next()? == DIGEST_LINE.as_bytes()).then_some(filetype)
}

/// The user block that fits a file.
fn block_of(file: &mut File, filetype: &str) -> io::Result<Vec<u8>> {
    file.seek(SeekFrom::Start(USER_BLOCK_BYTES as u64))?;
    let length = file.metadata()?.len().min(DIGEST_BLOCK_BYTES as u64);
    // One byte more, so that reading sees the end of a small file at once.
    let (mut hasher, mut bytes) = (Hasher::new(), Vec::with_capacity(length as usize + 1));
    loop {
        bytes.clear();
        let limit = DIGEST_BLOCK_BYTES as u64;
        if file.take(limit).read_to_end(&mut bytes)? == 0 {
            break;
        }
        add_bytes(&mut hasher, &bytes);
    }
    let digest = hasher.finalize().to_hex();
    let mut block = format!("{filetype}\n{DIGEST_LINE}\n{digest}\n").into_bytes();
    block.resize(USER_BLOCK_BYTES, 0);
    Ok(block)
}

fn first_bytes(file: &mut File) -> io::Result<Vec<u8>> {
    file.rewind()?;
    let mut first = Vec::new();
    file.take(USER_BLOCK_BYTES as u64).read_to_end(&mut first)?;
    Ok(first)
}

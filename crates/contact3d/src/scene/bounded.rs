//! Reading what may be no file at all, in bounded time and memory.

use std::{
    fs::{self, File, FileType},
    io::{self, ErrorKind, Read},
    path::Path,
    sync::mpsc::{self, RecvTimeoutError},
    thread,
    time::Duration,
};

/// How long a pipe may have nobody who writes to it.
const OPENING: Duration = Duration::from_secs(5);

/// How long the writer of a pipe may be silent.
const SILENCE: Duration = Duration::from_secs(60);

/// Bytes that are read from a pipe at once.
const CHUNK: usize = 64 * 1024;

/// Refuses what is not a regular file: a folder, a device, a pipe.
///
/// # Errors
/// What the system says about a path that cannot be looked at, `InvalidInput` for what is no
/// regular file.
pub fn require_regular(path: &Path) -> io::Result<()> {
    let kind = fs::metadata(path)?.file_type();
    match kind.is_file() {
        true => Ok(()),
        false => Err(refused("a regular file", kind)),
    }
}

/// The bytes of a regular file or of a pipe such as `<(command)`: at most `longest` and one more,
/// by which the caller sees that there are too many.
///
/// # Errors
/// What the system says, `InvalidInput` for a folder or device, `TimedOut` for a pipe without a
/// writer or with one that says nothing for a minute.
pub fn read_bounded(path: &Path, longest: u64) -> io::Result<Vec<u8>> {
    let kind = fs::metadata(path)?.file_type();
    let mut bytes = Vec::new();
    if kind.is_file() {
        File::open(path)?
            .take(longest + 1)
            .read_to_end(&mut bytes)?;
        return Ok(bytes);
    }
    match is_pipe(kind) {
        true => read_pipe(path, longest),
        false => Err(refused("a regular file or a pipe", kind)),
    }
}

/// Reads in a thread of its own, which a silent writer may hold up without holding up the program.
fn read_pipe(path: &Path, longest: u64) -> io::Result<Vec<u8>> {
    let (sender, receiver) = mpsc::sync_channel(1);
    let pipe = path.to_owned();
    thread::Builder::new().spawn(move || {
        let mut file = match File::open(pipe) {
            Ok(file) => file,
            Err(error) => return drop(sender.send(Err(error))),
        };
        // An empty chunk says that there is a writer.
        let mut chunk = Ok(Vec::new());
        while sender.send(chunk).is_ok() {
            let mut bytes = vec![0; CHUNK];
            chunk = match file.read(&mut bytes) {
                Ok(0) => return,
                Ok(read) => {
                    bytes.truncate(read);
                    Ok(bytes)
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => Ok(Vec::new()),
                Err(error) => return drop(sender.send(Err(error))),
            };
        }
    })?;
    let mut all: Vec<u8> = Vec::new();
    let mut patience = OPENING;
    let mut waits_for = "somebody who writes to the pipe";
    while all.len() as u64 <= longest {
        match receiver.recv_timeout(patience) {
            Ok(chunk) => all.extend(chunk?),
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {
                let seconds = patience.as_secs();
                let found = format!("expected {waits_for}, found silence for {seconds} s");
                return Err(io::Error::new(ErrorKind::TimedOut, found));
            }
        }
        patience = SILENCE;
        waits_for = "text from the pipe";
    }
    Ok(all)
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

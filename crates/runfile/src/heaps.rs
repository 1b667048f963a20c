//! Global heaps, where HDF5 keeps texts of any length, walked before the library reads one.
//!
//! A heap is a row of objects, each of which says how long it is. HDF5 goes from one to the next, and never ends where a free
//! one says that it has no bytes. What else may be wrong in a heap, the library finds itself.

use std::collections::HashSet;
use std::fs::File;
use std::io;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use hdf5_metno as hdf5;

use crate::error::{AtFile, AtPlace, Place, StoreError};
use crate::volume::{FileState, TICK};

/// How a heap begins: its name, the version, zeros.
const SIGNATURE: &[u8; 8] = b"GCOL\x01\0\0\0";

/// Bytes looked at together.
const STRETCH: usize = 64;

/// Files of this process whose heaps have been walked.
static WALKED: LazyLock<Mutex<HashSet<FileState>>> = LazyLock::new(Mutex::default);

/// Bytes searched at a time.
const BLOCK: u64 = 1 << 18;

/// Refuses a file with a heap that has no end.
///
/// # Errors
/// `Damaged`; `Io` if the file cannot be read.
pub(super) fn check(file: &hdf5::File, place: Place<'_>) -> Result<(), StoreError> {
    let stamp = FileState::of(place.file);
    if walked().contains(&stamp) {
        return Ok(());
    }
    let creation = file.fcpl().and_then(|creation| creation.get_sizes());
    let sizes = creation.at(place, "read how it is laid out")?;
    let problem = File::open(place.file).and_then(|source| {
        let bytes = source.metadata()?.len();
        let width = sizes.sizeof_size as usize;
        Heaps {
            source,
            bytes,
            width,
        }
        .problem()
    });
    match problem.at_file(place.file, "look at its heaps")? {
        None => {
            remember(stamp);
            Ok(())
        }
        Some((at, what)) => Err(place.damaged(format!("the heap of texts at byte {at} {what}"))),
    }
}

/// Spares a file the walk whose texts HDF5 has just written and read back in this process.
pub(super) fn trust(path: &Path) {
    remember(FileState::of(path));
}

fn remember(stamp: FileState) {
    if stamp.is_older_than(TICK) {
        walked().insert(stamp);
    }
}

fn walked() -> MutexGuard<'static, HashSet<FileState>> {
    WALKED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file with the number of bytes of a length in it.
struct Heaps {
    source: File,
    bytes: u64,
    width: usize,
}

impl Heaps {
    /// The first heap that is not to be read, and why.
    fn problem(&mut self) -> io::Result<Option<(u64, &'static str)>> {
        let mut block = Vec::with_capacity(BLOCK as usize);
        let (mut start, mut end) = (0, 0);
        loop {
            let kept = block.len() as u64;
            self.source.seek(SeekFrom::Start(start + kept))?;
            let read = (&mut self.source)
                .take(BLOCK - kept)
                .read_to_end(&mut block)?;
            for place in signatures(&block) {
                let at = start + place as u64;
                let Some(size) = self.size(at)? else {
                    continue;
                };
                if at < end {
                    return Ok(Some((at, "lies in another one")));
                }
                end = at + size;
                if !self.has_end(at, size)? {
                    return Ok(Some((at, "has no end")));
                }
            }
            if read == 0 {
                return Ok(None);
            }
            // A signature may begin here and go on in the next block.
            let done = block.len().saturating_sub(SIGNATURE.len() - 1);
            start += done as u64;
            block.drain(..done);
        }
    }

    /// The bytes of the heap at a place; `None` for one that the file does not have, which HDF5 refuses.
    fn size(&mut self, at: u64) -> io::Result<Option<u64>> {
        self.source.seek(SeekFrom::Start(at))?;
        let mut header = vec![0; self.header()];
        let size = match (&self.source).read_exact(&mut header) {
            Ok(()) => self.length(&header),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
            Err(error) => return Err(error),
        };
        Ok(Some(size).filter(|size| *size <= self.bytes - at))
    }

    /// Whether HDF5 comes to the end of a heap, or to something that it refuses.
    fn has_end(&mut self, at: u64, size: u64) -> io::Result<bool> {
        let mut header = vec![0; self.header()];
        let prefix = header.len() as u64;
        self.source.seek(SeekFrom::Start(at + prefix))?;
        let mut objects = BufReader::new(&self.source);
        let mut left = size.saturating_sub(prefix);
        while left >= prefix {
            objects.read_exact(&mut header)?;
            let length = self.length(&header);
            // The object of number 0 is the free space, its header included.
            let taken = match header[..2] {
                [0, 0] => Some(length),
                _ => length
                    .checked_next_multiple_of(8)
                    .and_then(|length| length.checked_add(prefix)),
            };
            match taken.filter(|taken| *taken <= left) {
                Some(0) => return Ok(false),
                Some(taken) => {
                    left -= taken;
                    objects.seek_relative(taken.cast_signed() - prefix.cast_signed())?;
                }
                None => return Ok(true),
            }
        }
        Ok(true)
    }

    /// Bytes before the objects of a heap, and before the data of an object: eight, a length, and zeros up to a multiple of eight.
    fn header(&self) -> usize {
        (SIGNATURE.len() + self.width).next_multiple_of(8)
    }

    fn length(&self, header: &[u8]) -> u64 {
        let bytes = header[SIGNATURE.len()..][..self.width].iter().rev();
        let length = bytes.fold(0_u128, |length, byte| {
            length.saturating_mul(256).saturating_add(u128::from(*byte))
        });
        u64::try_from(length).unwrap_or(u64::MAX)
    }
}

/// Where signatures are: stretches without the first letter, most of them, are passed over at once.
fn signatures(block: &[u8]) -> impl Iterator<Item = usize> + '_ {
    let first = SIGNATURE[0];
    let stretches = block.chunks(STRETCH).enumerate();
    let with_it = stretches.filter(move |(_, stretch)| {
        stretch
            .iter()
            .fold(false, |found, byte| found | (*byte == first))
    });
    let places = with_it.flat_map(|(k, stretch)| (k * STRETCH..).take(stretch.len()));
    places.filter(|at| block[*at..].starts_with(SIGNATURE))
}

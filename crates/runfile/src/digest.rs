//! Digests of datasets and groups: BLAKE3 over kind, shape and little-endian bytes.

use std::collections::BTreeMap;

use blake3::Hasher;
use units::Units;

use crate::dataset::StoredElement;
use crate::layout::Kind;

/// Bytes hashed at a time, large enough for the hash to use all threads.
pub(super) const DIGEST_BLOCK_BYTES: usize = 1 << 20;

/// Adds bytes to a digest.
pub(super) fn add_bytes(hasher: &mut Hasher, bytes: &[u8]) {
    // A thread outside the pool would hand every block over, and wait for it.
    if bytes.len() == DIGEST_BLOCK_BYTES && rayon::current_thread_index().is_some() {
        hasher.update_rayon(bytes);
    } else {
        hasher.update(bytes);
    }
}

/// The digest of one dataset while it is fed.
///
/// The bytes hashed are: the tag of the kind, a zero byte, the rank and each extent as `u64`, then
/// the values. A text is its length in bytes as `u64` and its UTF-8. A matrix is the number of its
/// entries as `u64`, then `indptr` and `indices` as `i64` and `data` as `f64`. All numbers are
/// little endian.
#[derive(Debug)]
pub(super) struct DatasetDigest(Hasher);

impl DatasetDigest {
    pub(super) fn new(kind: Kind, shape: &[usize]) -> Self {
        let mut digest = DatasetDigest(Hasher::new());
        digest.0.update(kind.tag().as_bytes()).update(&[0]);
        digest.size(shape.len());
        shape.iter().for_each(|&extent| digest.size(extent));
        digest
    }

    pub(super) fn size(&mut self, size: usize) {
        self.0.update(&(size as u64).to_le_bytes());
    }

    pub(super) fn values<T: StoredElement>(&mut self, values: &[T]) {
        let mut bytes = vec![0; size_of_val(values).min(DIGEST_BLOCK_BYTES)];
        for block in values.chunks(DIGEST_BLOCK_BYTES / size_of::<T>()) {
            let bytes = &mut bytes[..size_of_val(block)];
            T::to_little_endian(block, bytes);
            add_bytes(&mut self.0, bytes);
        }
    }

    pub(super) fn text(&mut self, text: &str) {
        self.size(text.len());
        self.0.update(text.as_bytes());
    }

    pub(super) fn finish(self) -> String {
        self.0.finalize().to_hex().to_string()
    }
}

/// The digest of a plain array.
pub(super) fn of_values<T: StoredElement>(kind: Kind, shape: &[usize], values: &[T]) -> String {
    let mut digest = DatasetDigest::new(kind, shape);
    digest.values(values);
    digest.finish()
}

/// The digest of a text or a list of texts.
pub(super) fn of_texts<S: AsRef<str>>(shape: &[usize], texts: &[S]) -> String {
    let mut digest = DatasetDigest::new(Kind::Text, shape);
    texts.iter().for_each(|text| digest.text(text.as_ref()));
    digest.finish()
}

/// The digest of a group: path, zero byte, digest, zero byte of each dataset, in the order of the paths; then the units.
pub(super) fn of_group(digests: &BTreeMap<impl AsRef<str>, String>, units: Units) -> String {
    let mut hasher = Hasher::new();
    for (path, digest) in digests {
        for text in [path.as_ref(), digest] {
            hasher.update(text.as_bytes()).update(&[0]);
        }
    }
    hasher.update(units.to_string().as_bytes()).update(&[0]);
    hasher.finalize().to_hex().to_string()
}

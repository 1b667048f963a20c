//! Memory for updates, used again and again: fresh pages of memory cost more than the products that fill them.

use std::sync::Mutex;

use super::super::scalar::Scalar;
use super::locked;

/// Bytes above which a buffer is given back to the system instead: only the lower triangle of an update is ever touched, and a
/// buffer that serves another update is touched elsewhere.
const LARGEST_KEPT: usize = 32 << 20;

/// Bytes kept in all: without a limit, a quarter of the factor lies idle at n_div = 32, and nothing is faster.
const MOST_KEPT: usize = 64 << 20;

/// Buffers that no update uses now.
#[derive(Default)]
struct Free<T> {
    buffers: Vec<Vec<T>>,
    bytes: usize,
}

/// Where updates take their memory from.
pub(super) struct Buffers<T>(Mutex<Free<T>>);

impl<T: Scalar> Buffers<T> {
    pub(super) fn new() -> Self {
        Self(Mutex::default())
    }

    /// At least `length` numbers of any value; `None` where there is no memory for them.
    ///
    /// Lengths are powers of two, so that a buffer fits again soon; a page that is never touched takes no memory.
    pub(super) fn take(&self, length: usize) -> Option<Vec<T>> {
        if length == 0 {
            return Some(Vec::new());
        }
        if length * size_of::<T>() > LARGEST_KEPT {
            return zeros(length);
        }
        let length = length.next_power_of_two();
        let mut free = locked(&self.0);
        let fits = |buffer: &Vec<T>| buffer.len() == length;
        if let Some(place) = free.buffers.iter().rposition(fits) {
            free.bytes -= length * size_of::<T>();
            return Some(free.buffers.swap_remove(place));
        }
        drop(free);
        zeros(length)
    }

    /// Gives a buffer back.
    pub(super) fn put(&self, buffer: Vec<T>) {
        let bytes = size_of_val(&buffer[..]);
        let mut free = locked(&self.0);
        if bytes <= LARGEST_KEPT && free.bytes + bytes <= MOST_KEPT {
            free.bytes += bytes;
            free.buffers.push(buffer);
        }
    }
}

/// Zeros in pages that take memory when they are touched first; `None` where there is none.
pub(in super::super) fn zeros<T: Scalar>(length: usize) -> Option<Vec<T>> {
    let bytes = length.checked_mul(size_of::<T>())?;
    let mut probe: Vec<u8> = Vec::new();
    probe.try_reserve_exact(bytes).ok()?;
    drop(probe);
    Some(vec![T::default(); length])
}

//! Where a group is kept: in the run file, or in a file beside it that the run files of a folder share.
//!
//! A group in a file of its own is written once, under a name that holds its digest ([`linked`]),
//! and only linked again when the run file changes ([`kept`]). It is found by what it was computed from ([`shared`]). Readers go to
//! whichever file it is ([`whereabouts`]).

mod kept;
mod linked;
mod shared;
mod whereabouts;

pub(super) use kept::{carry_over, take_over};
pub(super) use linked::{Linked, LinkedName, is_joined, join, linked_names};
pub use shared::SharedGroup;

/// The file a group is kept in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Home {
    /// The run file itself.
    RunFile,
    /// A file beside the run file, named by its digest, that any run file of the folder may link.
    Shared,
}

#![doc = include_str!("../README.md")]
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod atomic_file;
mod attribute;
mod dataset;
mod digest;
mod dimension;
mod error;
mod extents;
mod external;
mod hdf5_file;
mod header;
mod layout;
mod lock;
mod matrix;
mod plain_file;
mod reader;
mod schema;
mod signals;
mod transaction;
mod user_block;
mod writer;

pub use atomic_file::{AtomicFile, WrittenFile, is_same, sync_folder};
pub use dataset::{StoredElement, StoredEnum};
pub use error::{LayoutError, LinkProblem, StoreError};
pub use external::SharedGroup;
pub use hdf5_file::FileState;
pub use header::{
    GROUP_ATTRIBUTES, GroupRecord, ROOT_ATTRIBUTES, StoredGroup, hdf5_version, require_plain_hdf5,
    timestamp,
};
pub use layout::{Axis, DatasetSpec, EnumSpec, Extent, Group, Kind, Layout, Presence, Storage};
pub use lock::{IfMissing, RunFile, Savepoint};
pub use matrix::{SparseMatrix, SparseView};
pub use plain_file::{follow_link, is_locked, is_still_at, lock_file, open_plain, open_stream};
pub use reader::Reader;
pub use schema::{schema_json, schema_page};
pub use signals::{Temporary, install as install_signal_handlers, last_commit, remove_left_overs};
pub use transaction::Transaction;
pub use user_block::is_of_type;
pub use writer::GroupWriter;

#![doc = include_str!("../README.md")]
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod attribute;
mod contents;
mod dataset;
mod digest;
mod dimension;
mod element;
mod error;
mod extents;
mod header;
mod heaps;
mod home;
mod inspect;
mod layout;
mod lock;
mod matrix;
mod reader;
mod schema;
mod seal;
mod signals;
mod transaction;
mod volume;
mod whole;
mod writer;

pub use element::{StoredElement, StoredEnum};
pub use error::{LayoutError, LinkProblem, StoreError};
pub use header::{
    GROUP_ATTRIBUTES, GroupRecord, ROOT_ATTRIBUTES, StoredGroup, hdf5_version, require_plain_hdf5,
    root_text, timestamp,
};
pub use home::{Home, SharedGroup};
pub use layout::{Axis, DatasetSpec, EnumSpec, Extent, Group, Kind, Layout, Presence, Storage};
pub use lock::{IfMissing, RunFile, Savepoint};
pub use matrix::{SparseMatrix, SparseView};
pub use reader::Reader;
pub use schema::{schema_json, schema_page};
pub use signals::{Temporary, install as install_signal_handlers, last_commit};
pub use transaction::Transaction;
pub use volume::FileState;
pub use whole::{WholeFile, WrittenFile, is_same, sync_folder};
pub use writer::{GroupWriter, Piecewise};

//! The guard before every output: no command writes over what it reads, nor over a file that is not
//! of its own kind.
//!
//! [`Inputs`] are known by device and file number, so links do not hide them. [`OutputKind`] knows what
//! this program writes by the contents. [`write()`] admits all files
//! of a command before it changes any of them, writes each beside its place and renames it. Run
//! files have their own type in the root and are judged by `store`; here they are only kept apart
//! from the inputs.

mod folder;
mod guard;
mod kind;
mod write;

pub use folder::Folder;
pub use guard::{Inputs, OutputError, admit};
pub(crate) use kind::FCLIB_TYPE;
pub use kind::OutputKind;
pub use write::{OutputFile, write};

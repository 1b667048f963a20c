#![doc = include_str!("../README.md")]
#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod accuracy;
pub mod bound;
pub mod branches;
mod shared;
pub mod stability;

pub use shared::StudyStep;

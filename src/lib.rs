//! The program `contact3d-pipe`: stages over one HDF5 file, sweeps, suites of hard cases, and the command line.
//!
//! It is a library for its own tests alone, and shows what these look at.

#![deny(clippy::print_stdout, clippy::print_stderr)]
#![allow(
    unreachable_pub,
    reason = "modules are private, so `pub` says: for the other modules"
)]

mod cli;
mod exchange;
mod format;
mod output;
mod pipeline;
mod report;
mod suite;
mod sweep;
mod views;

pub use cli::{Exit, main};
pub use format::{
    CHECKPOINT, HISTORY, LAYOUT, SERIES_LAYOUT, STABILITY_LAYOUT, SWEEP_LAYOUT, StabilityRow,
    Stage, read_accuracy, read_multiplier,
};
pub use pipeline::stage_settings;
pub use suite::{SuiteCase, read as read_suite};
pub use sweep::{Case, MOST_CASES, Plan, SweepFile};

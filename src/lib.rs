//! The pipeline `contact3d-pipe`: stages over one HDF5 file, sweeps, suites of hard cases, and the command line.

#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod cli;
pub mod exchange;
pub mod format;
pub mod output;
pub mod pipeline;
pub mod report;
pub mod suite;
pub mod sweep;
pub mod views;

//! Many scenes that differ in a few keys: planned, run in parallel with shared work, resumed,
//! summed up.
//!
//! Every case is a run file of its own, named by a digest of its scene, so changed axes add files
//! and never replace one. Cases whose assembled problems differ only in loads or friction share the
//! files of mesh and factor, and in one process the arrays themselves.

mod axes;
mod error;
mod folder;
mod operators;
mod plan;
mod run;
mod series;
mod summary;

pub use axes::{MOST_CASES, SweepFile, read_index};
pub use error::SweepError;
pub use plan::{Case, Plan, changed as changed_scene};
pub use run::{Event, Options, Outcome, run, run_case};
pub use series::write as write_series;
pub use summary::{CSV_FILE, SUMMARY_FILE, write as write_summary};

use crate::pipeline::StageError;

//! Many scenes that differ in a few keys: planned, run in parallel with shared work, resumed,
//! summed up.
//!
//! Every case is a run file of its own, named by a digest of its scene, so changed axes add files
//! and never replace one. Cases whose assembled problems differ only in loads or friction share the
//! files of mesh and factor, and in one process the arrays themselves.

mod axes;
mod case;
mod csv_table;
mod failure;
mod index_file;
mod lock;
mod operators;
mod ownership;
mod plan;
mod range;
mod run;
mod series;
mod size;
mod summary;

pub use axes::{SweepAxis, SweepFile};
pub use index_file::read as read_index;
pub use plan::{Case, Plan, changed as changed_scene};
pub use run::{Event, Options, Outcome, run, run_case};
pub use series::write as write_series;
pub use size::MOST_CASES;
pub use summary::{CSV_FILE, SUMMARY_FILE, write as write_summary};

use crate::pipeline::StageError;

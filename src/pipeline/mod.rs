//! The pipeline: stages from typed inputs to a typed output, and the session that keeps them in a
//! run file.
//!
//! One file per stage (`mesh`, `assemble`, `load`, `solve`, `post`); `stages` lists them side by
//! side. A [`Session`] has a task (what is asked), a store (what of the run file is fresh, and
//! commits) and what it knows (in memory).

mod accuracy;
mod adapt;
mod assemble;
mod branches;
mod change;
mod error;
mod freshness;
mod history;
mod homes;
mod known;
mod load;
mod mesh;
mod post;
mod resources;
mod series_folder;
mod session;
mod solve;
mod stages;
mod store;
mod theory;
mod undo;

pub use accuracy::{accuracy_input, measure_accuracy};
pub use adapt::{AdaptStep, Adapted};
pub use branches::{BranchesTask, Followed, branches_input, follow_branches};
pub use error::StageError;
pub use freshness::contradictions;
pub use freshness::{
    Freshness, StageState, operator_settings, require_undamaged, stage_settings, states,
};
pub use homes::{AssemblyFile, Operator};
pub use mesh::{mesh_file, mesh_of, pin_mesh_file};
pub(crate) use resources::admit_memory;
pub use resources::{memory_for_sweeps, scene_bytes};
pub use series_folder::{SeriesFolder, SeriesKind};
pub use session::{Commit, Performed, Results, Session, read_results};
pub use solve::{Solved, read_solved};
pub use stages::Step;
pub use theory::measure_theory;

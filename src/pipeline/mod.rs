//! The stages of the pipeline: each reads what earlier ones stored, computes, and stores its own group.

mod accuracy;
mod checkpoint;
mod error;
mod freshness;
mod mesh_file;
mod persistence;
mod resources;
mod results;
mod session;
mod shared;
mod undo;

pub use accuracy::{accuracy_input, measure_accuracy};
pub use error::StageError;
pub use freshness::{Freshness, StageState, operator_settings, stage_settings, states};
pub use mesh_file::{mesh_file, mesh_of, pin_mesh_file};
pub use persistence::AssemblyFile;
pub use resources::{memory_for_sweeps, scene_bytes};
pub use results::Results;
pub use session::{Commit, Performed, Session};
pub use shared::Operator;

//! The stages of the pipeline: each reads what earlier ones stored, computes, and stores its own group.

mod checkpoint;
mod contact_cells;
mod error;
mod freshness;
mod persistence;
mod picture;
mod session;
mod shared;

pub use error::StageError;
pub use freshness::{Freshness, PIPELINE, StageState, operator_settings, states};
pub use persistence::AssemblyFile;
pub use picture::figures_folder;
pub use session::{Commit, Performed, Session};
pub use shared::Operator;

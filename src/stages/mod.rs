//! The stages of the pipeline: each reads what earlier ones stored, computes, and stores its own group.

mod contact_cells;
mod error;
mod freshness;
mod persistence;
mod picture;
mod resources;
mod session;

pub use error::StageError;
pub use freshness::{Freshness, PIPELINE, StageState, states};
pub use persistence::AssemblyFile;
pub use picture::figures_folder;
pub use session::{Commit, Performed, Session};

//! The pipeline: the library's driver, with a run file as the storage of what it computes.
//!
//! `stages` lists the stages side by side and `settings` what each depends on. A [`Session`] has a store (the run file and what
//! of it is fresh for a scene; commits) and a cache (what is in memory).

mod adapt;
mod assembly_file;
mod commit;
mod error;
mod freshness;
mod mesh;
mod resources;
mod results;
mod series_folder;
mod session;
mod settings;
mod stages;
mod store;
pub mod studies;

pub use adapt::AdaptStep;
pub use assembly_file::AssemblyFile;
pub use error::StageError;
pub use freshness::{Freshness, OpenRun, StageState, contradictions};
pub use mesh::{mesh_files, mesh_of, pin_mesh_file};
pub(crate) use resources::admit_memory;
pub use resources::{memory_for_sweeps, scene_bytes};
pub use results::{Results, read_results, read_solved};
pub use series_folder::{CASE_SERIES, PATH_SERIES, SeriesFolder};
pub use session::{Session, StageTiming, StoreWhen};
pub use settings::{operator_settings, stage_settings};
pub(crate) use store::{Checkpoints, FIRST_COMMIT_SECONDS};

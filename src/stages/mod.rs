//! The stages of the pipeline: each reads what earlier ones stored, computes, and stores its own group.

mod accuracy;
mod charts;
mod checkpoint;
mod contact_cells;
mod error;
mod freshness;
mod law;
mod law_curves;
mod law_face;
mod mesh_file;
mod persistence;
mod picture;
mod picture_folder;
mod report;
mod report_tables;
mod resources;
mod results;
mod session;
mod shared;
mod sweep_charts;
mod sweep_report;
mod sweep_table;
mod undo;

pub use accuracy::{draw_accuracy, measure_accuracy};
pub use error::StageError;
pub use freshness::{Freshness, StageState, operator_settings, stage_settings, states};
pub use law::{LawKind, LawStudy, MeshSizes, law_folder};
pub use mesh_file::mesh_file;
pub use persistence::AssemblyFile;
pub use picture::{are_drawn, figures_folder};
pub use picture_folder::{Drawing, PictureFolder};
pub use report::report;
pub use resources::problem_bytes;
pub use session::{Commit, Performed, Session};
pub use shared::Operator;
pub use sweep_report::{draw_sweep, sweep_table};

//! What turns results into pictures, tables and pages. Nothing here computes a result or changes a
//! run file.

mod accuracy_tables;
mod branches;
mod charts;
mod contact_cells;
mod history_charts;
mod law;
mod law_curves;
mod law_face;
mod local_mapping;
mod motion;
mod picture;
mod picture_folder;
mod report;
mod report_tables;
mod sweep_charts;
mod sweep_report;
mod sweep_table;
mod theory_charts;
mod theory_report;

/// What stands in place of the estimated error where there is none.
pub(crate) const ESTIMATE_OF_REST: &str = "none: nothing is deformed by more than rounding";

pub use branches::{draw_branches, kind_words};
pub use charts::draw_accuracy;
pub use law::{FaceStudy, LawStudy, MeshSizes, law_folder};
pub use local_mapping::{fold_words, radius_words, sign_words};
pub(crate) use motion::{motion_words, neutral_motions, neutral_words};
pub use picture::{are_drawn, draw_run, drawing_of, figures_folder};
pub use picture_folder::{Drawing, PictureFolder};
pub use report::report;
pub use sweep_report::{draw_sweep, sweep_table};
pub use theory_charts::draw_theory;

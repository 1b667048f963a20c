//! What turns results into pictures, tables and pages. Nothing here computes a result or changes a
//! run file.

mod body3d;
mod charts;
mod contact_cells;
mod history_charts;
mod law;
mod picture;
mod picture_folder;
mod report;
mod surroundings;
mod sweep;
mod sweep_table;

pub use charts::{draw_accuracy, draw_branches};
pub use law::{draw_laws, drawing_of_laws};
pub use picture::{are_drawn, draw_mesh, draw_run, drawing_of, figures_folder};
pub use picture_folder::{Drawing, PictureFolder, folder_here};
pub use report::report;
pub use sweep::{draw_sweep, read_sweep, sweep_table};

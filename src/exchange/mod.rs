//! Files from and to other programs: frictional contact problems in those of FCLIB, grids for ParaView.
//!
//! `export` makes a problem of a solved run file, `grid` copies what viewers open, `solve` solves the problem of a file, `file` puts files together before the output
//! guard lets them into their places.

mod export;
mod file;
mod grid;
mod solve;

pub use export::{FclibForm, export};
pub use grid::export_grid;
pub use solve::{FclibAnswer, SolutionFile, solve_file};

//! Frictional contact problems from and to the files of FCLIB.
//!
//! `export` makes a file of a solved run file, `solve` solves the problem of a file, `file` puts files together before the output
//! guard lets them into their places.

mod export;
mod file;
mod solve;

pub use export::{Exported, Form, export};
pub use solve::{FclibAnswer, Target, solve_file};

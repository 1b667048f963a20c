//! What is said of results: lists of figures, and the sinks that show them.
//!
//! A figure is one entry: its key, its words, its dimension and its value. The same list becomes the text of a
//! terminal, the JSON of `--json` and the tables of a page.

mod answer;
mod cautions;
mod features;
mod figure;
mod levels;
pub mod mesh;
mod run;
mod screen;
pub mod stability;
mod status;
pub mod studies;
mod sweep;

pub use features::features;
pub use figure::{Digits, FigureTable, Figures};
pub use levels::{adaptation_json, adaptation_table, increment_in_words, shown_time};
pub use run::{SolvedRun, estimated_percent, percent};
pub use screen::next_command;
pub use status::{failure, outcome, performed, stages, status};
pub use sweep::{Cell, Column, SweepTable};

use units::Units;

/// The units of results, for programs.
pub fn unit_words(units: Units) -> serde_json::Value {
    serde_json::json!({
        "length": units.length(),
        "force": units.force(),
        "stress": units.stress(),
        "energy": units.energy(),
    })
}

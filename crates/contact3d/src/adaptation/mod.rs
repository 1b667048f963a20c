//! Meshes that follow the estimated error: solve, estimate, mark, cut.
//!
//! [`next_cuts`] chooses from the indicators of an answer what to cut, [`RefinableBody`](crate::mesh::RefinableBody)
//! cuts it, and [`crate::contact::transferred`] is the multipliers that the next solve starts from. A level asks for a fraction of the
//! error of the one before, so that the last one costs most.

mod levels;
mod marking;
mod refine;

pub use levels::{Adaptation, AdaptiveLevel, AdaptiveStatus, LevelForecast};
pub use marking::{Target, next_cuts};
pub use refine::{LevelStorage, RefinedLevels, SolvedLevel, adapted, refine};

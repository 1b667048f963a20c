//! Studies of contact problems, over the library [`contact3d`]: what an answer is worth beyond its own residuals.
//!
//! | study | question | entry |
//! |---|---|---|
//! | [`accuracy`] | What do solvers and meshes cost for which error? | [`Accuracy::measure`](accuracy::Accuracy::measure) |
//! | [`stability`] | Do other algorithms and other descriptions of the problem give the same answer? | [`Check::new`](stability::Check::new) |
//! | [`branches`] | Which solutions are there as a key of the scene changes? | [`Branches::follow`](branches::Branches::follow) |
//!
//! Each takes a [`Scene`](contact3d::scene::Scene) and the folder of its mesh files, assembles what it needs in memory,
//! and returns plain data. Nothing is stored or printed, and the library knows nothing of the studies.

#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod accuracy;
pub mod branches;
mod progress;
mod shared;
pub mod stability;

pub use progress::StudyStep;

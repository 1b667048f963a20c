//! The error of a solution: its distance to the solution that refined residuals lead to.

mod error;
mod refinement;

pub(crate) use error::{is_significant, load_stress};
pub(in crate::solver) use refinement::Refined;

//! The error of an answer: its way to the solution.

mod judge;
pub(in crate::solver) mod polish;

pub(in crate::solver) use judge::{LEFT, MOST_APPLICATIONS, REFINED};
pub(crate) use judge::{is_felt, load_stress};

//! The error of an answer: its way to the solution.

mod deviation;
mod judge;
pub(in crate::solver) mod polish;

//! What holds a body: clamps at prescribed displacements.

mod closed_forms;
mod driven;
mod operators;
mod refusals;

#[path = "../support/mod.rs"]
mod support;

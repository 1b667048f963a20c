//! What holds a body: clamps at prescribed displacements, springs.

mod closed_forms;
mod driven;
mod operators;
mod refusals;
mod springs;
mod studies;

#[path = "../support/mod.rs"]
mod support;

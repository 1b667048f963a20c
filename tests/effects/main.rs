//! Only the model features that a scene calls for are computed, and those that coincide in a limit
//! agree.

#[path = "../support/mod.rs"]
mod support;

mod absence;
mod bodies;
mod capped;
mod contact_frame;
mod datasets;
mod floating;
mod friction;
mod scenes;
mod words;

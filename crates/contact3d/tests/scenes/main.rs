//! The library by whole scenes, in one binary, so that it is linked once and all run side by side.

mod adaptive;
mod adaptive_history;
mod closed_forms;
mod examples;
mod facade;
mod faces;
mod floating;
mod gate;
mod graded;
mod hidden_contact;
mod keeper;
mod load_history;
mod local_mapping;
mod matrix_free;
mod obstacles;
mod quadratic;
mod quantities;
mod single_precision;
mod strategies;
mod symmetry;

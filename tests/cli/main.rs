//! The program as a user meets it: commands, messages, exit codes, files.

mod accuracy;
mod bad_bodies;
mod bad_scenes;
mod errors;
mod interruption;
mod law;
mod linked_assembly;
mod program;
mod stages;
mod units;

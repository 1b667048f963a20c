//! The program as a user meets it: commands, messages, exit codes, files.

mod accuracy;
mod errors;
mod interruption;
mod law;
mod linked_assembly;
mod program;
mod stages;

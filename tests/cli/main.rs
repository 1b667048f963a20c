//! The program as a user meets it: commands, messages, exit codes, files.

mod accuracy;
mod adaptive;
mod advice;
mod arguments;
mod bad_bodies;
mod bad_scenes;
mod branches;
mod errors;
mod faces;
mod interruption;
mod law;
mod linked_assembly;
mod manners;
mod outputs;
mod paraview;
mod pipes;
mod program;
mod range;
mod refusals;
mod special_files;
mod stages;
mod theory;
mod titles;
mod units;
mod warnings;
mod words;

//! Files of FCLIB, the Friction Contact Library: frictional contact problems, their solutions and guesses, in HDF5.
//!
//! V. Acary, M. Brémond, T. Koziara, F. Pérignon, *FCLIB: a collection of discrete 3D frictional contact problems*, INRIA
//! RT-0444 (2014). This crate knows the layout of such files and nothing of mechanics.
//!
//! * `/fclib_local`: find u and r with u = W r + q and Coulomb's law between u and r at every contact, components N, T1, T2
//!   contact after contact ([`LocalProblem`]);
//! * `/fclib_global`: the same with M v = H r + f and u = Hᵀ v + w ([`GlobalProblem`]);
//! * `/solution` and `/guesses/1`, `/guesses/2`, …: v, u, r and l ([`FclibSolution`]).
//!
//! Whole numbers are 32-bit. A matrix has `nz` = −1 by compressed columns, −2 by compressed rows, and otherwise `nz` triplets,
//! of which `p` holds columns and `i` rows, as the library's own code has it (the comment in its header says the opposite).
//! Its reader of global problems takes triplets only, so [`write_global`] writes those.

#![deny(clippy::print_stdout, clippy::print_stderr)]

mod error;
mod problem;
mod read;
mod write;

pub use error::FclibError;
pub use problem::{FclibSolution, GlobalProblem, Info, LocalProblem, Matrix};
pub use read::{declared_bytes, program_of, read_global, read_guesses, read_local, read_solution};
pub use write::{
    Array, remove_solution, write_arrays, write_global, write_guesses, write_local, write_program,
    write_solution,
};

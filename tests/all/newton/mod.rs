//! The semismooth Newton method on the explicit dual operator.
//!
//! Goal: the fixed point of HKL's mapping Ψ to rounding, for the published laws and for hard ones,
//! in a number of steps that does not depend on units.

mod dense;
mod inner;
mod laws;
mod mobile;
mod operators;
mod steps;
use crate::support;

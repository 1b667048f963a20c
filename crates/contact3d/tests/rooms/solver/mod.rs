//! Inner solvers, operators.

mod inner;
mod operator;

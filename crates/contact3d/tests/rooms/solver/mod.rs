//! Ellipses of friction, inner solvers, operators.

mod ellipse;
mod inner;
mod operator;

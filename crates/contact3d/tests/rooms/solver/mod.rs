//! Ellipses of friction, inner solvers, and problems given by a Delassus matrix.

mod delassus;
mod ellipse;
mod inner;
mod operator;

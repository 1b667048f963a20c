//! A method for convex problems, frictionless contact and Tresca's law, that always ends.
//!
//! The interior point method needs no start and does not see the conditioning of S; it comes as close to the solution as is
//! asked. Newton's method on the natural map ends in one or a few steps from close by: near the solution of a frictionless
//! problem a step lands on it, since the map is piecewise linear there and every piece is regular, S being positive definite,
//! and with ellipses it converges at a higher than linear rate (M. Hintermüller, K. Ito, K. Kunisch, *SIAM J. Optim.* 13
//! (2003) 865). So the two by turns, closer each time, end for any S; what is left is rounding, ε_M cond S.

mod cone;
mod interior;
mod program;
#[cfg(test)]
mod tests;

pub(in crate::solver) use interior::InteriorPoint;
pub(in crate::solver) use program::{ConvexProgram, Motions};

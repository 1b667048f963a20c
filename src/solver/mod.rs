//! The nonlinear solvers: Algorithm 4.1 (successive approximations) with KPRGP inside.

mod ellipse;
mod feasible_set;
mod fixed_point;
mod kprgp;
mod norm;
mod vector;

pub use ellipse::Ellipse;
pub use feasible_set::FeasibleSet;
pub use fixed_point::{ContactState, OuterStep, Solution, Status, successive_approximations};
pub use kprgp::{InnerOutcome, Kprgp, StepCounts};
pub use norm::operator_norm;

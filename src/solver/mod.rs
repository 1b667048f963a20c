//! The nonlinear solvers: Algorithm 4.1 (successive approximations) with KPRGP or Newton's method
//! inside, and a semismooth Newton method for the whole problem.

mod ellipse;
mod ellipse_derivative;
mod feasible_set;
mod fixed_point;
mod kprgp;
mod mapping;
mod natural_map;
mod newton;
mod newton_loop;
mod newton_system;
#[cfg(test)]
mod newton_tests;
mod norm;
mod relaxation;
mod solution;
mod solve;
mod vector;

pub use ellipse::Ellipse;
pub use ellipse_derivative::ProjectionDerivative;
pub use feasible_set::FeasibleSet;
pub use fixed_point::{Inner, successive_approximations};
pub use kprgp::{InnerOutcome, Kprgp, StepCounts};
pub use mapping::{MappingValue, evaluate as evaluate_mapping};
pub use newton::{FrozenSolution, NewtonSolution, minimise_frozen, newton};
pub use newton_loop::{NewtonSettings, NewtonStatus, NewtonStep};
pub use norm::operator_norm;
pub use solution::{ContactState, OuterStep, Solution, SolvedBy, Status};
pub use solve::{NeedsExplicit, Progress, solve};

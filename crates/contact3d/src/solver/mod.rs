//! The nonlinear solvers: Algorithm 4.1 (successive approximations) with KPRGP, GPCG or Newton's
//! method inside, and a semismooth Newton method for the whole problem.

mod answer;
mod conditions;
mod continuation;
mod cycle;
#[cfg(test)]
mod dense_operator;
mod deviation;
mod ellipse;
mod ellipse_boundary;
mod ellipse_derivative;
mod face;
mod feasible_set;
mod fixed_point;
mod gpcg;
#[cfg(test)]
mod gpcg_tests;
mod inner;
mod judge;
mod kprgp;
mod linearisation;
mod mapping;
mod minimisation;
mod natural_map;
mod newton;
mod newton_loop;
mod newton_system;
#[cfg(test)]
mod newton_tests;
mod norm;
mod polish;
mod relaxation;
mod search;
mod solution;
mod solve;
mod start;

pub use ellipse::Ellipse;
pub use ellipse_derivative::ProjectionDerivative;
pub use feasible_set::FeasibleSet;
pub use fixed_point::successive_approximations;
pub use gpcg::Gpcg;
pub use inner::Inner;
use inner::InnerSummary;
pub use kprgp::{InnerOutcome, Kprgp, StepCounts};
pub use linearisation::Linearisation;
pub use mapping::{MappingValue, coulomb_state, evaluate as evaluate_mapping};
pub use newton::{NewtonSolution, minimise_frozen, newton};
pub use newton_loop::{NewtonSettings, NewtonStatus, NewtonStep};
pub use norm::operator_norm;
pub use solution::{ContactState, CoulombState, Goal, OuterStep, Solution, SolvedBy, Status};
pub use solve::{NeedsExplicit, Progress, solve};
pub use start::{OuterState, Start};

//! The nonlinear solvers: Algorithm 4.1 (successive approximations) with KPRGP, GPCG or Newton's
//! method inside, and a semismooth Newton method for the whole problem.
//!
//! Each module uses only those before it: `ellipse`, `feasible_set`, `history`, `contact_state`,
//! `solution`, `problem`, `conditions`, `convex`, `newton`, `inner`, `minimisation`, `fixed_point`, `accuracy`, `answer`, `equilibrium`, `solve`;
//! `delassus` is for problems given by matrices alone.

mod accuracy;
mod answer;
mod conditions;
mod contact_state;
mod convex;
mod delassus;
mod ellipse;
mod equilibrium;
mod feasible_set;
mod fixed_point;
mod history;
mod inner;
mod minimisation;
mod newton;
mod problem;
mod solution;
mod solve;
mod unanswered;

pub(crate) use conditions::{Bound, PaneZone};
pub use contact_state::{ContactState, CoulombState, coulomb_state};
pub use delassus::{
    DelassusError, DelassusMethod, DelassusProblem, DelassusSettings, DelassusSolution,
    DelassusSolver, DelassusStatus, FrozenGlobal, FrozenScaling, MOST_DENSE_CONTACTS,
    frozen_global, frozen_local, solve_delassus,
};
pub use ellipse::{Ellipse, ProjectionDerivative};
pub use feasible_set::FeasibleSet;
pub use fixed_point::{
    MappingValue, evaluate_mapping, evaluate_mapping_at, successive_approximations,
};
pub use history::{NewtonStep, OuterStep, StepCounts};
pub use inner::{Gpcg, Inner, InnerOutcome, Kprgp, operator_norm};
pub use newton::{
    Linearisation, LocalMapping, NewtonSettings, NewtonSolution, NewtonStatus, frozen_response,
    minimise_frozen, newton,
};
pub(crate) use newton::{contraction_of_mapping, natural_map::NaturalMap};
pub use problem::{NeedsExplicit, OuterState, Progress, Start};
pub use solution::{Goal, Solution, SolvedBy, Status};
pub use solve::solve;

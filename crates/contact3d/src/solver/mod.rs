//! The nonlinear solvers: Algorithm 4.1 (successive approximations) with KPRGP, GPCG or Newton's
//! method inside, and a semismooth Newton method for the whole problem.
//!
//! `solve` tells a solve in order and names the module of each step; `strategy` lists the starts of Newton's method. Below them, each
//! using only those before it: `ellipse`, `feasible_set`, `pane_laws`, `solution`, `problem`, `conditions` (the natural map), `newton`,
//! `convex`, `inner`, `minimisation`, `fixed_point`, `accuracy`, `assessment`, `equilibrium`.

/// An enumeration whose values programs see as words.
macro_rules! worded {
    ($(#[$about:meta])* enum $name:ident { $($(#[$doc:meta])* $value:ident = $word:literal,)* }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $name {
            $($(#[$doc])* $value,)*
        }

        impl $name {
            /// All of them, in order.
            pub const ALL: &'static [Self] = &[$(Self::$value,)*];

            /// The value as programs see it.
            #[must_use]
            pub fn word(self) -> &'static str {
                match self {
                    $(Self::$value => $word,)*
                }
            }
        }
    };
}

mod accuracy;
mod adjoint;
mod assessment;
mod by_products;
mod conditions;
mod convex;
mod ellipse;
mod equilibrium;
mod feasible_set;
mod fixed_point;
mod gradient_methods;
mod inner;
mod minimisation;
mod newton;
mod pane_laws;
mod problem;
mod solution;
mod solve;
mod strategy;
mod two_levels;

/// Most steps of loops that end by a rule of their own: no problem of the campaigns took more than 60.
const LOOP_MAX_STEPS: usize = 100;

/// Roundings that sums of a few terms and the steps behind them may add up to, in units of ε.
const FEW_ROUNDINGS: f64 = 16.0;

pub(crate) use accuracy::{is_significant, load_stress};
pub(crate) use adjoint::{Adjoint, Adjoints, LinearFunctional};
pub(crate) use assessment::Assessment;
pub use conditions::{Bound, Evaluation, PaneEvaluation, PaneZone};
pub use ellipse::{Ellipse, ProjectionDerivative};
pub use feasible_set::FeasibleSet;
pub use fixed_point::{MappingValue, SuccessiveApproximations, evaluate_mapping};
pub use inner::{Gpcg, Inner, InnerOutcome, Kprgp, projected_gradient_steplength};
pub use newton::{
    Linearisation, LocalMapping, NewtonSettings, NewtonSolution, minimise_frozen, newton,
};
pub use newton::{contraction_of_mapping, natural_map::NaturalMap};
pub use pane_laws::{CoulombState, PaneLaws, coulomb_state};
pub use problem::{ContactBody, ContactProblem, ContactState};
pub use problem::{NeedsExplicit, OuterState, Progress, Start};
pub use solution::{FrictionState, MethodResult, RigidMotions, StopReason, Trace};
pub use solution::{NewtonStep, OuterStep, StepCounts};
pub use solution::{Solution, SolvedBy, Status};
pub(crate) use solve::without_contact;
pub use strategy::StartStrategy;

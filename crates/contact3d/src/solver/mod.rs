//! The nonlinear solvers: Algorithm 4.1 (successive approximations) with KPRGP, GPCG or Newton's
//! method inside, and a semismooth Newton method for the whole problem.
//!
//! `solve.rs` tells a solve in order and names the module of each step. It stands on these, each using only those before it but for `gradient_methods`, which repeats its methods:
//! `tolerances` (shared limits), `feasible_set`, `pane_laws`, `strategy` (the list of start strategies), `solution`,
//! `conditions` (the natural map of panes), `problem`, `convex` (the interior point method), `newton`, `inner`, `minimisation`, `fixed_point`
//! (Algorithm 4.1), `accuracy`, `assessment` (the status), `equilibrium`, `two_levels`, `newton_krylov`, `gradient_methods`. Beside it
//! stands `adjoint`, the derivative of a solution.
//!
//! | letter | what it is |
//! |---|---|
//! | λ = (λ_ν, λ_t), α | contact stresses on the panes in Pa, rigid-body motions in m: the unknowns |
//! | S, h, G, D, e | the discrete equations ([`ContactProblem`]) |
//! | r = S λ − G α − h | the gap of a pane times its area, in m³; the gradient of the energy by λ, and called so |
//! | ρ, z = λ − ρ r | steplength of a component in Pa/m³, the trial stress that it leads to: ρ is the local stiffness of the pane, 1/S_ii where sweeps relax, where S is implicit and in the linearisation of Ψ |
//! | ε, ε_M | accuracy asked for, rounding 2⁻⁵² of double precision; of letters alone, ε is the first |
//! | A_κ, S⁻¹ | A with pins at its rigid motions ([`crate::elasticity::RigidModes`]), with σ where contact springs are; stresses by displacements of the face |
//! | σ, μ = λ + σ r | contact springs in Pa/m³ for bodies so slender that S loses the digits of gaps, and the unknown with them (`adjoint`) |
//! | \|Rⁱ\| | area of a pane in m² |
//! | R | the natural map, λ minus the projection of z, in Pa |
//! | g, 𝓕 | slip bound of a pane in Pa, its coefficients of friction |
//! | Ψ | the mapping of Algorithm 4.1, whose fixed points are the solutions with Coulomb's law |
//! | ᾱ, g̃ | steplength of projected gradients in Pa/m³, the reduced gradient in m³ |
//!
//! Other letters are those of the file at whose head they are.
//!
//! *HKL* is J. Haslinger, R. Kučera, T. Ligurský, *J. Comput. Appl. Math.* 235 (2011) 3464. A *pane* is a group of triangles of the
//! contact face on which λ is constant.

mod accuracy;
mod adjoint;
mod assessment;
mod conditions;
mod convex;
mod equilibrium;
mod feasible_set;
mod fixed_point;
mod gradient_methods;
mod inner;
mod minimisation;
mod newton;
mod newton_krylov;
mod pane_laws;
mod problem;
mod solution;
mod solve;
mod strategy;
mod tolerances;
mod two_levels;

pub(crate) use accuracy::{is_significant, load_stress};
pub(crate) use adjoint::{Adjoint, LinearFunctional};
pub(crate) use assessment::Assessment;
pub use conditions::{Bound, Evaluation, PaneEvaluation, Zone};
pub use feasible_set::FeasibleSet;
pub use fixed_point::{MappingValue, SuccessiveApproximations, evaluate_mapping};
pub use inner::{Gpcg, Inner, InnerOutcome, Kprgp, projected_gradient_steplength};
pub use newton::{Linearisation, NewtonSettings, NewtonSolution, minimise_frozen, newton};
pub use newton::{contraction_of_mapping, natural_map::NaturalMap};
pub use pane_laws::{CoulombState, PaneLaws, coulomb_state};
pub use problem::{ContactBody, ContactProblem, ContactSide};
pub use problem::{NeedsExplicit, OuterState, Progress, Start};
pub use solution::{FrictionState, LocalMapping, MethodResult, RigidMotions, StopReason, Trace};
pub use solution::{NewtonStep, OuterStep, StepCounts};
pub use solution::{Solution, SolvedBy, Status};
pub(crate) use solve::without_contact;
pub use strategy::StartStrategy;

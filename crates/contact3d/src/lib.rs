#![doc = include_str!("../README.md")]
//!
//! # The problem
//!
//! A body Ω is held on Γ_u, loaded on Γ_p, and may touch a rigid foundation on Γ_c. With stress σ = C ε(u), normal ν and
//! principal axes of friction t₁, t₂ on Γ_c, where a flat Γ_c has its outward normal, and one that faces an
//! [`Obstacle`](scene::Obstacle) the normal of the obstacle at the nearest point:
//!
//! * equilibrium −div σ = f in Ω, u = 0 on Γ_u, σν = p on Γ_p;
//! * non-penetration u_ν ≤ d, σ_ν ≤ 0, (u_ν − d) σ_ν = 0 with the initial gap d ≥ 0;
//! * friction with F = diag(F₁(|u_t1|), F₂(|u_t2|)): where u_t = 0, ‖F⁻¹σ_t‖ ≤ −σ_ν; elsewhere
//!   F⁻¹σ_t = σ_ν F u_t / ‖F u_t‖.
//!
//! Discretised by linear or quadratic tetrahedra and multipliers that are constant on panes Rⁱ of Γ_c, for frozen
//! slip bound g and friction the multipliers minimise ½ λᵀSλ − λᵀh over λ_ν ≥ 0,
//! ‖𝓕_i⁻¹λ_t,i‖ ≤ g_i, with S = B A⁻¹ Bᵀ and h = B A⁻¹ l. Successive approximations update
//! g = λ_ν and 𝓕 = 𝓕(u) until the multipliers stop changing.
//!
//! Source: J. Haslinger, R. Kučera, T. Ligurský, J. Comput. Appl. Math. 235 (2011) 3464–3480,
//! doi 10.1016/j.cam.2011.02.007, called HKL in this documentation.
//!
//! # Algorithms
//!
//! | step | algorithm | source | module |
//! |---|---|---|---|
//! | mesh | cells of five tetrahedra; panes of 2 × 2 cells, macro-patches of any flat surface, or single nodes | HKL §3, Remark 3.1 | [`mesh`] |
//! | stiffness | linear tetrahedra (P1) or quadratic ones (P2, straight or curved), gathered row by row | HKL §3 | [`elasticity`] |
//! | factor | nested dissection, supernodal Cholesky | A. George, *SIAM J. Numer. Anal.* 10 (1973) 345 | [`linalg`] |
//! | S, h | S = WᵀW with W = L⁻¹PBᵀ, or two solves for each application | HKL (4.5) | [`dual`] |
//! | outer loop | successive approximations | HKL Algorithm 4.1, Remark 4.1 | [`solver::SuccessiveApproximations`] |
//! | inner problem | KPRGP: conjugate gradients, expansions, proportioning | HKL §4; R. Kučera, *SIAM J. Optim.* 19 (2008) 846 | [`solver::Kprgp`] |
//! | all at once | semismooth Newton on λ − P(λ − ρr) | L. Qi, J. Sun, *Math. Program.* 58 (1993) 353 | [`solver::newton`] |
//! | error of the mesh | recovered stresses (P1), local Neumann problems (P2), conditions inside panes | O. C. Zienkiewicz, J. Z. Zhu, *Int. J. Numer. Methods Eng.* 33 (1992) 1331; R. E. Bank, A. Weiser, *Math. Comp.* 44 (1985) 283 | [`post::ErrorEstimate`] |
//! | finer mesh | bisection of longest edges | M.-C. Rivara, *Int. J. Numer. Methods Eng.* 20 (1984) 745 | [`adaptation`] |
//! | error of λ | refinement with residuals in twice the precision | N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, 2002 | [`solver`] |
//!
//! Newton's method on a dense S is the default where memory allows; [`scene::Method`] chooses.
//!
//! # Symbols
//!
//! | symbol | name | unit |
//! |---|---|---|
//! | u | [`displacement`](solver::Solution::displacement) | m |
//! | A | [`stiffness`](dual::PrimalSystem::stiffness) | N/m |
//! | l | [`load`](dual::PrimalSystem::load) | N |
//! | B = \[N; T\] | [`coupling`](contact::Coupling) | m² |
//! | S | [`DualOperator`](dual::DualOperator) | m³/Pa |
//! | h | [`dual_rhs`](dual::ContactSystem::dual_rhs) | m³ |
//! | λ = (λ_ν, λ_t) | [`multiplier`](solver::Solution::multiplier), the stresses −σ_ν, −σ_t | Pa |
//! | g | [`slip_bound`](solver::CoulombState::slip_bound) | Pa |
//! | φ = (∣u_t1∣, ∣u_t2∣) | [`slip`](solver::FrictionState::slip) | m |
//! | F₁, F₂ | [`Friction`](scene::Friction) | 1 |
//! | 𝓕_i⁻¹ | [`pane_inverse`](contact::FrictionField::pane_inverse) | 1 |
//! | Rⁱ, ∣Rⁱ∣ | pane, [`pane_area`](mesh::ContactSurface::pane_area) | m² |
//! | d | [`gap`](scene::Contact::gap) | m |
//! | ε, r_tol, c_fact, Γ | [`SolveSettings`](scene::SolveSettings) | 1 |
//! | ᾱ | [`steplength`](solver::Trace::steplength) | Pa/m³ |
//! | n_A | [`applications`](solver::Trace::applications) | 1 |

#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod adaptation;
pub mod contact;
pub mod dual;
pub mod elasticity;
pub mod history;
pub mod linalg;
pub mod mesh;
pub mod post;
mod problem;
pub mod reference;
pub mod scene;
pub mod solver;

pub use problem::{
    AssembledProblem, Checkpoint, InMemory, Problem, ProblemError, RunStep, RunStorage,
    SolvedProblem,
};

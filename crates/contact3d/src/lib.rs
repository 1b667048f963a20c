//! Elastostatic contact of a 3D body with a rigid flat foundation and orthotropic Coulomb friction
//! whose coefficients depend on the solution.
//!
//! # The problem on one page
//!
//! A body Ω is held on Γ_u, loaded on Γ_p, and may touch the foundation on the flat part Γ_c. With
//! stress σ = C ε(u), outward normal ν and principal axes of friction t₁, t₂ on Γ_c:
//!
//! * equilibrium −div σ = f in Ω, u = 0 on Γ_u, σν = p on Γ_p;
//! * non-penetration u_ν ≤ d, σ_ν ≤ 0, (u_ν − d) σ_ν = 0 with the initial gap d ≥ 0;
//! * friction with F = diag(F₁(|u_t1|), F₂(|u_t2|)): where u_t = 0, ‖F⁻¹σ_t‖ ≤ −σ_ν; elsewhere
//!   F⁻¹σ_t = σ_ν F u_t / ‖F u_t‖.
//!
//! Discretised by P1 tetrahedra and multipliers that are constant on panes Rⁱ of Γ_c, for frozen
//! slip bound g and friction the multipliers minimise ½ λᵀSλ − λᵀh over λ_ν ≥ 0,
//! ‖𝓕_i⁻¹λ_t,i‖ ≤ g_i, with S = B A⁻¹ Bᵀ and h = B A⁻¹ l. Successive approximations update
//! g = λ_ν and 𝓕 = 𝓕(u) until the multipliers stop changing.
//!
//! Source: J. Haslinger, R. Kučera, T. Ligurský, J. Comput. Appl. Math. 235 (2011) 3464–3480,
//! doi 10.1016/j.cam.2011.02.007, called HKL in this documentation.
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
//! | φ = (∣u_t1∣, ∣u_t2∣) | [`slip`](solver::Solution::slip) | m |
//! | F₁, F₂ | [`Friction`](scene::Friction) | 1 |
//! | 𝓕_i⁻¹ | [`pane_inverse`](contact::FrictionField::pane_inverse) | 1 |
//! | Rⁱ, ∣Rⁱ∣ | pane, [`pane_area`](mesh::ContactSurface::pane_area) | m² |
//! | d | [`gap`](scene::Contact::gap) | m |
//! | ε, r_tol, c_fact, Γ | [`SolveSettings`](scene::SolveSettings) | 1 |
//! | ᾱ | [`steplength`](solver::Solution::steplength) | Pa/m³ |
//! | n_A | [`applications`](solver::Solution::applications) | 1 |

#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod contact;
pub mod convergence;
pub mod dual;
pub mod elasticity;
pub mod linalg;
pub mod mesh;
pub mod post;
pub mod robustness;
pub mod scene;
pub mod solver;

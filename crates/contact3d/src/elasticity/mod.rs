//! Linear elasticity on linear and quadratic tetrahedra: the stiffness A, the load l and the degrees of freedom that clamps leave.
//!
//! A tetrahedron T couples its nodes a and b by the 3 × 3 block (A_ab)_ik = ∫_T C_ijkl ∂_j N_a ∂_l N_b in N/m, exactly where its
//! sides are straight, by quadrature where they are curved. The rows of a node are gathered by one thread, tetrahedra in
//! ascending order, so the sum has the same bits at any number of threads. Tractions, pressures and body forces become
//! consistent nodal forces, exactly for constants and by Gauss–Legendre products for formulas.
//!
//! Held components at a displacement u_c of their own take A_fc u_c from the load of the free ones; A stays as it is.
//!
//! Nodes of glued faces follow others, u = T u_free ([`DofMap`]): A is then TᵀAT and l is Tᵀl.
//!
//! Springs on faces add ∫ φ_a φ_b K to the blocks of their nodes.
//!
//! A body that its clamps and springs leave free to move as a rigid one has no A⁻¹. Where contact may hold it, A gets a
//! generalised inverse ([`RigidModes`]); elsewhere it is refused, with the motion. Motions that springs hold weakly are taken
//! out of A⁻¹ in the same way.
//!
//! Source: HKL §3; O. C. Zienkiewicz, R. L. Taylor, *The Finite Element Method*, ch. 6.

mod dofs;
mod element;
mod free_motions;
mod load;
mod rigid_modes;
mod rigid_motion;
mod springs;
mod stiffness;
mod tools;

pub use dofs::{DofMap, forces_of_prescribed, prescribed_displacements};
pub(crate) use element::Element;
pub use element::{MaterialField, Simplex, corner_strains, quadratic_gradients, traction};
pub(crate) use free_motions::loose_motions_of_bodies;
pub use load::{Loads, SurfaceLoad, load_warnings};
pub(crate) use load::{MissedForce, missed_body_forces};
pub(crate) use rigid_modes::rigid_modes;
pub use rigid_modes::{RigidModes, WeakSupport};
pub use rigid_motion::{BodyMotion, refuse_rigid_motions};
pub(crate) use springs::stiffness_at;
pub use springs::{SpringMatrix, SpringPoint, visit_springs};
pub use stiffness::{InternalForces, stiffness};
pub(crate) use stiffness::{NodeGraph, stiffness_on};
pub(crate) use tools::tool_loads;
pub use tools::{ToolPlace, ToolPoint};

//! What happens on Γ_c: frame, gap, friction law, and how multipliers act on displacements.
//!
//! * [`ContactFrame`]: the normal ν and the axes t₁, t₂ of friction, fixed or turning from node to node.
//! * [`Coupling`]: B = \[N; T\] in m², whose row of pane Rⁱ is ∫_Rⁱ v·ν and ∫_Rⁱ v·t_j (HKL (4.1)); for multipliers at
//!   nodes, the node's lumped area.
//! * [`CoulombLaw`]: F at the contact nodes and the slip bound of each pane, face by face.
//! * [`Ellipse`]: the tangential stresses that friction admits on a pane; projections on it.
//! * [`FrictionField`]: F₁(|u_t1|), F₂(|u_t2|) at nodes, and their means 𝓕_i⁻¹ = |Rⁱ|⁻¹ ∫_Rⁱ F⁻¹ over panes (HKL (4.2)).
//! * [`Interface`]: what the scene asks for, as one type per law, so that a body without friction has no friction field.
//! * [`transferred`]: multipliers on another mesh.
//! * [`slips`]: those that coefficients follow, of tangential displacements.
//! * [`LawBounds`]: F_max, F_min, the Lipschitz modulus L and the anisotropy κ, which HKL §3 bounds a law by.

mod coulomb;
mod coupling;
mod ellipse;
mod follow;
mod frame;
mod interface;
mod law_bounds;
mod touching;
mod transfer;

pub use coulomb::{CoulombLaw, FaceLaw, FrictionField};
pub use coupling::{Coupling, MultiplierLayout};
pub use ellipse::{Ellipse, ProjectionDerivative};
pub(crate) use follow::tool_rows;
pub use frame::{ContactFrame, Counterpart, ReferenceFrame};
pub use interface::{
    Interface, InterfaceFriction, PreviousIncrement, change_of_slips, slip_signs, slips,
};
pub use law_bounds::{LawBounds, LawExtreme};
pub(crate) use touching::PASSES;
pub use transfer::transferred;
pub(crate) use transfer::transferred_by_cells;

//! The contact terms: frame, gap and friction law of Γ_c, coupling of multipliers and
//! displacements, slip at nodes, friction on panes.

mod coupling;
mod frame;
mod friction_field;
mod interface;

pub use coupling::{Coupling, nodal_slip};
pub use frame::ContactFrame;
pub use friction_field::FrictionField;
pub use interface::{CoulombLaw, Interface, InterfaceFriction};

//! The contact terms: frame, gap and friction law of Γ_c, coupling of multipliers and
//! displacements, slip at nodes, friction on panes, bounds of the law.

mod coupling;
mod frame;
mod friction_field;
mod interface;
mod law_bounds;
#[cfg(test)]
mod law_bounds_tests;
mod law_search;
mod multiplier_layout;

pub(crate) use coupling::nodal_tangential;
pub use coupling::{Coupling, nodal_slip};
pub use frame::ContactFrame;
pub use friction_field::FrictionField;
pub use interface::{CoulombLaw, Interface, InterfaceFriction};
pub use law_bounds::{LawBounds, LawExtreme};
pub use multiplier_layout::MultiplierLayout;

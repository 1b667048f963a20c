//! The contact terms: coupling of multipliers and displacements, slip at nodes, friction on panes.

mod coupling;
mod friction_field;

pub use coupling::{Coupling, nodal_slip};
pub use friction_field::FrictionField;

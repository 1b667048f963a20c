//! P1 linear elasticity: element stiffness, parallel assembly, loads and clamps.

mod dofs;
mod element;
mod idle_load;
mod load;
mod material_field;
mod quadrature;
mod rigid_motion;
mod stiffness;

pub use dofs::DofMap;
pub(crate) use element::Element;
pub use idle_load::idle_loads;
pub use load::Loads;
pub use material_field::MaterialField;
pub use rigid_motion::refuse_rigid_motions;
pub(crate) use stiffness::node_adjacency;
pub use stiffness::{internal_forces, stiffness};

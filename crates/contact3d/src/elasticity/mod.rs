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
pub use element::Element;
pub use idle_load::idle_loads;
pub use load::Loads;
pub use material_field::MaterialField;
pub use rigid_motion::{RigidMotion, free_rigid_motions, refuse_rigid_motions};
pub use stiffness::{internal_forces, node_adjacency, stiffness};

//! P1 linear elasticity: element stiffness, parallel assembly, loads and clamps.

mod dofs;
mod element;
mod load;
mod stiffness;

pub use dofs::DofMap;
pub use element::Element;
pub use load::load_vector;
pub use stiffness::{internal_forces, node_adjacency, stiffness};

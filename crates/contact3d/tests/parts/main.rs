//! Parts of the library by themselves: laws and their bounds, scenes, materials, layouts, matrices, quadrature, warnings.

mod idle_loads;
mod law_bounds;
mod laws;
mod materials;
mod multiplier_layout;
mod quadrature;
mod scenes;
mod sparse_matrices;

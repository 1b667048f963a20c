//! The rooms of the library one by one, by their public items.

mod contact;
mod elasticity;
mod linalg;
mod mesh;
mod quadrature;
mod scene;
mod solver;

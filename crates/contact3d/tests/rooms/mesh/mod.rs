//! Meshes from files, and panes on them.

mod gmsh;
mod macro_elements;

//! Meshes from files.

mod gmsh;

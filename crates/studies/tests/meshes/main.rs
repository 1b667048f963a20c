//! Errors of meshes: the study of nested meshes, the bounds, and the distance of solutions that measures both.

mod cut_meshes;
mod distance;
mod error_bounds;
mod mesh_errors;

//! Rigid obstacles and curved contact faces: closed forms, poses, descriptions, refusals.

mod approach;
mod cattaneo;
mod cone;
mod descriptions;
mod frames;
mod half_space;
mod hertz;
mod moved;
mod planes;
mod pulled;
mod refusals;
mod rounded;
mod solved;
mod triangles;

//! Rigid obstacles and curved contact faces: closed forms, poses, descriptions, refusals.

mod descriptions;
mod frames;
mod hertz;
mod invariances;
mod moved;
mod refusals;
mod solved;

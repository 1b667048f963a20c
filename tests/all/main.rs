//! Tests of the program and of the library by whole scenes, in one binary, so that it is linked once and all run side by side; the
//! command line and sweeps have binaries of their own.

mod accuracy;
mod checkpoint;
mod effects;
mod elasticity;
mod fuzz;
mod layout;
mod literature_hkl2011;
mod mesh;
mod newton;
mod pipelines;
mod scene_page;
mod stability;
mod supply;
mod support;
mod supports;
mod verification;

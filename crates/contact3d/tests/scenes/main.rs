//! The library by whole scenes, in one binary, so that it is linked once and all run side by side.

mod adaptive;
mod adaptive_history;
mod bodies;
mod closed_forms;
mod examples;
mod facade;
mod faces;
mod floating;
mod gate;
mod glued;
mod graded;
mod hidden_contact;
mod load_history;
mod local_mapping;
mod matrix_free;
mod obstacles;
mod quadratic;
mod quantities;
mod single_precision;
mod storage;
mod strategies;
mod symmetry;
mod tools;

use contact3d::dual::ExplicitDual;
use nalgebra::DMatrix;

/// The smallest eigenvalue of S scaled to a unit diagonal: what keeps the multipliers of a mesh apart.
fn smallest_eigenvalue(dual: &ExplicitDual) -> f64 {
    let kept = (0..dual.dimension()).filter(|&j| dual.diagonal(j) > 0.0);
    let kept: Vec<usize> = kept.collect();
    let scaled = DMatrix::from_fn(kept.len(), kept.len(), |i, j| {
        let product = dual.diagonal(kept[i]) * dual.diagonal(kept[j]);
        dual.column(kept[j])[kept[i]] / product.sqrt()
    });
    scaled.symmetric_eigenvalues().min()
}

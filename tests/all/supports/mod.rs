//! What holds and loads a body: clamps at prescribed displacements, springs, total forces.

mod closed_forms;
mod driven;
mod forces;
mod operators;
mod refusals;
mod springs;
mod studies;

use crate::support;

/// Distances relative to the largest expected entry.
fn close(found: &[f64], expected: &[f64], tolerance: f64) {
    let size = expected.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found - expected).abs() <= tolerance * size,
            "{found:e} instead of {expected:e} of {size:e}"
        );
    }
}

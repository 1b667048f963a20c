//! Nested meshes of a brick.
//!
//! All cells of a brick's mesh are cut by the planes ±x ± y ± z = even and by the grid planes (in
//! units of a cell). Cutting every cell edge in m equal parts keeps each of these planes among the
//! finer ones, so the finer mesh is nested in the coarser one, panes included.

use super::AccuracySettings;
use crate::{
    problem::ProblemError,
    scene::{Brick, Invalid, Scene},
};

/// n_div of a brick: its smallest number of cells along an edge.
#[must_use]
pub(crate) fn brick_n_div(brick: &Brick) -> usize {
    brick.cells.into_iter().min().unwrap_or(1)
}

/// The finest mesh when none is asked for: 4, 2 or 1 times the scene's n_div, the first that does
/// not exceed 32; the scene's own where that is larger.
#[must_use]
pub(crate) fn default_finest(n_div: usize) -> usize {
    let fits = |factor: &usize| factor * n_div <= 32;
    [4, 2].into_iter().find(fits).unwrap_or(1) * n_div
}

/// Cells of all meshes of a brick in which the finest one is nested and whose proportions are
/// those of the scene, coarse to fine.
///
/// # Errors
/// A finest mesh in which the scene's own is not nested.
pub fn nested_cells(
    scene: &Scene,
    brick: &Brick,
    settings: &AccuracySettings,
) -> Result<Vec<[usize; 3]>, ProblemError> {
    let n_div = brick_n_div(brick);
    let finest = settings.finest.unwrap_or_else(|| default_finest(n_div));
    if finest == 0 || !finest.is_multiple_of(n_div) {
        return Err(ProblemError::Invalid(Invalid {
            key: "--finest".into(),
            expected: format!("a multiple of {n_div}, the scene's n_div"),
            found: finest.to_string(),
            help: "the scene's mesh must be nested in the finest one; change body.brick.cells with --set for another scene mesh".into(),
        }));
    }
    let finest_cells = brick.cells.map(|cells| cells * (finest / n_div));
    let parts = finest_cells.into_iter().fold(0, greatest_common_divisor);
    let meshes = (1..=parts).rev().filter(|m| parts.is_multiple_of(*m));
    let cells = meshes.map(|m| finest_cells.map(|cells| cells / m));
    Ok(cells
        .filter(|cells| {
            let n_div = cells.iter().copied().min().unwrap_or(0);
            n_div >= settings.coarsest && is_valid(scene, *cells)
        })
        .collect())
}

/// The scene with other cells.
pub(super) fn with_cells(scene: &Scene, cells: [usize; 3]) -> Scene {
    let mut scene = scene.clone();
    if let Some(brick) = scene.body.as_brick_mut() {
        brick.cells = cells;
    }
    scene
}

/// Whether the panes fit on the cells.
fn is_valid(scene: &Scene, cells: [usize; 3]) -> bool {
    with_cells(scene, cells).validate().is_ok()
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 {
        a
    } else {
        greatest_common_divisor(b, a % b)
    }
}

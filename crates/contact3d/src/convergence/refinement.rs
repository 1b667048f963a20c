//! Nested meshes of a brick.
//!
//! All cells of a brick's mesh are cut by the planes ±x ± y ± z = even and by the grid planes (in
//! units of a cell). Cutting every cell edge in m equal parts keeps each of these planes among the
//! finer ones, so the finer mesh is nested in the coarser one, panes included. Finer meshes of a graded
//! brick therefore have planes given by their coordinates; grading them anew would move planes.

use super::AccuracySettings;
use crate::{
    problem::ProblemError,
    scene::{Brick, BrickFace, Contact, Invalid, MultiplierSpace, Scene, Shape},
};

/// Planes are rounded a few times on their way from a scene, each time to half of 2e-16.
const PLANE_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Digits that typed corners of a part of a contact face share with the planes between cells.
const PART_ROUNDING: f64 = 1e-9;

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

/// All meshes of a brick in which the finest one is nested and whose proportions are those of the scene,
/// coarse to fine.
///
/// # Errors
/// A finest mesh in which the scene's own is not nested.
pub fn nested_bricks(
    scene: &Scene,
    brick: &Brick,
    settings: &AccuracySettings,
) -> Result<Vec<Brick>, ProblemError> {
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
    let finest = refined(brick, finest / n_div);
    let parts = finest.cells.into_iter().fold(0, greatest_common_divisor);
    let merged = (1..=parts).rev().filter(|m| parts.is_multiple_of(*m));
    let bricks = merged.filter_map(|m| coarsened(&finest, m));
    Ok(bricks
        .filter(|brick| brick_n_div(brick) >= settings.coarsest && is_valid(scene, brick))
        .collect())
}

/// The brick with every cell edge cut in so many equal parts.
pub(super) fn refined(brick: &Brick, parts: usize) -> Brick {
    let mut finer = brick.clone();
    finer.cells = brick.cells.map(|cells| cells * parts);
    for axis in (0..3).filter(|axis| parts > 1 && !brick.is_even(*axis)) {
        let planes = brick.planes(axis);
        let inside = planes.windows(2).flat_map(|pair| {
            let part = (pair[1] - pair[0]) / parts as f64;
            (0..parts).map(move |k| pair[0] + k as f64 * part)
        });
        let end = planes.last().copied();
        set_planes(&mut finer, axis, inside.chain(end).collect());
    }
    finer
}

/// The brick with so many cells merged along each axis; `None` where they are not equally wide, since the
/// finer mesh would not be nested.
fn coarsened(brick: &Brick, merged: usize) -> Option<Brick> {
    let mut coarser = brick.clone();
    coarser.cells = brick.cells.map(|cells| cells / merged);
    for axis in (0..3).filter(|axis| merged > 1 && !brick.is_even(*axis)) {
        let planes = brick.planes(axis);
        if !merges_equal_cells(&planes, merged) {
            return None;
        }
        let kept = planes.iter().copied().step_by(merged);
        set_planes(&mut coarser, axis, kept.collect());
    }
    Some(coarser)
}

/// Whether each group of so many cells has cells of one width, to rounding of the planes.
fn merges_equal_cells(planes: &[f64], merged: usize) -> bool {
    let length = planes.last().copied().unwrap_or(0.0);
    let starts = (0..planes.len() - 1).step_by(merged);
    let mut groups = starts.map(|start| &planes[start..=start + merged]);
    groups.all(|group| {
        let (first, width) = (group[0], group[merged] - group[0]);
        let mut at = group.iter().enumerate();
        at.all(|(k, x)| {
            let even = first + width * (k as f64 / merged as f64);
            (x - even).abs() <= PLANE_ROUNDING * length
        })
    })
}

fn set_planes(brick: &mut Brick, axis: usize, planes: Vec<f64>) {
    *brick.coordinates.along_mut(axis) = Some(planes);
    for face in BrickFace::ALL
        .into_iter()
        .filter(|face| face.axis() == axis)
    {
        *brick.grading.towards_mut(face) = 1.0;
    }
}

/// The smallest numbers of cells with the proportions of a brick.
#[must_use]
pub(super) fn proportions(brick: &Brick) -> [usize; 3] {
    let parts = brick.cells.into_iter().fold(0, greatest_common_divisor);
    brick.cells.map(|cells| cells / parts.max(1))
}

/// The scene with so many equal cells.
pub(super) fn with_cells(scene: &Scene, cells: [usize; 3]) -> Scene {
    match scene.body.as_brick() {
        Some(brick) => with_brick(scene, &Brick::new(brick.size, cells)),
        None => scene.clone(),
    }
}

/// The scene with another brick.
pub(crate) fn with_brick(scene: &Scene, brick: &Brick) -> Scene {
    let mut scene = scene.clone();
    scene.body.shape = Shape::Brick(brick.clone());
    scene
}

/// Whether the panes fit on the cells, and the parts of faces that are in contact on the panes.
fn is_valid(scene: &Scene, brick: &Brick) -> bool {
    with_brick(scene, brick).validate().is_ok() && contact_parts_fit(scene, brick)
}

/// Whether the sides of the boxes that cut parts out of contact faces lie beyond the brick or between its panes.
pub(super) fn contact_parts_fit(scene: &Scene, brick: &Brick) -> bool {
    let fits = |contact: &Contact| {
        let (Some(corners), Some(face)) = (contact.corners, BrickFace::named(&contact.face)) else {
            return true;
        };
        let step = match contact.multipliers {
            MultiplierSpace::Panes => scene.body.element.cells_per_pane(),
            MultiplierSpace::Nodal => 1,
        };
        let mut along = (0..3).filter(|axis| *axis != face.axis());
        along.all(|axis| {
            let (planes, length) = (brick.planes(axis), brick.size[axis]);
            let is_between = |side: f64| {
                let mut planes = planes.iter().step_by(step);
                planes.any(|plane| (plane - side).abs() <= PART_ROUNDING * length)
            };
            let sides = corners.map(|corner| corner[axis]);
            sides
                .into_iter()
                .all(|side| side <= 0.0 || side >= length || is_between(side))
        })
    };
    scene.contacts.iter().all(fits)
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 {
        a
    } else {
        greatest_common_divisor(b, a % b)
    }
}

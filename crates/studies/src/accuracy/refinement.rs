//! Nested meshes: bricks, prolongation from one mesh to the finest, and Richardson extrapolation over them.
//!
//! All cells of a brick's mesh are cut by the planes ±x ± y ± z = even and by the grid planes (in
//! units of a cell). Cutting every cell edge in m equal parts keeps each of these planes among the
//! finer ones, so the finer mesh is nested in the coarser one, panes included. Finer meshes of a graded
//! brick therefore have planes given by their coordinates; grading them anew would move planes.

use std::sync::Arc;

use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

use super::AccuracySettings;
use crate::shared::greatest_common_divisor;
use contact3d::{
    ProblemError,
    mesh::{Descendant, Mesh},
    reference::quadratic_tetrahedron,
    scene::{Brick, BrickFace, Contact, Grading, InvalidValue, MultiplierSpace, Scene},
};

/// n_div of a brick: its smallest number of cells along an edge.
#[must_use]
pub(crate) fn brick_n_div(brick: &Brick) -> usize {
    brick.cells.into_iter().min().unwrap_or(1)
}

/// The finest mesh when none is asked for: 4, 2 or 1 times the scene's n_div, the first that does
/// not exceed 32; the scene's own where that is larger.
#[must_use]
fn default_finest(n_div: usize) -> usize {
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
        return Err(ProblemError::Invalid(InvalidValue {
            key: "--finest".into(),
            expected: format!("a multiple of {n_div}, the scene's n_div"),
            found: finest.to_string(),
            help: "the scene's mesh must be nested in the finest one; change body.brick.cells with --set for another scene mesh".into(),
        }));
    }
    let (mut coarsest, mut parts) = (brick.clone(), finest / n_div);
    // Cells of different widths cannot be merged: the finer mesh would not be nested.
    if (0..3).all(|axis| brick.is_even(axis)) {
        let merged = brick.cells.into_iter().fold(0, greatest_common_divisor);
        coarsest.cells = brick.cells.map(|cells| cells / merged);
        parts *= merged;
    }
    let bricks = (1..=parts).filter(|n| parts.is_multiple_of(*n));
    let bricks = bricks.map(|n| refined(&coarsest, n));
    let is_wanted = |brick: &Brick| {
        brick_n_div(brick) >= settings.coarsest.unwrap_or(4).min(n_div)
            && with_brick(scene, brick).validate().is_ok()
            && contact_parts_fit(scene, brick)
    };
    Ok(bricks.filter(is_wanted).collect())
}

/// The brick with every cell edge cut in so many equal parts.
fn refined(brick: &Brick, parts: usize) -> Brick {
    let mut finer = brick.clone();
    finer.cells = brick.cells.map(|cells| cells * parts);
    for axis in (0..3).filter(|axis| parts > 1 && !brick.is_even(*axis)) {
        let planes = brick.planes(axis);
        let inside = planes.windows(2).flat_map(|pair| {
            let part = (pair[1] - pair[0]) / parts as f64;
            (0..parts).map(move |k| pair[0] + k as f64 * part)
        });
        let end = planes.last().copied();
        finer = finer.with_planes(axis, inside.chain(end).collect());
        finer.grading = Grading::default();
    }
    finer
}

/// The scene with another brick.
pub(crate) fn with_brick(scene: &Scene, brick: &Brick) -> Scene {
    let mut scene = scene.clone();
    scene.bodies[0].brick = Some(brick.clone());
    scene
}

/// Whether the sides of the boxes that cut parts out of contact faces lie beyond the brick or between its panes.
pub(super) fn contact_parts_fit(scene: &Scene, brick: &Brick) -> bool {
    let fits = |contact: &Contact| {
        let (Some(corners), Some(face)) = (contact.corners, BrickFace::named(&contact.face)) else {
            return true;
        };
        let step = match contact.multipliers {
            MultiplierSpace::Panes => scene.element().cells_per_pane(),
            MultiplierSpace::Nodal => 1,
        };
        let mut along = (0..3).filter(|axis| *axis != face.axis());
        along.all(|axis| {
            let (planes, length) = (brick.planes(axis), brick.size[axis]);
            let is_between = |side: f64| {
                let mut planes = planes.iter().step_by(step);
                // Digits that typed corners of a part of a contact face share with the planes between cells.
                planes.any(|plane| (plane - side).abs() <= 1e-9 * length)
            };
            let mut sides = corners.iter().map(|corner| corner[axis]);
            sides.all(|side| side <= 0.0 || side >= length || is_between(side))
        })
    };
    scene.contacts.iter().all(fits)
}

/// Functionals of P1 solutions converge with order 2 at best; twice that means that the last
/// difference is small by chance.
const HIGHEST_ORDER: f64 = 4.0;

/// The order p of three values at the mesh sizes h₁ > h₂ > h₃, from
/// (v₁ − v₂)/(v₂ − v₃) = (h₁ᵖ − h₂ᵖ)/(h₂ᵖ − h₃ᵖ), whose right-hand side grows with p.
///
/// `None` where the values do not approach a limit: the differences change sign or grow too fast
/// for any p > 0, or are below `negligible`, where they are rounding.
#[must_use]
pub(crate) fn observed_order(h: [f64; 3], v: [f64; 3], negligible: f64) -> Option<f64> {
    let [first, second] = [v[0] - v[1], v[1] - v[2]];
    if first.abs() <= negligible || second.abs() <= negligible {
        return None;
    }
    let wanted = first / second;
    let slowest = (h[0] / h[1]).ln() / (h[1] / h[2]).ln();
    let ratio = |p: f64| {
        let [coarse, fine] = [h[0] / h[1], h[2] / h[1]].map(|r| (p * r.ln()).exp_m1());
        coarse / -fine
    };
    if !wanted.is_finite() || wanted <= slowest || wanted >= ratio(HIGHEST_ORDER) {
        return None;
    }
    let (mut low, mut high) = (0.0, HIGHEST_ORDER);
    // Each halving gains a bit; the 53 of a double suffice.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if ratio(middle) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}

/// The limit v₀ of the last two values at h₂ > h₃ for a known order.
#[must_use]
pub fn extrapolated(h: [f64; 2], v: [f64; 2], order: f64) -> f64 {
    v[1] + (v[1] - v[0]) / ((h[0] / h[1]).powf(order) - 1.0)
}

/// A mesh with the displacement of its nodes.
pub(super) struct SolvedMesh {
    /// The brick that was meshed; `None` of a mesh that was cut from that of the scene.
    pub(super) brick: Option<Brick>,
    pub(super) mesh: Arc<Mesh>,
    /// Where its tetrahedra lie in the mesh of the scene, of meshes that were cut.
    pub(super) descendants: Vec<Descendant>,
    /// In m, `[n_nodes]`.
    pub(super) displacement: Vec<[f64; 3]>,
}

impl SolvedMesh {
    /// The displacement at the nodes of a finer mesh, whose tetrahedra lie in those of `around` where they were cut: exact interpolation
    /// where the meshes are nested, with curved sides too, as a cut tetrahedron keeps the map of its ancestor.
    pub(super) fn prolongated(&self, finer: &Self, around: &[usize]) -> Vec<[f64; 3]> {
        if let Some(brick) = &self.brick {
            let planes = [0, 1, 2].map(|axis| brick.planes(axis));
            let value = |point: &[f64; 3]| {
                let (tetrahedron, at) = tetrahedron_around(&planes, &self.mesh, point);
                self.at(tetrahedron, at)
            };
            return finer.mesh.coordinates.iter().map(value).collect();
        }
        let mut values = vec![[0.0; 3]; finer.mesh.coordinates.len()];
        for (t, (descendant, &around)) in finer.descendants.iter().zip(around).enumerate() {
            let corners = Matrix4::from(self.descendants[around].places);
            let inverse = corners.try_inverse().unwrap_or_else(Matrix4::zeros);
            let nodes = finer.mesh.tetrahedron_nodes(t);
            for (node, place) in nodes.zip(descendant.nodes()) {
                values[node] = self.at(around, (inverse * Vector4::from(place)).into());
            }
        }
        values
    }

    /// The displacement at a place of a tetrahedron.
    fn at(&self, tetrahedron: usize, place: [f64; 4]) -> [f64; 3] {
        let shape = match &self.mesh.mid_edges {
            None => place.to_vec(),
            Some(_) => quadratic_tetrahedron(&place).to_vec(),
        };
        let nodes = || self.mesh.tetrahedron_nodes(tetrahedron).zip(&shape);
        std::array::from_fn(|c| nodes().map(|(n, w)| w * self.displacement[n][c]).sum())
    }
}

/// The tetrahedron that holds a point, and the point's barycentric coordinates in it. A brick's
/// tetrahedra come five a cell, the cells with the first index fastest.
fn tetrahedron_around(planes: &[Vec<f64>; 3], mesh: &Mesh, point: &[f64; 3]) -> (usize, [f64; 4]) {
    let cells: [usize; 3] = std::array::from_fn(|axis| planes[axis].len() - 1);
    let [i, j, k] = std::array::from_fn(|axis| {
        let inner = &planes[axis][1..cells[axis]];
        inner.partition_point(|plane| *plane <= point[axis])
    });
    let cell = i + cells[0] * (j + cells[1] * k);
    let depth = |weights: &[f64; 4]| weights.iter().copied().fold(f64::INFINITY, f64::min);
    (5 * cell..5 * (cell + 1))
        .map(|t| (t, barycentric(mesh, t, point)))
        .max_by(|(_, a), (_, b)| depth(a).total_cmp(&depth(b)))
        .unwrap_or((0, [0.0; 4]))
}

/// Barycentric coordinates of a point in a tetrahedron with straight sides.
fn barycentric(mesh: &Mesh, tetrahedron: usize, point: &[f64; 3]) -> [f64; 4] {
    let corners = mesh.corners(&mesh.tetrahedra[tetrahedron]);
    let [a, b, c, d] = corners.map(Vector3::from);
    let edges = Matrix3::from_columns(&[b - a, c - a, d - a]);
    let inverse = edges.try_inverse().unwrap_or_else(Matrix3::zeros);
    let weights = inverse * (Vector3::from(*point) - a);
    [1.0 - weights.sum(), weights[0], weights[1], weights[2]]
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_power_law_is_recovered(
            order in 0.2..3.9_f64,
            ratios in [1.2..4.0_f64, 1.2..4.0_f64],
            limit in -3.0..3.0_f64,
            factor in prop_oneof![0.5..2.0_f64, -2.0..-0.5_f64],
        ) {
            let h = [1.0, 1.0 / ratios[0], 1.0 / (ratios[0] * ratios[1])];
            let v = h.map(|h| limit + factor * h.powf(order));
            let found = observed_order(h, v, 0.0).unwrap();
            // Values of size 3 rounded to 1e-16, over differences of 1e-2 at least: a loss of
            // three digits, and as many again for high orders.
            prop_assert!((found - order).abs() < 1e-9);
            let found = extrapolated([h[1], h[2]], [v[1], v[2]], order);
            // The same cancellation, divided by 1.2^0.2 − 1 = 0.04.
            prop_assert!((found - limit).abs() < 1e-11);
        }
    }

    #[test]
    fn no_order_is_claimed_without_convergence() {
        let h = [1.0, 0.5, 0.25];
        assert_eq!(observed_order(h, [0.0, 1.0, 0.5], 0.0), None);
        assert_eq!(observed_order(h, [0.0, 1.0, 2.0], 0.0), None);
        assert_eq!(observed_order(h, [0.0, 1.0, 1.0], 0.0), None);
        assert_eq!(observed_order(h, [0.0, 1e-12, 1.5e-12], 1e-11), None);
    }

    #[test]
    fn each_tetrahedron_of_a_finer_mesh_lies_in_one_of_a_coarser() {
        let settings = AccuracySettings {
            coarsest: Some(1),
            finest: Some(12),
            ..AccuracySettings::default()
        };
        let text = include_str!("../../../../pipelines/newton.toml");
        let base = Scene::parse("newton.toml", text).expect("valid pipeline");
        let mesh = |scene: &Scene| Mesh::of_scene(scene, Path::new("")).expect("a brick");
        let even = Brick::new([3.0, 1.0, 1.0], [6, 2, 2]);
        let graded = even
            .clone()
            .with_grading(BrickFace::XMin, 1.7)
            .with_grading(BrickFace::ZMin, 1.4)
            .with_grading(BrickFace::ZMax, 2.0);
        for brick in [even, graded] {
            let scene = with_brick(&base, &brick);
            let study = nested_bricks(&scene, &brick, &settings).expect("nested meshes");
            let n_divs: Vec<usize> = study.iter().map(|brick| brick.cells[2]).collect();
            assert_eq!(n_divs, [2, 4, 6, 12]);
            let finest = mesh(&with_brick(&scene, &study[3]));
            for brick in &study {
                let coarse = mesh(&with_brick(&scene, brick));
                let planes = [0, 1, 2].map(|axis| brick.planes(axis));
                for nodes in &finest.tetrahedra {
                    let corners = finest.corners(nodes);
                    let centre = std::array::from_fn(|c| corners.iter().map(|x| x[c] / 4.0).sum());
                    let (around, _) = tetrahedron_around(&planes, &coarse, &centre);
                    for corner in corners {
                        let at = barycentric(&coarse, around, &corner);
                        // Differences of coordinates near 1 over cells of 0.02 and more.
                        assert!(at.iter().all(|weight| *weight > -1e-13), "{at:?}");
                    }
                }
            }
        }
    }
}

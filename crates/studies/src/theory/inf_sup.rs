//! Condition (3.1) and the Babuška–Brezzi constant of HKL §3.2 for several spaces of multipliers.

use std::collections::BTreeMap;

use faer::Mat;
use nalgebra::Vector3;

use super::{
    dense::{DenseFactor, diagonal},
    face::{FaceGram, PaneIntegrals, TriangulatedFace, distance, gradients},
};
use contact3d::scene::{Brick, BrickFace};

/// A point this share of a triangle outside of it lies in it: roundings of planes.
const INSIDE: f64 = 1e-9;

/// A space of multipliers on the contact face of a brick.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum TrialSpace {
    /// Constant on pieces of one cell (FE2).
    #[default]
    Cells1,
    /// Constant on pieces of 2 × 2 cells, HKL's panes (FE2).
    Cells2,
    /// Constant on pieces of 4 × 4 cells (FE2).
    Cells4,
    /// Continuous and linear on the triangles, L^H = Y^h (FE1).
    Linear,
}

impl TrialSpace {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Cells1, Self::Cells2, Self::Cells4, Self::Linear];

    /// Cells along the edge of a piece; `None` for linear multipliers.
    #[must_use]
    pub fn width(self) -> Option<usize> {
        match self {
            Self::Cells1 => Some(1),
            Self::Cells2 => Some(2),
            Self::Cells4 => Some(4),
            Self::Linear => None,
        }
    }

    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Cells1 => "1 x 1 cells",
            Self::Cells2 => "2 x 2 cells",
            Self::Cells4 => "4 x 4 cells",
            Self::Linear => "linear",
        }
    }
}

/// How stable a space of multipliers is on one mesh, in the norm of H¹(Ω)³.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct InfSup {
    /// The space.
    pub space: TrialSpace,
    /// Diameter H of a piece over the diameter h of a contact triangle.
    pub ratio: f64,
    /// λ_min of ‖μ‖²_{*,h} over ‖μ‖²_{0,Γ_c}: (3.1) holds where it is positive.
    pub smallest: f64,
    /// c_inv⁽⁰'⁻¹ᐟ²⁾ of (3.16), √(H / λ_min); infinite where (3.1) fails.
    pub inverse_half: f64,
    /// β: the least ‖μ‖_{*,h} on this mesh over that on the finest mesh; `None` on the finest.
    pub inf_sup: Option<f64>,
}

/// A brick's contact face with its Gram matrix in H¹(Ω)³.
pub(super) struct BrickFaceGram<'a> {
    pub(super) brick: &'a Brick,
    pub(super) face: &'a TriangulatedFace,
    pub(super) gram: &'a FaceGram,
}

/// The stability of each space that fits on the cells of a brick, against the finest mesh where that is another one.
pub(super) fn inf_sup(
    on: BrickFace,
    here: &BrickFaceGram<'_>,
    finest: Option<&BrickFaceGram<'_>>,
) -> Vec<InfSup> {
    let spaces = TrialSpace::ALL.into_iter();
    let measured = spaces.filter_map(|space| {
        let trial = TrialMultipliers::new(space, on, here)?;
        let own = here.gram.normal(&(trial.rows)(here.face));
        let norm = DenseFactor::new(&own);
        let fine = finest.map(|finest| finest.gram.normal(&(trial.rows)(finest.face)));
        let smallest = DenseFactor::new(&trial.mass)?.smallest_of(&own);
        let largest = norm.zip(fine).map(|(norm, fine)| norm.largest_of(&fine));
        Some(InfSup {
            space,
            ratio: trial.size / here.face.size(),
            smallest,
            inverse_half: if smallest > 0.0 {
                (trial.size / smallest).sqrt()
            } else {
                f64::INFINITY
            },
            inf_sup: largest.map(|value| value.sqrt().recip()),
        })
    });
    measured.collect()
}

/// A space of multipliers that does not depend on the mesh of displacements.
struct TrialMultipliers<'a> {
    /// In terms of the nodal values of a face.
    rows: Box<dyn Fn(&TriangulatedFace) -> PaneIntegrals + 'a>,
    /// ∫ μ_i μ_j.
    mass: Mat<f64>,
    /// H in m.
    size: f64,
}

impl<'a> TrialMultipliers<'a> {
    fn new(space: TrialSpace, on: BrickFace, here: &BrickFaceGram<'a>) -> Option<Self> {
        let (brick, coarse) = (here.brick, here.face);
        let Some(width) = space.width() else {
            return Some(Self {
                rows: Box::new(|face| hats(coarse, face)),
                mass: dense_mass(coarse),
                size: coarse.size(),
            });
        };
        let axes: Vec<usize> = (0..3).filter(|&axis| axis != on.axis()).collect();
        let axes = [axes[0], axes[1]];
        if !axes
            .iter()
            .all(|&axis| brick.cells[axis].is_multiple_of(width))
        {
            return None;
        }
        // The planes between pieces.
        let planes = axes
            .map(|axis| -> Vec<f64> { brick.planes(axis).into_iter().step_by(width).collect() });
        let [first, second] = planes.each_ref().map(|planes| {
            let widths = planes.windows(2).map(|p| p[1] - p[0]);
            widths.fold(0.0, f64::max)
        });
        let rows = move |face: &TriangulatedFace| boxes(face, axes, &planes);
        Some(Self {
            mass: diagonal(&rows(coarse).areas()),
            rows: Box::new(rows),
            size: first.hypot(second),
        })
    }
}

fn dense_mass(face: &TriangulatedFace) -> Mat<f64> {
    let mass = face.forms().mass;
    let mut dense = Mat::zeros(mass.rows, mass.cols);
    for column in 0..mass.cols {
        for (row, value) in mass.entries(column) {
            dense[(row, column)] = value;
        }
    }
    dense
}

/// ∫ φ_j over each box.
fn boxes(face: &TriangulatedFace, axes: [usize; 2], planes: &[Vec<f64>; 2]) -> PaneIntegrals {
    let counts = planes.each_ref().map(|planes| planes.len() - 1);
    let mut sums = vec![BTreeMap::new(); counts[0] * counts[1]];
    for (t, nodes) in face.triangles.iter().enumerate() {
        let at = [0, 1].map(|k| {
            let corners = face.corners(t);
            let middle = corners.iter().map(|x| x[axes[k]]).sum::<f64>() / 3.0;
            planes[k]
                .partition_point(|p| *p <= middle)
                .clamp(1, counts[k])
                - 1
        });
        for &node in nodes {
            *sums[at[1] * counts[0] + at[0]].entry(node).or_insert(0.0) += face.area(t) / 3.0;
        }
    }
    PaneIntegrals::of_sums(sums)
}

/// ∫ χ_i φ_j with the hat functions χ of a coarser face in which this one is nested.
fn hats(coarse: &TriangulatedFace, face: &TriangulatedFace) -> PaneIntegrals {
    let values = face.points.iter().map(|point| hats_at(coarse, *point));
    let values: Vec<Vec<(usize, f64)>> = values.collect();
    let mut sums = vec![BTreeMap::new(); coarse.n_free()];
    for (t, nodes) in face.triangles.iter().enumerate() {
        let area = face.area(t);
        for (a, j) in nodes.iter().enumerate() {
            for (b, other) in nodes.iter().enumerate() {
                let mass = area / if a == b { 6.0 } else { 12.0 };
                for &(i, value) in &values[*other] {
                    if let Some(place) = coarse.place[i] {
                        *sums[place].entry(*j).or_insert(0.0) += mass * value;
                    }
                }
            }
        }
    }
    PaneIntegrals::of_sums(sums)
}

/// Barycentric coordinates of a point in a triangle that holds it.
fn hats_at(face: &TriangulatedFace, point: [f64; 3]) -> Vec<(usize, f64)> {
    let reach = face.size();
    for (t, nodes) in face.triangles.iter().enumerate() {
        let corners = face.corners(t);
        if distance(corners[0], point) > reach * (1.0 + INSIDE) {
            continue;
        }
        let away = Vector3::from(point) - Vector3::from(corners[0]);
        let gradients = gradients(&corners);
        let value = |k: usize| {
            let along = gradients[k].dot(&away);
            if k == 0 { 1.0 + along } else { along }
        };
        let values = [value(0), value(1), value(2)];
        if values.iter().all(|v| *v >= -INSIDE) {
            return nodes.iter().copied().zip(values).collect();
        }
    }
    Vec::new()
}

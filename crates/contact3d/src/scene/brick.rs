//! The box and the planes that cut it in cells: equal ones, graded ones, or given ones.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Measure, is_default};

/// Most cells of a brick along an edge.
pub const MOST_CELLS: usize = 4096;

/// The largest exponent of graded cells: with it, two cells alone differ a billionfold.
const MOST_GRADING: usize = 30;

/// A box and its mesh, whose cells lie between planes perpendicular to the axes (HKL §4).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Brick {
    /// Edge lengths [Lx, Ly, Lz] > 0 in m.
    #[schemars(extend("measures" = Measure::Length, "exclusiveMinimum" = 0))]
    pub size: [f64; 3],
    /// Numbers of cells [nx, ny, nz]; with panes of P1, even along the two axes of the contact face.
    #[schemars(extend("minimum" = 1, "maximum" = MOST_CELLS))]
    pub cells: [usize; 3],
    /// Faces towards which cells shrink; equal cells where none is named.
    #[serde(default, skip_serializing_if = "is_default")]
    pub grading: Grading,
    /// The planes between the cells along axes that have neither equal nor graded cells.
    #[serde(default, skip_serializing_if = "is_default")]
    pub coordinates: GivenPlanes,
}

/// How cells shrink towards each face: an exponent from 1, equal cells, to 30.
///
/// Along an axis with exponent p towards its lower and q towards its upper face, node i of n lies at the
/// share B(i/n; p, q) / B(1; p, q) of the length, B(s; p, q) = ∫₀ˢ tᵖ⁻¹ (1 − t)^(q−1) dt. That is (i/n)ᵖ where q = 1,
/// and as smooth between two graded faces as at one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Grading {
    /// Exponent towards x = 0.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1, "maximum" = MOST_GRADING))]
    pub x_min: f64,
    /// Exponent towards x = Lx.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1, "maximum" = MOST_GRADING))]
    pub x_max: f64,
    /// Exponent towards y = 0.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1, "maximum" = MOST_GRADING))]
    pub y_min: f64,
    /// Exponent towards y = Ly.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1, "maximum" = MOST_GRADING))]
    pub y_max: f64,
    /// Exponent towards z = 0.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1, "maximum" = MOST_GRADING))]
    pub z_min: f64,
    /// Exponent towards z = Lz.
    #[serde(skip_serializing_if = "is_one")]
    #[schemars(extend("minimum" = 1, "maximum" = MOST_GRADING))]
    pub z_max: f64,
}

/// Coordinates in m of the planes between cells, from 0 to the edge length; absent axes have equal or
/// graded cells.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GivenPlanes {
    /// From x = 0 to x = Lx, nx + 1 numbers in m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub x: Option<Vec<f64>>,
    /// From y = 0 to y = Ly, ny + 1 numbers in m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub y: Option<Vec<f64>>,
    /// From z = 0 to z = Lz, nz + 1 numbers in m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub z: Option<Vec<f64>>,
}

impl Brick {
    /// A box with edges in m, cut in equal cells.
    #[must_use]
    pub fn new(size: [f64; 3], cells: [usize; 3]) -> Self {
        Self {
            size,
            cells,
            grading: Grading::default(),
            coordinates: GivenPlanes::default(),
        }
    }

    /// The same box with cells that shrink towards a face; see [`Grading`] for the exponent.
    ///
    /// ```
    /// use contact3d::scene::{Body, Brick, BrickFace};
    ///
    /// let brick = Brick::new([3.0, 1.0, 1.0], [4, 2, 2]).with_grading(BrickFace::XMin, 2.0);
    /// assert_eq!(brick.planes(0), [0.0, 0.1875, 0.75, 1.6875, 3.0]);
    /// let body: Body = brick.into();
    /// ```
    #[must_use]
    pub fn with_grading(mut self, face: BrickFace, exponent: f64) -> Self {
        *self.grading.towards_mut(face) = exponent;
        self
    }

    /// The same box with given planes between the cells along axis 0, 1 or 2, from 0 to the edge length in m,
    /// which they set together with the number of cells.
    #[must_use]
    pub fn with_planes(mut self, axis: usize, planes: Vec<f64>) -> Self {
        self.cells[axis] = planes.len().saturating_sub(1);
        self.size[axis] = planes.last().copied().unwrap_or(0.0);
        *self.coordinates.along_mut(axis) = Some(planes);
        self
    }

    /// Coordinates in m of the planes between cells along an axis, `[cells + 1]`, increasing from 0 to the edge
    /// length.
    #[must_use]
    pub fn planes(&self, axis: usize) -> Vec<f64> {
        if let Some(given) = self.coordinates.along(axis) {
            return given.clone();
        }
        let (length, n) = (self.size[axis], self.cells[axis]);
        let exponents = self.grading.along(axis);
        let plane = |i: usize| length * graded_share(i, n, exponents);
        (0..=n).map(plane).collect()
    }

    /// Whether the cells along an axis are equal by definition.
    #[must_use]
    pub fn is_even(&self, axis: usize) -> bool {
        self.coordinates.along(axis).is_none() && self.grading.along(axis) == [1.0; 2]
    }
}

impl Default for Grading {
    fn default() -> Self {
        Self {
            x_min: 1.0,
            x_max: 1.0,
            y_min: 1.0,
            y_max: 1.0,
            z_min: 1.0,
            z_max: 1.0,
        }
    }
}

impl Grading {
    /// The exponent towards a face.
    #[must_use]
    pub fn towards(&self, face: BrickFace) -> f64 {
        self.along(face.axis())[usize::from(face.is_max())]
    }

    /// As [`Self::towards`], to change.
    #[must_use]
    pub fn towards_mut(&mut self, face: BrickFace) -> &mut f64 {
        match face {
            BrickFace::XMin => &mut self.x_min,
            BrickFace::XMax => &mut self.x_max,
            BrickFace::YMin => &mut self.y_min,
            BrickFace::YMax => &mut self.y_max,
            BrickFace::ZMin => &mut self.z_min,
            BrickFace::ZMax => &mut self.z_max,
        }
    }

    /// The exponents towards the lower and the upper face of an axis.
    #[must_use]
    pub fn along(&self, axis: usize) -> [f64; 2] {
        [
            [self.x_min, self.x_max],
            [self.y_min, self.y_max],
            [self.z_min, self.z_max],
        ][axis]
    }
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde asks for a reference"
)]
fn is_one(exponent: &f64) -> bool {
    *exponent == 1.0
}

impl GivenPlanes {
    /// The planes along an axis; `None` for equal or graded cells.
    #[must_use]
    pub fn along(&self, axis: usize) -> Option<&Vec<f64>> {
        [&self.x, &self.y, &self.z][axis].as_ref()
    }

    /// As [`Self::along`], to change.
    #[must_use]
    pub fn along_mut(&mut self, axis: usize) -> &mut Option<Vec<f64>> {
        [&mut self.x, &mut self.y, &mut self.z][axis]
    }
}

/// A face of the brick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BrickFace {
    /// x = 0.
    XMin,
    /// x = Lx.
    XMax,
    /// y = 0.
    YMin,
    /// y = Ly.
    YMax,
    /// z = 0.
    ZMin,
    /// z = Lz.
    ZMax,
}

impl BrickFace {
    /// All faces, in the order of their numbers 0…5.
    pub const ALL: [Self; 6] = [
        Self::XMin,
        Self::XMax,
        Self::YMin,
        Self::YMax,
        Self::ZMin,
        Self::ZMax,
    ];

    /// The names used in scene files.
    pub const NAMES: [&str; 6] = ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"];

    /// The face of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let place = Self::NAMES.iter().position(|n| *n == name)?;
        Some(Self::ALL[place])
    }

    /// The coordinate axis the face is perpendicular to (0, 1, 2).
    #[must_use]
    pub fn axis(self) -> usize {
        self as usize / 2
    }

    /// Whether the face lies at the upper end of its axis.
    #[must_use]
    pub fn is_max(self) -> bool {
        self as usize % 2 == 1
    }
}

/// The share of an edge below plane i of n where cells shrink with exponents p and q towards its ends.
///
/// The regularised incomplete beta function I(i/n; p, q) (DLMF 8.17.2): the cells per length go with
/// s^(1−p) (1 − s)^(1−q), so their widths have no jump anywhere. Equal cells and one graded end, where it is a
/// power, are not left to a series, so they have the bits of that power.
#[must_use]
pub(super) fn graded_share(i: usize, n: usize, exponents: [f64; 2]) -> f64 {
    let below = i as f64 / n as f64;
    let above = (n - i) as f64 / n as f64;
    let [p, q] = exponents;
    match (p == 1.0, q == 1.0) {
        (true, true) => below,
        (false, true) => below.powf(p),
        (true, false) => 1.0 - above.powf(q),
        (false, false) if 2 * i <= n => integral(below, p, q) / whole(p, q),
        (false, false) => 1.0 - integral(above, q, p) / whole(p, q),
    }
}

/// B(1; p, q), both halves by the series where it converges fast.
fn whole(p: f64, q: f64) -> f64 {
    integral(0.5, p, q) + integral(0.5, q, p)
}

/// B(s; p, q) = ∫₀ˢ tᵖ⁻¹ (1 − t)^(q−1) dt for 0 ≤ s ≤ ½ and p, q ≥ 1, by the series of positive terms
/// sᵖ (1 − s)^q / p · (1 + Σₖ s^(k+1) Πⱼ₌₀ᵏ (p + q + j)/(p + 1 + j)) (DLMF 8.17.8).
fn integral(s: f64, p: f64, q: f64) -> f64 {
    let (mut sum, mut term, mut j) = (1.0, 1.0, 0.0);
    // Terms grow at most once and then fall, at last by the factor s.
    while term > 0.1 * f64::EPSILON * sum {
        term *= s * (p + q + j) / (p + 1.0 + j);
        sum += term;
        j += 1.0;
    }
    s.powf(p) * (1.0 - s).powf(q) / p * sum
}

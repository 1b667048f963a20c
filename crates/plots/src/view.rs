//! The oblique view of the body: stretched axes t₁, t₂, −ν, parallel projection.

use super::canvas::Point;
use super::layout::stretch_factor;
use super::picture::ContactPicture;
use super::vector::{Vector, bounds, cross, dot, unit};

/// From the body to the viewer, in the basis (t₁, −ν × t₁, −ν): in front, a little to the right and
/// above.
const TOWARD: Vector = [0.34, -0.84, 0.42];

/// Bodies that are longer than this many times their width or height are stretched across.
const MOST_SLENDER: f64 = 25.0;

/// Maps points of the body to the view, x to the right, y upwards, z towards the viewer.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// t₁, −ν × t₁ and −ν.
    pub(super) basis: [Vector; 3],
    /// Stretch along the basis vectors; all 1 unless the body is very slender.
    pub(super) stretch: [f64; 3],
    screen: [Vector; 3],
}

impl View {
    /// The view of the undeformed body.
    pub(super) fn new(picture: &ContactPicture<'_>) -> Self {
        let first = unit(picture.axis_1);
        let up = unit(picture.normal.map(|component| -component));
        let basis = [first, cross(up, first), up];
        let nodes = || picture.boundary_triangles.as_flattened().iter();
        let extents = basis.map(|axis| {
            let (low, high) = bounds(nodes().map(|&node| dot(axis, picture.coordinates[node])));
            high - low
        });
        let longest = extents.into_iter().fold(0.0, f64::max);
        let stretch = extents.map(|extent| {
            if extent > 0.0 {
                stretch_factor(longest / extent, MOST_SLENDER)
            } else {
                1.0
            }
        });
        let toward = unit(TOWARD);
        let right = unit(cross([0.0, 0.0, 1.0], toward));
        Self {
            basis,
            stretch,
            screen: [right, cross(toward, right), toward],
        }
    }

    /// A position or displacement in the stretched basis.
    pub(super) fn stretched(&self, vector: Vector) -> Vector {
        [0, 1, 2].map(|axis| self.stretch[axis] * dot(self.basis[axis], vector))
    }

    /// A direction in the basis, not stretched.
    pub(super) fn turned(&self, vector: Vector) -> Vector {
        self.basis.map(|axis| dot(axis, vector))
    }

    /// View coordinates of a vector in the stretched basis.
    pub(super) fn projected(&self, vector: Vector) -> Vector {
        self.screen.map(|axis| dot(axis, vector))
    }

    /// Unit vector to the viewer in the stretched basis.
    pub(super) fn toward(&self) -> Vector {
        self.screen[2]
    }
}

/// Scales view coordinates into a rectangle of the canvas.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    scale: f64,
    centre: Point,
    target: Point,
}

impl Fit {
    /// The largest scale at which all `points` lie in the rectangle.
    pub(super) fn new(
        points: impl Iterator<Item = Vector> + Clone,
        corner: Point,
        size: Point,
    ) -> Self {
        let (left, right) = bounds(points.clone().map(|p| p[0]));
        let (bottom, top) = bounds(points.map(|p| p[1]));
        let scale = (size[0] / (right - left)).min(size[1] / (top - bottom));
        Self {
            scale: if scale.is_finite() { scale } else { 1.0 },
            centre: [left.midpoint(right), bottom.midpoint(top)],
            target: [corner[0] + size[0] / 2.0, corner[1] + size[1] / 2.0],
        }
    }

    /// Pixel of a point in view coordinates.
    pub(super) fn pixel(&self, point: Vector) -> Point {
        [
            self.target[0] + self.scale * (point[0] - self.centre[0]),
            self.target[1] - self.scale * (point[1] - self.centre[1]),
        ]
    }
}

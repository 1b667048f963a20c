//! The oblique view of the body: stretched axes t₁, t₂, −ν and parallel projection.

use super::{canvas::Point, layout::stretch_factor, picture::ContactPicture, scale::bounds};

/// From the body to the viewer, in the basis (t₁, −ν × t₁, −ν): in front, a little to the right and
/// above.
pub(super) const TOWARD: Vector = [0.34, -0.84, 0.42];

/// The cosine, of 37 degrees, below which an axis and a normal are two directions.
const NEARLY_ALONG: f64 = 0.8;

/// Maps points of the body to the view, x to the right, y upwards, z towards the viewer.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// t₁, −ν × t₁ and −ν; with ν for −ν where z would point down.
    pub(super) basis: [Vector; 3],
    /// Stretch along the basis vectors; all 1 unless the body is very slender.
    pub(super) stretch: [f64; 3],
    screen: [Vector; 3],
}

impl View {
    /// The view of the undeformed body from a direction in the basis (t₁, −ν × t₁, −ν).
    pub(super) fn new(picture: &ContactPicture<'_>, toward: Vector) -> Self {
        let first = unit(picture.axis_1);
        let away = unit(picture.normal.map(|component| -component));
        // A body below what it touches hangs from the contact face: z stays up.
        let up = if picture.is_contact_above() {
            away.map(|component| -component)
        } else {
            away
        };
        // A face that is nearly level or plumb hangs or stands as the coordinate axis does.
        let upright = [0, 1, 2]
            .into_iter()
            .find(|&axis| up[axis].abs() > NEARLY_ALONG);
        let (first, up) = match upright {
            None => (first, up),
            Some(axis) => {
                let mut along = [0.0; 3];
                along[axis] = up[axis].signum();
                let flat = [0, 1, 2].map(|c| first[c] - dot(first, along) * along[c]);
                (unit(flat), along)
            }
        };
        let basis = [first, cross(up, first), up];
        let nodes = picture.boundary_triangles.as_flattened().iter();
        Self::of(basis, nodes.map(|&node| picture.coordinates[node]), toward)
    }

    /// The view of points from a direction in a basis.
    pub(super) fn of(
        basis: [Vector; 3],
        points: impl Iterator<Item = Vector> + Clone,
        toward: Vector,
    ) -> Self {
        let extents = basis.map(|axis| {
            let (low, high) = bounds(points.clone().map(|point| dot(axis, point)));
            high - low
        });
        let longest = extents.into_iter().fold(0.0, f64::max);
        let stretch = extents.map(|extent| {
            if extent > 0.0 {
                // Bodies that are longer than this many times their width or height are stretched across.
                stretch_factor(longest / extent, 25.0)
            } else {
                1.0
            }
        });
        let toward = unit(toward);
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

/// A vector of ℝ³.
pub(super) type Vector = [f64; 3];

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn scaled(a: Vector, factor: f64) -> Vector {
    a.map(|component| factor * component)
}

pub(super) fn norm(a: Vector) -> f64 {
    a[0].hypot(a[1]).hypot(a[2])
}

/// `a` divided by its length; the zero vector stays.
pub(super) fn unit(a: Vector) -> Vector {
    let length = norm(a);
    if length > 0.0 {
        scaled(a, 1.0 / length)
    } else {
        a
    }
}

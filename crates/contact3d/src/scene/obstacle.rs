//! The rigid obstacle that a contact face may touch.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    Measure, Quantity, is_default,
    varying::{Varies, Varying, VaryingKey, varies},
};

/// A rigid obstacle, which does not move.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(extend("examples" = ["contact.obstacle.sphere = { centre = [0.0, 0.0, -1.0], radius = 1.0 }"]))]
pub enum Obstacle {
    /// All points on one side of a plane.
    HalfSpace(HalfSpace),
    /// A ball, or what surrounds one.
    Sphere(Sphere),
    /// A circular cylinder without ends, or what surrounds one.
    Cylinder(Cylinder),
    /// What lies behind a surface that is a function of two coordinates.
    Height(Height),
    /// A surface of triangles from a file.
    Surface(SurfaceFile),
}

/// The points x with (x − point)·normal ≤ 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfSpace {
    /// A point of the plane in m.
    #[schemars(extend("measures" = Measure::Length))]
    pub point: [f64; 3],
    /// Normal of the plane, of any length; it points out of the obstacle, towards the body.
    pub normal: [f64; 3],
}

/// A ball, or a cup.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    /// Centre in m.
    #[schemars(extend("measures" = Measure::Length))]
    pub centre: [f64; 3],
    /// Radius > 0 in m; side = "inside" makes the hollow the obstacle.
    #[schemars(extend("measures" = Measure::Length, "exclusiveMinimum" = 0))]
    pub radius: f64,
    /// Where the body is.
    #[serde(default, skip_serializing_if = "is_default")]
    pub side: Side,
}

/// A rod, or a bore.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// A point of the axis in m.
    #[schemars(extend("measures" = Measure::Length))]
    pub point: [f64; 3],
    /// Direction of the axis, of any length.
    pub direction: [f64; 3],
    /// Radius > 0 in m; side = "inside" makes the hollow the obstacle.
    #[schemars(extend("measures" = Measure::Length, "exclusiveMinimum" = 0))]
    pub radius: f64,
    /// Where the body is.
    #[serde(default, skip_serializing_if = "is_default")]
    pub side: Side,
}

/// The side of a round obstacle on which the body is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Outside: the obstacle is the ball or the rod.
    #[default]
    Outside,
    /// Inside: the obstacle is the cup or the bore around it.
    Inside,
}

/// The points behind a surface: z ≤ h(x, y) for the direction z, z ≥ h(x, y) for −z, and so on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Height {
    /// The coordinate h of the surface along the axis of `direction` in m: a number, or an expression in the two other
    /// coordinates.
    #[schemars(extend("measures" = Measure::Length))]
    pub value: Quantity,
    /// From the obstacle to the body.
    #[serde(default, skip_serializing_if = "is_default")]
    pub direction: Direction,
}

/// A coordinate axis with a sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub enum Direction {
    /// Along x.
    #[serde(rename = "x")]
    X,
    /// Against x.
    #[serde(rename = "-x")]
    MinusX,
    /// Along y.
    #[serde(rename = "y")]
    Y,
    /// Against y.
    #[serde(rename = "-y")]
    MinusY,
    /// Along z.
    #[default]
    #[serde(rename = "z")]
    Z,
    /// Against z.
    #[serde(rename = "-z")]
    MinusZ,
}

/// Triangles of an STL file, text or binary, or of a mesh of Gmsh, whose corners go counter-clockwise as seen from the body: out of the
/// tetrahedra of a mesh that has them there. A point x of the file lies at `origin` + R(`unit` x) with the rotation R by `turn`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceFile {
    /// Path of the .stl or .msh file, relative to the scene file.
    pub file: PathBuf,
    /// The physical surface of a mesh; all triangles of the file when not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face: Option<String>,
    /// Length > 0 of the file's unit in m, which an STL does not say: 0.001 for a file in millimetres and a scene in metres.
    #[serde(default = "one")]
    #[schemars(extend("measures" = Measure::Length, "exclusiveMinimum" = 0))]
    pub unit: f64,
    /// The place in m of the origin of the file's coordinates.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("measures" = Measure::Length))]
    pub origin: [f64; 3],
    /// The rotation vector in radians, of any size, by which the surface is turned about that origin.
    #[serde(default, skip_serializing_if = "is_default")]
    pub turn: [f64; 3],
    /// Angle in degrees from which on the edge between two triangles is sharp; triangles that meet at less are facets of a smooth surface.
    #[serde(default = "thirty")]
    #[schemars(extend("minimum" = 0, "maximum" = 180))]
    pub sharp_angle: f64,
    /// BLAKE3 digest of the file. Filled in when the mesh is made; a scene that gives it is sure to use that very file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digest: Option<String>,
}

fn one() -> f64 {
    1.0
}

fn thirty() -> f64 {
    30.0
}

varies!(Height: value);

impl Varies for Obstacle {
    fn add_varying<'s>(&'s mut self, at: &VaryingKey, found: &mut Vec<(VaryingKey, Varying<'s>)>) {
        let at = at.below(self.word());
        match self {
            Self::Height(height) => height.add_varying(&at, found),
            Self::HalfSpace(_) | Self::Sphere(_) | Self::Cylinder(_) | Self::Surface(_) => {}
        }
    }
}

impl Side {
    /// 1 outside, −1 inside.
    #[must_use]
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Outside => 1.0,
            Self::Inside => -1.0,
        }
    }
}

impl Direction {
    /// The place of the coordinate, 0, 1 or 2, and the sign.
    #[must_use]
    pub fn axis(self) -> (usize, f64) {
        match self {
            Self::X => (0, 1.0),
            Self::MinusX => (0, -1.0),
            Self::Y => (1, 1.0),
            Self::MinusY => (1, -1.0),
            Self::Z => (2, 1.0),
            Self::MinusZ => (2, -1.0),
        }
    }
}

impl Obstacle {
    /// Its key in a scene.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::HalfSpace(_) => "half_space",
            Self::Sphere(_) => "sphere",
            Self::Cylinder(_) => "cylinder",
            Self::Height(_) => "height",
            Self::Surface(_) => "surface",
        }
    }
}

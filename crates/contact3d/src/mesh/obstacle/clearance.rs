//! Signed distance from an obstacle, and its gradient.

use nalgebra::Vector3;

use super::height::Graph;
use crate::scene::{InvalidValue, Obstacle, Side, place_words};

/// Where a point is as seen from an obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Clearance {
    /// Signed distance φ from the obstacle in m, positive outside it.
    pub(super) distance: f64,
    /// ∇φ, a unit vector: the normal of the obstacle, out of it, at the nearest point of its surface.
    pub(super) away: Vector3<f64>,
}

/// An obstacle that points can be measured from.
pub(super) enum Measured<'a> {
    Plane {
        point: Vector3<f64>,
        away: Vector3<f64>,
    },
    Round {
        centre: Vector3<f64>,
        /// Direction of the axis; zero for a sphere.
        axis: Vector3<f64>,
        radius: f64,
        side: Side,
    },
    Graph(Graph<'a>),
}

impl<'a> Measured<'a> {
    /// An obstacle of a validated scene; `extent` in m is that of the face that it is near.
    pub(super) fn new(obstacle: &'a Obstacle, extent: f64) -> Self {
        let unit = |v: &[f64; 3]| {
            // Squares of very large or small components would overflow or vanish.
            let v = Vector3::from(*v);
            (v / v.amax()).normalize()
        };
        match obstacle {
            Obstacle::HalfSpace(half) => Self::Plane {
                point: half.point.into(),
                away: unit(&half.normal),
            },
            Obstacle::Sphere(sphere) => Self::Round {
                centre: sphere.centre.into(),
                axis: Vector3::zeros(),
                radius: sphere.radius,
                side: sphere.side,
            },
            Obstacle::Cylinder(cylinder) => Self::Round {
                centre: cylinder.point.into(),
                axis: unit(&cylinder.direction),
                radius: cylinder.radius,
                side: cylinder.side,
            },
            Obstacle::Height(height) => Self::Graph(Graph::new(height, extent)),
        }
    }

    /// φ and ∇φ at a point.
    ///
    /// # Errors
    /// A centre or an axis, where ∇φ has no direction; a height without a nearest point.
    pub(super) fn from(&self, at: [f64; 3]) -> Result<Clearance, InvalidValue> {
        let x = Vector3::from(at);
        match self {
            Self::Plane { point, away } => Ok(Clearance {
                distance: (x - point).dot(away),
                away: *away,
            }),
            Self::Round {
                centre,
                axis,
                radius,
                side,
            } => {
                let from_centre = x - centre;
                let across = from_centre - axis * from_centre.dot(axis);
                let distance = across.norm();
                let Some(outward) = across.try_normalize(f64::EPSILON * radius) else {
                    return Err(no_direction(at));
                };
                Ok(Clearance {
                    distance: side.sign() * (distance - radius),
                    away: outward * side.sign(),
                })
            }
            Self::Graph(graph) => graph.from(at),
        }
    }

    /// Whether ∇φ is the same everywhere.
    pub(super) fn is_flat(&self) -> bool {
        match self {
            Self::Plane { .. } => true,
            Self::Round { .. } => false,
            Self::Graph(graph) => graph.is_level(),
        }
    }
}

fn no_direction(at: [f64; 3]) -> InvalidValue {
    InvalidValue {
        key: "contact.obstacle".into(),
        expected: "contact nodes away from the centre or axis of the obstacle".into(),
        found: format!("one there, at {}", place_words(at)),
        help: "the obstacle has no normal there; move it or make it larger".into(),
    }
}

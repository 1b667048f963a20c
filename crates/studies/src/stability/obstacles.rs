//! Obstacles as other descriptions of a problem see them.

use super::{Symmetry, UnitChange};
use contact3d::scene::{Cylinder, HalfSpace, Height, Obstacle, Sphere};

impl UnitChange {
    /// An obstacle in other units of length.
    pub(super) fn obstacle(&self, obstacle: &Obstacle) -> Obstacle {
        let place = |at: [f64; 3]| at.map(|x| x * self.length);
        match obstacle {
            Obstacle::HalfSpace(half) => Obstacle::HalfSpace(HalfSpace {
                point: place(half.point),
                ..*half
            }),
            Obstacle::Sphere(sphere) => Obstacle::Sphere(Sphere {
                centre: place(sphere.centre),
                radius: sphere.radius * self.length,
                ..*sphere
            }),
            Obstacle::Cylinder(cylinder) => Obstacle::Cylinder(Cylinder {
                point: place(cylinder.point),
                radius: cylinder.radius * self.length,
                ..*cylinder
            }),
            Obstacle::Height(height) => Obstacle::Height(Height {
                value: self.quantity(&height.value, self.length),
                direction: height.direction,
            }),
        }
    }
}

impl Symmetry {
    /// The image of an obstacle of a brick of this width; `None` for heights along x and y, whose formulas have no
    /// image as they are.
    pub(super) fn obstacle(self, obstacle: &Obstacle, width: f64) -> Option<Obstacle> {
        let place = |at: [f64; 3]| self.point(at, width);
        let along = |[x, y, z]: [f64; 3]| match self {
            Self::Mirror => [x, -y, z],
            Self::Exchange => [y, x, z],
        };
        Some(match obstacle {
            Obstacle::HalfSpace(half) => Obstacle::HalfSpace(HalfSpace {
                point: place(half.point),
                normal: along(half.normal),
            }),
            Obstacle::Sphere(sphere) => Obstacle::Sphere(Sphere {
                centre: place(sphere.centre),
                ..*sphere
            }),
            Obstacle::Cylinder(cylinder) => Obstacle::Cylinder(Cylinder {
                point: place(cylinder.point),
                direction: along(cylinder.direction),
                ..*cylinder
            }),
            Obstacle::Height(height) if height.direction.axis().0 == 2 => {
                Obstacle::Height(Height {
                    value: self.quantity(&height.value, width, false),
                    direction: height.direction,
                })
            }
            Obstacle::Height(_) => return None,
        })
    }
}

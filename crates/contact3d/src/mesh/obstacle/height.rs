//! Distance from the surface of a height z = h(x, y).

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Vector2, Vector3};

use super::{TOUCHING, facing};
use crate::{
    linalg::UNIT_ROUNDING,
    scene::{Height, InvalidValue, Quantity, UNDEFINED, Written, place_words},
};

/// Where a point is as seen from an obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Clearance {
    /// Signed distance φ from the obstacle in m, positive outside it.
    pub(super) distance: f64,
    /// ∇φ, a unit vector: the normal of the obstacle, out of it, at the nearest point of its surface.
    pub(super) away: Vector3<f64>,
}

/// Fraction of the face over which slopes of h are compared for the second derivatives that only guide the steps.
const SLOPE_STEP: f64 = 1e-5;

/// The surface x_k = h(x_i, x_j), with free space on one side.
pub(super) struct Graph<'a> {
    height: &'a Quantity,
    /// The coordinates i and j of h, and k that of the height.
    plane: [usize; 2],
    along: usize,
    sign: f64,
    /// Extent of the contact face in m.
    extent: f64,
}

/// A point of the surface with ∇h and half the squared distance from it.
struct Foot {
    at: Vector2<f64>,
    height: f64,
    slope: Vector2<f64>,
    half_square: f64,
}

impl<'a> Graph<'a> {
    pub(super) fn new(height: &'a Height, extent: f64) -> Self {
        let (along, sign) = height.direction.axis();
        let plane = match along {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        };
        Self {
            height: &height.value,
            plane,
            along,
            sign,
            extent,
        }
    }

    pub(super) fn is_level(&self) -> bool {
        self.height.constant().is_some()
    }

    /// φ and ∇φ for a body with an outward normal, which may be zero: where rounding chooses a side of a kink, those of the side that
    /// [faces](facing) the body.
    pub(super) fn from(
        &self,
        at: [f64; 3],
        outward: &Vector3<f64>,
    ) -> Result<Clearance, InvalidValue> {
        let found = self.nearest(at);
        if found.is_ok() && *outward == Vector3::zeros() {
            return found;
        }
        let sides = self.sides(at);
        let Some(one) = sides.first() else {
            return found;
        };
        let radius = SLOPE_STEP * self.extent;
        let touches = |side: &Clearance| side.distance.abs() <= 2.0 * radius;
        let turns = |side: &Clearance| (side.away - one.away).norm() > TOUCHING.sqrt();
        match found {
            Err(_) if sides.iter().all(touches) => Ok(facing(*one, &sides, outward, 4.0 * radius)),
            Ok(first) if sides.iter().any(turns) => {
                Ok(facing(first, &sides, outward, TOUCHING * self.extent))
            }
            found => found,
        }
    }

    /// The tangent planes of the surface around the place over or under a point.
    fn sides(&self, at: [f64; 3]) -> Vec<Clearance> {
        let [i, j] = self.plane;
        let (point, level) = (Vector2::new(at[i], at[j]), at[self.along]);
        let radius = SLOPE_STEP * self.extent;
        // Between the axes and the diagonals, along which formulas mostly have their kinks.
        let turns = (0..8).map(|k| (f64::from(k) + 0.5) * TAU / 8.0);
        let around = turns.map(|turn| point + Vector2::new(turn.cos(), turn.sin()) * radius);
        let feet = around.filter_map(|near| self.foot(near, point, level).ok());
        feet.map(|foot| self.clearance(&foot, point, level))
            .collect()
    }

    /// φ and ∇φ from the nearest point of the surface.
    ///
    /// With q the foot and p the point, (p − q) is normal to the surface: q_i − p_i + (h(q) − p_k) ∂_i h = 0, which
    /// Newton's method solves from below or above p, going nearer with every step.
    fn nearest(&self, at: [f64; 3]) -> Result<Clearance, InvalidValue> {
        let [i, j] = self.plane;
        let (point, level) = (Vector2::new(at[i], at[j]), at[self.along]);
        let mut foot = self.foot(point, point, level)?;
        // Quadratic once near, and from afar each step at least halves the slope of the squared distance or the step.
        for _ in 0..100 {
            let above = foot.height - level;
            let residual = foot.at - point + foot.slope * above;
            let size = (2.0 * foot.half_square).sqrt() + self.extent + point.amax() + level.abs();
            if residual.norm() <= UNIT_ROUNDING * size * (1.0 + foot.slope.norm()) {
                return Ok(self.clearance(&foot, point, level));
            }
            let step = self.step(&foot, above, residual);
            let Some(next) = self.nearer(&foot, step, point, level)? else {
                break;
            };
            foot = next;
        }
        if let Some(clearance) = self.beyond_kink(&foot, point, level) {
            return Ok(clearance);
        }
        Err(InvalidValue {
            key: "contact.obstacle.height.value".into(),
            expected: "a smooth surface with a nearest point for every contact node".into(),
            found: format!("none for {}", place_words(at)),
            help: "steep steps and edges have no normal where they touch; smooth the formula, or give the surface by other coordinates".into(),
        })
    }

    /// φ and ∇φ where the nearest point is a kink such as the apex of a cone: that way the point sees it. `None` where the
    /// point lies on the kink, or some place around is nearer.
    fn beyond_kink(&self, foot: &Foot, point: Vector2<f64>, level: f64) -> Option<Clearance> {
        let radius = SLOPE_STEP * self.extent;
        let away = |turn: f64| Vector2::new(turn.cos(), turn.sin()) * radius;
        let turns = (0..32).map(|k| f64::from(k) * TAU / 32.0);
        let least = foot.half_square - self.rounding(foot, point, level);
        for turn in turns {
            let around = self.foot(foot.at + away(turn), point, level).ok()?;
            if around.half_square < least {
                return None;
            }
        }
        let offset = Vector3::from(self.place(point - foot.at, level - foot.height));
        let side = self.sign * offset[self.along].signum();
        let away = offset.try_normalize(radius)? * side;
        Some(Clearance {
            distance: side * offset.norm(),
            away,
        })
    }

    /// The step of Newton's method, or where that would lead away of Gauss and Newton's, without second derivatives.
    fn step(&self, foot: &Foot, above: f64, residual: Vector2<f64>) -> Vector2<f64> {
        let flat = Matrix2::identity() + foot.slope * foot.slope.transpose();
        let matrix = flat + self.curvature(foot.at) * above;
        let positive = matrix.determinant() > 0.0 && matrix.trace() > 0.0;
        let inverse = matrix.try_inverse().filter(|_| positive);
        let inverse = inverse.or_else(|| flat.try_inverse());
        -(inverse.unwrap_or_else(Matrix2::identity) * residual)
    }

    /// The first of halved steps that comes nearer to the point, or stands still to rounding; `None` for none.
    fn nearer(
        &self,
        foot: &Foot,
        step: Vector2<f64>,
        point: Vector2<f64>,
        level: f64,
    ) -> Result<Option<Foot>, InvalidValue> {
        let mut share = 1.0;
        for _ in 0..40 {
            let next = self.foot(foot.at + step * share, point, level);
            // A long step may leave the domain of h.
            if let Ok(next) = next
                && next.half_square <= foot.half_square + self.rounding(foot, point, level)
            {
                return Ok(Some(next));
            }
            share /= 2.0;
        }
        Ok(None)
    }

    /// What rounding makes of half the squared distance: that of the coordinates in a formula of some terms, times the distance.
    fn rounding(&self, foot: &Foot, point: Vector2<f64>, level: f64) -> f64 {
        let coordinates = self.extent + point.amax() + level.abs() + foot.height.abs();
        let rounding = 64.0 * f64::EPSILON * coordinates;
        rounding * ((2.0 * foot.half_square).sqrt() + rounding)
    }

    fn foot(
        &self,
        at: Vector2<f64>,
        point: Vector2<f64>,
        level: f64,
    ) -> Result<Foot, InvalidValue> {
        let height = self.height.at(self.place(at, level));
        if !height.is_finite() {
            return Err(InvalidValue {
                key: "contact.obstacle.height.value".into(),
                expected: "a finite height near every contact node".into(),
                found: format!(
                    "{} at {}",
                    Written(&height),
                    place_words(self.place(at, level))
                ),
                help: UNDEFINED.into(),
            });
        }
        Ok(Foot {
            at,
            height,
            slope: self.slope(at),
            half_square: 0.5 * ((at - point).norm_squared() + (height - level).powi(2)),
        })
    }

    fn clearance(&self, foot: &Foot, point: Vector2<f64>, level: f64) -> Clearance {
        let away = Vector3::from(self.place(-foot.slope, 1.0)).normalize() * self.sign;
        let offset = Vector3::from(self.place(point - foot.at, level - foot.height));
        Clearance {
            distance: offset.dot(&away),
            away,
        }
    }

    /// ∇h.
    fn slope(&self, at: Vector2<f64>) -> Vector2<f64> {
        let gradient = self.height.gradient(self.place(at, 0.0));
        Vector2::new(gradient[self.plane[0]], gradient[self.plane[1]])
    }

    /// The second derivatives of h, by differences of its slopes.
    fn curvature(&self, at: Vector2<f64>) -> Matrix2<f64> {
        let step = SLOPE_STEP * self.extent;
        let column = |direction: Vector2<f64>| {
            (self.slope(at + direction) - self.slope(at - direction)) / (2.0 * step)
        };
        let columns = [
            column(Vector2::new(step, 0.0)),
            column(Vector2::new(0.0, step)),
        ];
        let matrix = Matrix2::from_columns(&columns);
        let symmetric = (matrix + matrix.transpose()) / 2.0;
        if symmetric.iter().all(|v| v.is_finite()) {
            symmetric
        } else {
            Matrix2::zeros()
        }
    }

    fn place(&self, at: Vector2<f64>, level: f64) -> [f64; 3] {
        let mut place = [0.0; 3];
        place[self.plane[0]] = at.x;
        place[self.plane[1]] = at.y;
        place[self.along] = level;
        place
    }
}

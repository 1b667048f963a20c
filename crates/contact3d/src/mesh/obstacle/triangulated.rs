//! Distance from a rigid surface of triangles, which stand for a smooth surface where they meet at small angles.
//!
//! Each corner of a triangle has a normal: the mean of those of the triangles around it that smooth edges join to it, each weighted by its
//! area over the squares of its two edges there, which is exact for corners on a sphere (N. Max, *J. Graphics Tools* 4 (1999) 1). With
//! barycentric coordinates λ a point x before the surface is Σ_a λ_a (x_a + D n_a): its normal is n(λ) = Σ λ_a n_a, and its distance
//! D|n(λ)| less what the smooth surface lies above the triangle, ½ Σ_{a<b} λ_a λ_b (x_b − x_a)·(n_b − n_a) (T. Nagata, *Comput. Aided Geom.
//! Design* 22 (2005) 327). Both are continuous where smooth edges are, and of a sphere the distance is exact to the fourth order in the
//! edges. Where no triangle has such a point, beyond sharp edges, the distance is that from the triangles themselves, with the sign by the
//! pseudonormal of the nearest edge or corner (J. A. Bærentzen, H. Aanæs, *IEEE Trans. Vis. Comput. Graph.* 11 (2005) 243).

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};
use rstar::{
    AABB, RTree,
    primitives::{GeomWithData, Rectangle},
};

use super::{Clearance, TOUCHING, facing};
use crate::{
    linalg::UNIT_ROUNDING,
    mesh::GEOMETRY_TOLERANCE,
    reference::TRIANGLE_EDGES,
    scene::{InvalidValue, place_words},
};

/// Triangles whose corners go counter-clockwise as seen from the body.
#[derive(Debug, Clone)]
pub struct TriangulatedSurface {
    /// Corners in m, `[n_points]`.
    pub points: Vec<[f64; 3]>,
    /// Corners of each triangle, `[n_triangles]`.
    pub triangles: Vec<[usize; 3]>,
    /// Unit normal at each corner of each triangle, out of the obstacle, `[n_triangles]`.
    pub normals: Vec<[[f64; 3]; 3]>,
    /// Triangles around each point.
    pub(super) around: Vec<Vec<usize>>,
    pub(super) tree: RTree<GeomWithData<Rectangle<[f64; 3]>, usize>>,
}

impl PartialEq for TriangulatedSurface {
    fn eq(&self, other: &Self) -> bool {
        self.points == other.points
            && self.triangles == other.triangles
            && self.normals == other.normals
    }
}

impl TriangulatedSurface {
    /// The surface of some points in m, triangles of them and unit normals at their corners.
    #[must_use]
    pub fn new(
        points: Vec<[f64; 3]>,
        triangles: Vec<[usize; 3]>,
        normals: Vec<[[f64; 3]; 3]>,
    ) -> Self {
        let boxes = triangles.iter().enumerate().map(|(number, corners)| {
            let corners = corners.map(|point| points[point]);
            GeomWithData::new(Rectangle::from_aabb(AABB::from_points(&corners)), number)
        });
        Self {
            tree: RTree::bulk_load(boxes.collect()),
            around: around(points.len(), &triangles),
            points,
            triangles,
            normals,
        }
    }

    /// φ and ∇φ at a place of a body with an outward normal there, which may be zero.
    ///
    /// # Errors
    /// A place beyond the border of an open surface.
    pub(super) fn from(
        &self,
        at: [f64; 3],
        outward: &Vector3<f64>,
    ) -> Result<Clearance, InvalidValue> {
        let x = Vector3::from(at);
        let (nearest, share) = self.nearest(&x);
        let foot = self.at_share(nearest, &share);
        let mut beside: Vec<usize> = self.triangles[nearest]
            .iter()
            .flat_map(|point| self.around[*point].iter().copied())
            .collect();
        beside.sort_unstable();
        beside.dedup();
        let before: Vec<Clearance> = beside
            .into_iter()
            .filter_map(|triangle| self.before(triangle, &x, (x - foot).norm()))
            .collect();
        let first = before
            .iter()
            .min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()));
        let Some(first) = first else {
            return self.beyond_edge(nearest, share, &(x - foot), at);
        };
        let corners = self.corners(nearest);
        let digits = TOUCHING * (corners[1] - corners[0]).norm();
        Ok(facing(*first, &before, outward, digits))
    }

    /// Whether normals are the same everywhere.
    pub(super) fn is_flat(&self) -> bool {
        let first = Vector3::from(self.normals[0][0]);
        let mut normals = self.normals.iter().flatten();
        normals.all(|n| (Vector3::from(*n) - first).amax() <= 16.0 * UNIT_ROUNDING)
    }

    pub(super) fn corners(&self, triangle: usize) -> [Vector3<f64>; 3] {
        self.triangles[triangle].map(|point| self.points[point].into())
    }

    fn at_share(&self, triangle: usize, share: &[f64; 3]) -> Vector3<f64> {
        let corners = self.corners(triangle).into_iter().zip(share);
        corners.map(|(x, share)| x * *share).sum()
    }

    /// The triangle nearest to a place, and the barycentric coordinates of its point there.
    fn nearest(&self, x: &Vector3<f64>) -> (usize, [f64; 3]) {
        let (mut nearest, mut least) = ((0, [1.0, 0.0, 0.0]), f64::INFINITY);
        let boxes = self.tree.nearest_neighbor_iter_with_distance_2((*x).into());
        for (item, square_to_box) in boxes {
            if square_to_box > least {
                break;
            }
            let share = nearest_share(&self.corners(item.data), x);
            let square = (self.at_share(item.data, &share) - x).norm_squared();
            if square < least || square == least && item.data < nearest.0 {
                (nearest, least) = ((item.data, share), square);
            }
        }
        nearest
    }

    /// φ and ∇φ where x = Σ λ_a (x_a + D n_a) with λ ≥ 0, by Newton's method, which on a plane ends after one step; `None` without.
    fn before(&self, triangle: usize, x: &Vector3<f64>, away: f64) -> Option<Clearance> {
        let [a, b, c] = self.corners(triangle);
        let normals = self.normals[triangle].map(Vector3::from);
        let (ab, ac) = (b - a, c - a);
        let plane = ab.cross(&ac).normalize();
        let mut distance = (x - a).dot(&plane);
        let mut share = [0.0; 3];
        let mut from = f64::INFINITY;
        for _ in 0..20 {
            let columns = [1, 2].map(|k| normals[k] - normals[0]);
            let (u, v) = (ab + columns[0] * distance, ac + columns[1] * distance);
            let n: Vector3<f64> = match from {
                f64::INFINITY => plane,
                _ => normals.iter().zip(share).map(|(n, share)| n * share).sum(),
            };
            let residual = x - a - normals[0] * distance;
            // At the present D the equation is linear in λ but for its part along n, which tells D.
            let step = Matrix3::from_columns(&[u, v, n]).try_inverse()? * residual;
            share = [1.0 - step[0] - step[1], step[0], step[1]];
            distance += step[2];
            let size = away + ab.norm() + ac.norm();
            if step[2].abs() <= 4.0 * UNIT_ROUNDING * size
                || step[2].abs() >= from && from < 1e-9 * size
            {
                return self.clearance(triangle, share, distance, away);
            }
            from = step[2].abs();
        }
        None
    }

    fn clearance(
        &self,
        triangle: usize,
        share: [f64; 3],
        distance: f64,
        away: f64,
    ) -> Option<Clearance> {
        let corners = self.corners(triangle);
        let normals = self.normals[triangle].map(Vector3::from);
        let longest = (0..3).map(|k| (corners[k] - corners[(k + 1) % 3]).norm());
        let longest = longest.fold(0.0, f64::max);
        let is_other_sheet = (distance.abs() - away).abs() > longest;
        if share.iter().any(|share| *share < -GEOMETRY_TOLERANCE) || is_other_sheet {
            return None;
        }
        let normal: Vector3<f64> = normals.iter().zip(share).map(|(n, share)| n * share).sum();
        let above = beyond_straight(&corners, &normals, &share);
        let length = normal.norm();
        Some(Clearance {
            distance: distance * length - above,
            away: normal / length,
        })
    }

    /// φ and ∇φ from the nearest edge or corner of the triangles.
    fn beyond_edge(
        &self,
        triangle: usize,
        share: [f64; 3],
        offset: &Vector3<f64>,
        at: [f64; 3],
    ) -> Result<Clearance, InvalidValue> {
        let on: Vec<usize> = (0..3).filter(|k| share[*k] > 0.0).collect();
        let points = on.iter().map(|k| self.triangles[triangle][*k]);
        let points: Vec<usize> = points.collect();
        let holds = |t: &usize| {
            points
                .iter()
                .all(|point| self.triangles[*t].contains(point))
        };
        let meeting = self.around[points[0]].iter().copied().filter(holds);
        let meeting: Vec<usize> = meeting.collect();
        let is_border = match points[..] {
            [_, _] => meeting.len() == 1,
            [point] => self.is_on_border(point),
            _ => false,
        };
        if is_border {
            return Err(InvalidValue {
                key: "contact.obstacle.surface".into(),
                expected: "an open surface that reaches beyond the contact face".into(),
                found: format!("none before {}, beyond its border", place_words(at)),
                help: "extend the surface, close it by sides, or limit the contact by box".into(),
            });
        }
        let pseudonormal: Vector3<f64> = meeting
            .iter()
            .map(|t| match points[..] {
                [point] => self.normal(*t) * self.angle(*t, point),
                _ => self.normal(*t),
            })
            .sum();
        let side = if offset.dot(&pseudonormal) < 0.0 {
            -1.0
        } else {
            1.0
        };
        let away = offset.try_normalize(0.0).map(|it| it * side);
        Ok(Clearance {
            distance: side * offset.norm(),
            away: away.unwrap_or_else(|| pseudonormal.normalize()),
        })
    }

    /// Whether an edge at a point belongs to one triangle alone.
    fn is_on_border(&self, point: usize) -> bool {
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        for triangle in &self.around[point] {
            for other in self.triangles[*triangle] {
                *counts.entry(other).or_default() += 1;
            }
        }
        counts
            .into_iter()
            .any(|(other, n)| other != point && n == 1)
    }

    /// The place of a point among the corners of a triangle.
    pub(super) fn corner(&self, triangle: usize, point: usize) -> usize {
        let corner = self.triangles[triangle].iter().position(|p| *p == point);
        corner.expect("a corner")
    }

    /// The unit normal by the order of corners.
    pub(super) fn normal(&self, triangle: usize) -> Vector3<f64> {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(&(c - a)).normalize()
    }

    /// The angle in radians of a triangle at one of its points.
    fn angle(&self, triangle: usize, point: usize) -> f64 {
        let corner = self.corner(triangle, point);
        let [x, y, z] = [0, 1, 2].map(|k| self.corners(triangle)[(corner + k) % 3]);
        (y - x).angle(&(z - x))
    }
}

/// The quadratic surface through the corners of a triangle with their normals, over the triangle: Σ_{ab} ½ λ_a λ_b (x_b − x_a)·(n_b − n_a)
/// over its edges (T. Nagata, *Comput. Aided Geom. Design* 22 (2005) 327).
pub(in crate::mesh) fn beyond_straight(
    places: &[Vector3<f64>; 3],
    normals: &[Vector3<f64>; 3],
    at: &[f64; 3],
) -> f64 {
    let over_edge = |[a, b]: [usize; 2]| {
        0.5 * at[a] * at[b] * (places[b] - places[a]).dot(&(normals[b] - normals[a]))
    };
    TRIANGLE_EDGES.map(over_edge).iter().sum()
}

/// Triangles around each of some points.
fn around(n_points: usize, triangles: &[[usize; 3]]) -> Vec<Vec<usize>> {
    let mut around = vec![Vec::new(); n_points];
    for (number, corners) in triangles.iter().enumerate() {
        for point in corners {
            around[*point].push(number);
        }
    }
    around
}

/// The barycentric coordinates of the point of a triangle nearest to a place; those that vanish are zero.
fn nearest_share(corners: &[Vector3<f64>; 3], x: &Vector3<f64>) -> [f64; 3] {
    let [a, b, c] = *corners;
    let normal = (b - a).cross(&(c - a));
    let area = |p: &Vector3<f64>, q: &Vector3<f64>| (q - p).cross(&(x - p)).dot(&normal);
    let inside = [area(&b, &c), area(&c, &a), area(&a, &b)];
    if inside.iter().all(|part| *part > 0.0) {
        let whole: f64 = inside.iter().sum();
        return inside.map(|part| part / whole);
    }
    let on_edge = |from: usize| {
        let to = (from + 1) % 3;
        let way = corners[to] - corners[from];
        let part = ((x - corners[from]).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
        let mut share = [0.0; 3];
        (share[from], share[to]) = (1.0 - part, part);
        let square = (corners[from] + way * part - x).norm_squared();
        (share, square)
    };
    let nearest = (0..3).map(on_edge).min_by(|a, b| a.1.total_cmp(&b.1));
    nearest.expect("three edges").0
}

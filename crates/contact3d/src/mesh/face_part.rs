//! Parts of faces: the triangles that a box or a disc holds, cut where its border crosses them.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::{COORDINATE_ROUNDING, Mesh, SidePoint, centroid, triangle_area};
use crate::{
    reference::quadrature,
    scene::{Disc, FacePart, InvalidValue, Scene, Written},
};

/// A boundary triangle as its own only part.
pub(crate) const WHOLE_SIDE: [[[f64; 3]; 3]; 1] =
    [[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];

/// What a part of a face holds of a boundary triangle.
#[derive(Debug, Clone)]
pub struct SidePart {
    /// The triangle, as an index into the boundary's.
    pub facet: usize,
    /// The triangles of it that the part holds, in its barycentric coordinates; `None` for all of it.
    pub(crate) cut: Option<Vec<[[f64; 3]; 3]>>,
}

impl SidePart {
    /// The triangles that it consists of.
    pub(crate) fn triangles(&self) -> &[[[f64; 3]; 3]] {
        self.cut.as_deref().unwrap_or(&WHOLE_SIDE)
    }

    /// The same, each cut in four.
    pub(crate) fn quarters(&self) -> Vec<[[f64; 3]; 3]> {
        self.triangles().iter().flat_map(quarters_of).collect()
    }

    /// Whether it holds a corner of the triangle.
    #[must_use]
    pub fn holds_corner(&self, corner: usize) -> bool {
        let mut places = self.triangles().iter().flatten();
        places.any(|share| share[corner] > 1.0 - COORDINATE_ROUNDING)
    }
}

/// A triangle cut in four at the middles of its edges.
pub(crate) fn quarters_of([a, b, c]: &[[f64; 3]; 3]) -> [[[f64; 3]; 3]; 4] {
    let middle = |p: &[f64; 3], q: &[f64; 3]| std::array::from_fn(|k| (p[k] + q[k]) / 2.0);
    let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
    [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [bc, ca, ab]]
}

/// The share of a triangle's area that lies inside a box, which may be flat.
pub(super) fn share_inside(triangle: &[[f64; 3]; 3], corners: &[[f64; 3]; 2]) -> f64 {
    triangle_in_box(triangle, corners).map_or(0.0, |(area, _)| area / triangle_area(triangle))
}

/// The part of a triangle in a box: its area in m² and the barycentric coordinates of its centroid; `None` where there is none.
pub(crate) fn triangle_in_box(
    triangle: &[[f64; 3]; 3],
    corners: &[[f64; 3]; 2],
) -> Option<(f64, [f64; 3])> {
    let (mut share, mut first) = (0.0, Vector3::zeros());
    for part in fan(&clipped(&box_sides(triangle, corners))) {
        share += area_share(&part);
        first += Vector3::from(centroid(&part)) * area_share(&part);
    }
    (share > 0.0).then(|| (share * triangle_area(triangle), (first / share).into()))
}

/// The area of a triangle in barycentric coordinates over that of the whole.
pub(crate) fn area_share([[a, b, _], [c, d, _], [e, f, _]]: &[[f64; 3]; 3]) -> f64 {
    ((c - a) * (f - b) - (e - a) * (d - b)).abs()
}

impl Mesh {
    fn side_of(&self, part: &FacePart<'_>, facet: usize) -> Option<SidePart> {
        let triangle = self.corners(&self.facets[facet]);
        let mut sides = part
            .corners
            .map_or_else(Vec::new, |corners| box_sides(&triangle, &corners));
        sides.extend(
            part.disc
                .into_iter()
                .flat_map(|disc| disc_sides(&triangle, &disc)),
        );
        let triangles = fan(&clipped(&sides));
        let share: f64 = triangles.iter().map(area_share).sum();
        let is_whole = share > 1.0 - COORDINATE_ROUNDING;
        (share > COORDINATE_ROUNDING).then(|| SidePart {
            facet,
            cut: (!is_whole).then_some(triangles),
        })
    }

    /// Nodes of a boundary triangle and points to integrate at on a part of it.
    pub(crate) fn points_of(&self, side: &SidePart) -> (Vec<usize>, Vec<SidePoint>) {
        self.points_on(side.facet, side.triangles())
    }

    /// The same where a triangle is quadratic or cut; the others are straight and whole.
    pub(crate) fn points_unless_plain(
        &self,
        side: &SidePart,
    ) -> Option<(Vec<usize>, Vec<SidePoint>)> {
        (self.mid_edges.is_some() || side.cut.is_some()).then(|| self.points_of(side))
    }

    /// Refuses boxes and discs of loads and springs that hold nothing of their faces.
    ///
    /// # Errors
    /// The key of the box or disc.
    pub(super) fn check_face_parts(&self, scene: &Scene) -> Result<(), InvalidValue> {
        let mut parts = scene.face_parts();
        parts.try_for_each(|(key, part)| self.sides_of(&key, &part).map(drop))
    }

    /// What a face, or a part of one, consists of, for the key of a load or a spring on it.
    ///
    /// # Errors
    /// A box or a disc that holds nothing of the face.
    pub fn sides_of(&self, key: &str, part: &FacePart<'_>) -> Result<Vec<SidePart>, InvalidValue> {
        let sides_in = |part: &FacePart<'_>| -> Vec<SidePart> {
            let facets = self.facets_on(part.face);
            facets
                .filter_map(|facet| self.side_of(part, facet))
                .collect()
        };
        let refused = |name: &str, expected: &str, found: String, help: &str| {
            Err(InvalidValue {
                key: format!("{key}.{name}"),
                expected: format!("{expected} {}", Written(&part.face)),
                found,
                help: help.to_owned(),
            })
        };
        if let Some(disc) = part.disc {
            let of_radius = |radius: f64| {
                let disc = Some(Disc { radius, ..disc });
                sides_in(&FacePart { disc, ..*part }).is_empty()
            };
            // A centre on a curved face may lie off its triangles; at a tenth of the radius the disc is smaller by half a percent.
            if of_radius(0.1 * disc.radius) && !self.is_around(&disc, part.face, &sides_in(part)) {
                let is_small = !of_radius(disc.radius.max(0.01 * self.extent()));
                return if is_small && disc.radius < 1e-3 * self.extent() {
                    refused(
                        "disc.radius",
                        "a radius that holds some area of",
                        Written(&disc.radius).to_string(),
                        "stress under a load on a point has no bound: give it a radius that triangles of the mesh can tell",
                    )
                } else {
                    refused(
                        "disc.centre",
                        "a point of the face",
                        Written(&disc.centre).to_string(),
                        "the disc lies on the face, around its centre; move the centre onto it, or into a hole of it",
                    )
                };
            }
        }
        let sides = sides_in(part);
        if let Some(corners) = part.corners
            && sides.is_empty()
        {
            return refused(
                "box",
                "a box that holds some area of",
                Written(&corners).to_string(),
                "move or widen it; it may be as flat as the face, but stress under a load on a line or a point has no bound: give it a width, or write disc = { centre, radius } in its place",
            );
        }
        Ok(sides)
    }

    /// Whether what a disc holds of a face lies around its centre, in its plane, as around a hole, but for halves that planes of symmetry cut off
    /// where the face ends.
    fn is_around(&self, disc: &Disc, face: &str, sides: &[SidePart]) -> bool {
        let centre = Vector3::from(disc.centre);
        let (mut area, mut moment) = (0.0, Vector3::zeros());
        for side in sides {
            let corners = self.corners(&self.facets[side.facet]);
            let [a, b, c] = corners.map(Vector3::from);
            let normal = (b - a).cross(&(c - a)).normalize();
            if normal.dot(&(centre - a)).abs() > 0.1 * disc.radius {
                return false;
            }
            for part in side.triangles() {
                let share = area_share(part) * triangle_area(&corners);
                let at = Vector3::from(quadrature::point(&corners, &centroid(part)));
                area += share;
                moment += (at - centre) * share;
            }
        }
        for c in 0..3 {
            let corners = self
                .facets_on(face)
                .flat_map(|facet| self.corners(&self.facets[facet]));
            let [low, high] = corners.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                [low.min(x[c] - centre[c]), high.max(x[c] - centre[c])]
            });
            if low.abs().min(high.abs()) <= COORDINATE_ROUNDING * self.extent() {
                moment[c] = 0.0;
            }
        }
        // Of half a disc, whose centre is at the edge of its face, 0.42 radii.
        area > 0.0 && moment.norm() < 0.25 * disc.radius * area
    }
}

/// The planes of a box as linear functions that are not negative inside, each by its values at the corners of a triangle. Corners that
/// rounding may have moved off a plane lie on it.
fn box_sides(triangle: &[[f64; 3]; 3], [low, high]: &[[f64; 3]; 2]) -> Vec<[f64; 3]> {
    // Of the triangle's own coordinates: corners of a box may be far away.
    let coordinates = triangle.as_flattened().iter();
    let size = coordinates.fold(0.0, |most: f64, x| most.max(x.abs()));
    let rounding = COORDINATE_ROUNDING * size;
    let planes = (0..3).flat_map(|c| {
        let along = triangle.map(|x| x[c]);
        let extent = along.into_iter().fold(f64::NEG_INFINITY, f64::max)
            - along.into_iter().fold(f64::INFINITY, f64::min);
        // A narrow triangle has its corners on one plane at most, unless it is flat to the digits.
        let slack = if extent > rounding {
            rounding.min(extent / 4.0)
        } else {
            rounding
        };
        let snapped = move |side: f64| if side.abs() <= slack { 0.0 } else { side };
        [
            along.map(|x| snapped(x - low[c])),
            along.map(|x| snapped(high[c] - x)),
        ]
    });
    planes.collect()
}

/// The disc that a ball cuts out of the plane of a triangle, as a regular polygon of the same area: its sides as linear functions that are
/// not negative inside.
fn disc_sides(triangle: &[[f64; 3]; 3], disc: &Disc) -> Vec<[f64; 3]> {
    // A multiple of four, so that permuted axes change nothing. The border is then at most 1e-4 radii from the circle, and moments of second
    // degree are right to 1e-8.
    const SIDES: u32 = 256;
    let corners = triangle.map(|corner| Vector3::from(corner) - Vector3::from(disc.centre));
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a)).normalize();
    let off = a.dot(&normal);
    let radius = (disc.radius - off.abs()).max(0.0).sqrt() * (disc.radius + off.abs()).sqrt();
    let angle = 2.0 * PI / f64::from(SIDES);
    // n/2 ρ² sin(2π/n) = π r² of a polygon with corners at ρ.
    let apothem = radius * (angle / angle.sin()).sqrt() * (angle / 2.0).cos();
    let flat = corners.map(|corner| corner - normal * off);
    if flat.iter().all(|corner| corner.norm() <= apothem) {
        return Vec::new();
    }
    let first = Vector3::ith(normal.iamin(), 1.0).cross(&normal).normalize();
    let second = normal.cross(&first);
    let side = |k: u32| {
        let (sin, cos) = (f64::from(k) * angle).sin_cos();
        flat.map(|corner| apothem - corner.dot(&(first * cos + second * sin)))
    };
    let sides = (0..SIDES).map(side);
    sides.filter(|side| side.iter().any(|s| *s < 0.0)).collect()
}

/// What some linear functions leave of a triangle where none of them is negative: a convex polygon in barycentric coordinates.
pub(super) fn clipped(sides: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut polygon = WHOLE_SIDE[0].to_vec();
    for values in sides {
        let side = |share: &[f64; 3]| -> f64 { (0..3).map(|k| values[k] * share[k]).sum() };
        polygon = cut(&polygon, side);
        if polygon.is_empty() {
            break;
        }
    }
    polygon
}

/// The part of a convex polygon where a linear function is not negative.
fn cut(polygon: &[[f64; 3]], side: impl Fn(&[f64; 3]) -> f64) -> Vec<[f64; 3]> {
    let mut kept = Vec::new();
    for (k, here) in polygon.iter().enumerate() {
        let next = &polygon[(k + 1) % polygon.len()];
        let (a, b) = (side(here), side(next));
        if a >= 0.0 {
            kept.push(*here);
        }
        if (a >= 0.0) != (b >= 0.0) {
            let t = a / (a - b);
            kept.push(std::array::from_fn(|c| here[c] + t * (next[c] - here[c])));
        }
    }
    kept
}

/// A convex polygon as triangles around its first corner, without those that rounding has left.
pub(super) fn fan(polygon: &[[f64; 3]]) -> Vec<[[f64; 3]; 3]> {
    let corners = 2..polygon.len();
    let triangles = corners.map(|k| [polygon[0], polygon[k - 1], polygon[k]]);
    triangles
        .filter(|triangle| area_share(triangle) > 0.0)
        .collect()
}

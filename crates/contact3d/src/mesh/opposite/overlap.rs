//! The part of a contact triangle that triangles of the other face lie opposite of.

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Vector2, Vector3};

use super::{Boxes, Face};
use crate::{
    mesh::{
        Mesh,
        contact_surface::FaceTriangle,
        face_part::{clipped, fan},
    },
    reference::quadratic_triangle_slopes,
};

/// Cosine of the angle between the normal of one side and the reversed one of the other from which on they do not face each other: 60°.
const FACING: f64 = 0.5;

/// What a triangle of the side with panes has in common with the other face.
#[derive(Debug, Clone)]
pub(in crate::mesh) struct Overlap {
    /// The common area and ∫ φ_j over it.
    pub(in crate::mesh) triangle: FaceTriangle,
    /// ∫ φ_j ψ_k in m² over it, by nodes of the mesh.
    pub(in crate::mesh) products: BTreeMap<(usize, usize), f64>,
    /// ∫ φ_i φ_j in m² over it, by places in the triangle.
    pub(in crate::mesh) masses: [[f64; 6]; 6],
    /// The triangles of the other face that take part.
    pub(in crate::mesh) opposite: Vec<usize>,
}

impl Overlap {
    /// The overlap of a triangle with the other face.
    pub(in crate::mesh) fn of(
        side: &Face<'_>,
        facet: usize,
        other: &Face<'_>,
        boxes: &Boxes,
    ) -> Self {
        let mesh = side.mesh;
        let corners = mesh.corners(&mesh.facets[facet]);
        let places: Vec<[f64; 3]> = mesh
            .facet_nodes(facet)
            .map(|n| mesh.coordinates[n])
            .collect();
        let mut found = Self {
            triangle: mesh.face_triangle(facet),
            products: BTreeMap::new(),
            masses: [[0.0; 6]; 6],
            opposite: Vec::new(),
        };
        found.triangle.area = 0.0;
        found
            .triangle
            .integrals
            .iter_mut()
            .for_each(|(_, i)| *i = 0.0);
        let Some(normal) = area_vector(&corners).try_normalize(0.0) else {
            return found;
        };
        for candidate in boxes.along(&normal, &places) {
            found.add(mesh, &corners, &normal, candidate, other);
        }
        found
    }

    /// Adds what the triangle has in common with one of the other face: their projections on its plane along its normal.
    fn add(
        &mut self,
        mesh: &Mesh,
        corners: &[[f64; 3]; 3],
        normal: &Vector3<f64>,
        candidate: usize,
        other: &Face<'_>,
    ) {
        let opposite = other
            .mesh
            .corners(&other.mesh.facets[candidate])
            .map(Vector3::from);
        let facing = area_vector(&opposite.map(Into::into));
        if facing.dot(normal) > -FACING * facing.norm() {
            return;
        }
        // Seen along the normal of this side the other triangle turns clockwise.
        let inside = [[0, 1], [1, 2], [2, 0]].map(|[a, b]| {
            let inwards = (opposite[b] - opposite[a]).cross(normal);
            corners.map(|x| inwards.dot(&(Vector3::from(x) - opposite[a])))
        });
        let pieces = fan(&clipped(&inside));
        if pieces.is_empty() {
            return;
        }
        self.opposite.push(candidate);
        let theirs: Vec<usize> = other.mesh.facet_nodes(candidate).collect();
        let projection = Projection::new(other.mesh, candidate, *normal);
        let (ours, points) = mesh.points_on(self.triangle.facet, &pieces);
        let mut sums = [[0.0; 6]; 6];
        for point in points {
            let weight = point.area.norm();
            let at = projection.point_at(&point.at.into());
            let shape = other.mesh.facet_shape(&at);
            self.triangle.area += weight;
            for (k, (_, integral)) in self.triangle.integrals.iter_mut().enumerate() {
                *integral += weight * point.shape[k];
            }
            let rows = sums.iter_mut().zip(&mut self.masses);
            for ((row, masses), phi) in rows.zip(point.shape) {
                for (sum, psi) in row.iter_mut().zip(&shape) {
                    *sum += weight * phi * psi;
                }
                for (mass, psi) in masses.iter_mut().zip(point.shape) {
                    *mass += weight * phi * psi;
                }
            }
        }
        for (j, row) in ours.iter().zip(sums) {
            for (k, sum) in theirs.iter().zip(row) {
                *self.products.entry((*j, *k)).or_insert(0.0) += sum;
            }
        }
    }
}

/// Twice the area of a triangle times its normal.
pub(super) fn area_vector([a, b, c]: &[[f64; 3]; 3]) -> Vector3<f64> {
    let [a, b, c] = [a, b, c].map(|x| Vector3::from(*x));
    (b - a).cross(&(c - a))
}

/// Where lines along a direction meet a triangle, curved or not.
pub(super) struct Projection<'a> {
    mesh: &'a Mesh,
    places: Vec<Vector3<f64>>,
    along: Vector3<f64>,
    across: [Vector3<f64>; 2],
}

impl<'a> Projection<'a> {
    pub(super) fn new(mesh: &'a Mesh, facet: usize, along: Vector3<f64>) -> Self {
        let first = Vector3::ith(along.iamin(), 1.0).cross(&along).normalize();
        let nodes = mesh.facet_nodes(facet);
        Self {
            mesh,
            places: nodes.map(|n| mesh.coordinates[n].into()).collect(),
            across: [first, along.cross(&first)],
            along,
        }
    }

    /// The barycentric coordinates of the point where the line through a place meets the triangle, which may be outside.
    pub(super) fn point_at(&self, place: &Vector3<f64>) -> [f64; 3] {
        let flat = |v: Vector3<f64>| Vector2::from(self.across.map(|axis| axis.dot(&v)));
        let [origin, b, c] = [0, 1, 2].map(|k| self.places[k]);
        let straight = Matrix2::from_columns(&[flat(b - origin), flat(c - origin)]);
        let start = straight
            .try_inverse()
            .map(|inverse| inverse * flat(place - origin));
        let mut at = start.unwrap_or_else(Vector2::zeros);
        if self.places.len() == 6 {
            // Quadratic from a start that is off by the bulge of the side: four steps reach rounding.
            for _ in 0..4 {
                let shares = [1.0 - at.x - at.y, at.x, at.y];
                let shape = self.mesh.facet_shape(&shares);
                let slopes = quadratic_triangle_slopes(&shares);
                let terms = self.places.iter().zip(&shape);
                let here: Vector3<f64> = terms.map(|(x, share)| x * *share).sum();
                let slope = |axis: usize| -> Vector3<f64> {
                    let nodes = self.places.iter().zip(&slopes);
                    nodes.map(|(x, s)| x * (s[axis] - s[0])).sum()
                };
                let jacobian = Matrix2::from_columns(&[flat(slope(1)), flat(slope(2))]);
                let Some(inverse) = jacobian.try_inverse() else {
                    break;
                };
                at += inverse * flat(place - here);
            }
        }
        [1.0 - at.x - at.y, at.x, at.y]
    }

    /// The place in m with given shape functions, and how far along the direction it is from another in m.
    pub(super) fn place_of(&self, shape: &[f64], from: &Vector3<f64>) -> (Vector3<f64>, f64) {
        let terms = self.places.iter().zip(shape);
        let place: Vector3<f64> = terms.map(|(x, share)| x * *share).sum();
        (place, (place - from).dot(&self.along))
    }
}

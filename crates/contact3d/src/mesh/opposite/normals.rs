//! Normals of a face at its nodes, and how far the curved face lies beyond the straight triangles that stand for it.
//!
//! On straight triangles the normal at a node is that of the quadric y = a x + b z + ½ (c x² + 2d x z + e z² + f y²) through it that fits the
//! corners of the triangles around the node and of those around these: means over triangles would be one-sided at the ends of a face, and
//! follow the shapes of triangles. With f = (c² + 2d² + e²)/(c + e) it is a circle on a cylinder and a sphere on a ball. Curved sides have
//! normals of their own.

use std::{
    collections::{BTreeMap, BTreeSet},
    f64::consts::{PI, SQRT_2},
};

use nalgebra::{DMatrix, DVector, Vector3};

use super::Face;
use crate::{
    mesh::{
        Mesh, is_straight,
        obstacle::{beyond_straight, faceting, is_smooth},
    },
    reference::TRIANGLE_EDGES,
};

/// The unit normals of a curved face at its nodes, whether straight triangles stand for it, and what these normals leave of distances between
/// the face and its mesh at most, in m.
pub(super) fn of_curved(
    mesh: &Mesh,
    facets: &[usize],
) -> (BTreeMap<usize, Vector3<f64>>, bool, f64) {
    let mut normals = means(mesh, facets);
    let is_straight_side = |facet: &usize| {
        mesh.mid_edges.as_ref().is_none_or(|middles| {
            let corners = mesh.corners(&mesh.facets[*facet]);
            let middles = mesh.corners(&middles.facets[*facet]);
            is_straight(&corners, &TRIANGLE_EDGES, &middles)
        })
    };
    let has_straight_sides = facets.iter().all(is_straight_side);
    if !has_straight_sides {
        // Where sides of quadratic shape meet at θ they lie within hθ/16 of an arc.
        let unresolved = faceting(mesh, facets, |_| 1.0 / 32.0);
        return (normals, has_straight_sides, unresolved);
    }
    // At the end of an arc the quadratic through three nodes has a slope that is off by 0.8 θ³, for triangles that turn by θ.
    let mut unresolved = faceting(mesh, facets, |turn| turn * turn / 2.0);
    let rings = Rings::new(mesh, facets);
    for node in rings.around.keys() {
        if let Some((normal, residual)) = rings.fitted(*node, normals[node]) {
            normals.insert(*node, normal);
            unresolved = unresolved.max(residual);
        }
    }
    if let Some(middles) = &mesh.mid_edges {
        for &facet in facets {
            let corners = mesh.facets[facet];
            for ([a, b], middle) in TRIANGLE_EDGES.into_iter().zip(middles.facets[facet]) {
                let sum = normals[&corners[a]] + normals[&corners[b]];
                normals.insert(middle, sum.normalize());
            }
        }
    }
    (normals, has_straight_sides, unresolved)
}

/// Cosine of 15°, the most between a triangle of a curved face and the normals of its corners.
const SMOOTH: f64 = 0.965_925_826_289_068_3;

impl Face<'_> {
    /// How far in m the curved face lies outside a triangle that stands for it, at a point in barycentric coordinates; zero on flat faces
    /// and beside edges of the body.
    pub(super) fn bulge(&self, facet: usize, at: &[f64; 3]) -> f64 {
        let corners = self.mesh.facets[facet];
        let places = self.mesh.corners(&corners).map(Vector3::from);
        let normals = corners.map(|node| self.normals[&node]);
        let own = self.mesh.side_normals(facet);
        let is_off =
            |(node, normal): &(usize, Vector3<f64>)| self.normals[node].dot(normal) < SMOOTH;
        // Triangles that meet at more than 30° are an edge of the body.
        if self.plane.is_some() || own.iter().take(3).any(is_off) {
            return 0.0;
        }
        let middles = self.mesh.mid_edges.as_ref();
        match middles.filter(|_| !self.has_straight_sides) {
            None => beyond_straight(&places, &normals, at),
            Some(middles) => {
                let middles = self.mesh.corners(&middles.facets[facet]);
                beyond_curved(&places, &middles.map(Vector3::from), &normals, at)
            }
        }
    }
}

/// The quartic over a quadratic triangle that vanishes at its nodes and turns its edges into the tangent planes at the corners:
/// C λ_a λ_b (λ_a − λ_b)² on an edge with the slope C between them, the larger one of both ends, for at the end of a face its triangle knows no
/// other normal than its own. Inside it is exact for a cylinder whose axis is along an edge.
fn beyond_curved(
    places: &[Vector3<f64>; 3],
    middles: &[Vector3<f64>; 3],
    normals: &[Vector3<f64>; 3],
    at: &[f64; 3],
) -> f64 {
    let slopes = [0, 1, 2].map(|edge| {
        let [a, b] = TRIANGLE_EDGES[edge];
        let slope = |from: usize, to: usize| {
            let tangent = middles[edge] * 4.0 - places[from] * 3.0 - places[to];
            -tangent.dot(&normals[from])
        };
        let [one, other] = [slope(a, b), slope(b, a)];
        if one.abs() > other.abs() { one } else { other }
    });
    let over_edge = |edge: usize| {
        let [a, b] = TRIANGLE_EDGES[edge].map(|corner| at[corner]);
        slopes[edge] * a * b * (a - b).powi(2)
    };
    let sum: f64 = slopes.iter().sum();
    let towards = |corner: usize| at[corner] * (7.0 * slopes[(corner + 1) % 3] - 2.0 * sum);
    let [edges, inside] = [[0, 1, 2].map(over_edge), [0, 1, 2].map(towards)];
    edges.iter().sum::<f64>() + at.iter().product::<f64>() * inside.iter().sum::<f64>()
}

/// The mean unit normal of the triangles around each node, each with its angle there: two triangles that share a side count as one.
fn means(mesh: &Mesh, facets: &[usize]) -> BTreeMap<usize, Vector3<f64>> {
    let mut normals: BTreeMap<usize, Vector3<f64>> = BTreeMap::new();
    for &facet in facets {
        let corners = mesh.facets[facet];
        let places = mesh.corners(&corners).map(Vector3::from);
        let angle = |node: usize| {
            let corner = corners.iter().position(|corner| *corner == node);
            let ways = corner.map(|k| [1, 2].map(|by| places[(k + by) % 3] - places[k]));
            ways.map_or(PI, |[one, other]| one.angle(&other))
        };
        for node in mesh.facet_nodes(facet) {
            normals.entry(node).or_default();
        }
        for (node, normal) in mesh.side_normals(facet) {
            *normals.entry(node).or_default() += normal * angle(node);
        }
    }
    for normal in normals.values_mut() {
        *normal = normal.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    }
    normals
}

/// Straight triangles around the corners of a face.
struct Rings<'a> {
    mesh: &'a Mesh,
    /// Triangles with their unit normals, by the corners they have.
    around: BTreeMap<usize, Vec<(usize, Vector3<f64>)>>,
}

impl<'a> Rings<'a> {
    fn new(mesh: &'a Mesh, facets: &[usize]) -> Self {
        let mut around: BTreeMap<usize, Vec<(usize, Vector3<f64>)>> = BTreeMap::new();
        for &facet in facets {
            let corners = mesh.facets[facet];
            let [a, b, c] = mesh.corners(&corners).map(Vector3::from);
            let normal = (b - a).cross(&(c - a));
            let Some(normal) = normal.try_normalize(0.0) else {
                continue;
            };
            for corner in corners {
                around.entry(corner).or_default().push((facet, normal));
            }
        }
        Self { mesh, around }
    }

    /// The normal at a node by its neighbours, and the largest distance of these from the quadratic in m; `None` on an edge of the body
    /// and with too few neighbours.
    fn fitted(&self, node: usize, mean: Vector3<f64>) -> Option<(Vector3<f64>, f64)> {
        let own = &self.around[&node];
        let on_edge = |(_, a): &(usize, Vector3<f64>)| own.iter().any(|(_, b)| !is_smooth(a, b));
        if own.iter().any(on_edge) {
            return None;
        }
        let mut near = BTreeSet::new();
        for (facet, normal) in own {
            for corner in self.mesh.facets[*facet] {
                let beside = self.around[&corner].iter();
                let beside = beside.filter(|(_, other)| is_smooth(normal, other));
                near.extend(beside.flat_map(|(other, _)| self.mesh.facets[*other]));
            }
        }
        near.remove(&node);
        if near.len() < 5 {
            return None;
        }
        let place = |node: usize| Vector3::from(self.mesh.coordinates[node]);
        let ways: Vec<Vector3<f64>> = near.into_iter().map(|n| place(n) - place(node)).collect();
        let size = ways.iter().fold(0.0, |most: f64, way| most.max(way.norm()));
        let (mut normal, mut residual, mut f) = (mean, 0.0, 0.0);
        // The slope is measured in the tangent plane, which the fit itself tells, as it tells f: five passes leave 1e-6 of it.
        for _ in 0..5 {
            let first = Vector3::ith(normal.iamin(), 1.0).cross(&normal).normalize();
            let second = normal.cross(&first);
            let term = |row: usize, column: usize| {
                let (x, z) = (ways[row].dot(&first) / size, ways[row].dot(&second) / size);
                // With √2 the least solution is the same in any axes.
                [x, z, x * x, SQRT_2 * x * z, z * z][column]
            };
            let matrix = DMatrix::from_fn(ways.len(), 5, term);
            let height = |row: usize| ways[row].dot(&normal) / size;
            let heights = DVector::from_fn(ways.len(), |row, _| {
                height(row) - 0.5 * f * height(row).powi(2)
            });
            // One row of triangles does not tell some of the terms, which are then zero.
            let svd = matrix.clone().svd(true, true);
            let least = 1e-6 * svd.singular_values.max();
            let found = svd.solve(&heights, least).ok()?;
            residual = (matrix * &found - heights).amax() * size;
            // c, √2 d and e.
            let curvatures = found.rows(2, 3) * 2.0;
            let (square, sum) = (curvatures.norm_squared(), curvatures[0] + curvatures[2]);
            f = if sum * sum > 0.25 * square {
                square / sum
            } else {
                0.0
            };
            normal = (normal - first * found[0] - second * found[1]).normalize();
        }
        Some((normal, residual))
    }
}

//! Boundary triangles, the tetrahedra behind them and the regions these lie in; and the quality of tetrahedra.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::{
    COORDINATE_ROUNDING, Mesh, RawMesh, area_share, centroid, face_part::WHOLE_SIDE,
    tetrahedron_volume, triangle_area,
};
use crate::{
    reference::{
        QUADRATIC_TRIANGLE_NODES, TRIANGLE_EDGES, quadratic_triangle, quadratic_triangle_slopes,
        quadrature,
    },
    scene::{InvalidValue, Part, Scene, Written},
};

/// A point of integration on a boundary triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SidePoint {
    /// Place in m.
    pub(crate) at: [f64; 3],
    /// Shape functions of its three or six nodes.
    pub(crate) shape: [f64; 6],
    /// Outward normal times the area in m² that the point stands for.
    pub(crate) area: Vector3<f64>,
}

/// The nodes of a triangle in increasing order, the same from both sides.
#[must_use]
pub fn sorted(mut nodes: [usize; 3]) -> [usize; 3] {
    nodes.sort_unstable();
    nodes
}

/// Whether mid-edge nodes are in the middle of their edges, which join the given pairs of corners, but for rounding.
#[must_use]
pub fn is_straight(corners: &[[f64; 3]], edges: &[[usize; 2]], middles: &[[f64; 3]]) -> bool {
    edges.iter().zip(middles).all(|([a, b], middle)| {
        let [a, b] = [corners[*a], corners[*b]].map(Vector3::from);
        let off = (a + b) / 2.0 - Vector3::from(*middle);
        off.norm() <= COORDINATE_ROUNDING * (b - a).norm()
    })
}

impl Mesh {
    /// The tetrahedron behind each contact triangle, `[n_contact_facets]`; none without contact.
    pub(crate) fn behind_contact(&self) -> Vec<usize> {
        let facets = self.contact.iter().flat_map(|surface| &surface.facets);
        self.behind(facets.copied())
    }

    /// The tetrahedron behind each of some boundary triangles, by their indices, `[n]`.
    #[must_use]
    pub fn behind(&self, facets: impl Iterator<Item = usize>) -> Vec<usize> {
        let mut is_corner = vec![false; self.coordinates.len()];
        let mut place: HashMap<[usize; 3], usize> = HashMap::new();
        for (at, facet) in facets.enumerate() {
            let nodes = self.facets[facet];
            nodes.iter().for_each(|&node| is_corner[node] = true);
            place.insert(sorted(nodes), at);
        }
        let mut behind = vec![0; place.len()];
        for (t, &[a, b, c, d]) in self.tetrahedra.iter().enumerate() {
            if [a, b, c, d].iter().filter(|&&node| is_corner[node]).count() < 3 {
                continue;
            }
            for side in [[b, c, d], [a, c, d], [a, b, d], [a, b, c]] {
                if let Some(place) = place.get(&sorted(side)) {
                    behind[*place] = t;
                }
            }
        }
        behind
    }

    /// Nodes of a boundary triangle, curved or not, and 16 points, exact for polynomials of degree 6, on each of some triangles of
    /// it, which are given in its barycentric coordinates.
    pub(crate) fn points_on(
        &self,
        facet: usize,
        triangles: &[[[f64; 3]; 3]],
    ) -> (Vec<usize>, Vec<SidePoint>) {
        let nodes: Vec<usize> = self.facet_nodes(facet).collect();
        let places: Vec<Vector3<f64>> = nodes.iter().map(|&n| self.coordinates[n].into()).collect();
        let place = |at: [f64; 3], weight: f64| {
            let shape = match places.len() {
                3 => [at[0], at[1], at[2], 0.0, 0.0, 0.0],
                _ => quadratic_triangle(&at),
            };
            let place: Vector3<f64> = places.iter().zip(shape).map(|(x, w)| x * w).sum();
            SidePoint {
                at: place.into(),
                shape,
                area: twice_area(&places, &at) * (weight / 2.0),
            }
        };
        let points = triangles.iter().flat_map(|triangle| {
            let share = area_share(triangle);
            let points = quadrature::triangle();
            points.map(move |(at, weight)| (quadrature::point(triangle, &at), weight * share))
        });
        let points = points.map(|(at, weight)| place(at, weight)).collect();
        (nodes, points)
    }

    /// The outward unit normals of a boundary triangle at its nodes; none where it has no area.
    pub(crate) fn side_normals(&self, facet: usize) -> Vec<(usize, Vector3<f64>)> {
        let nodes: Vec<usize> = self.facet_nodes(facet).collect();
        let places: Vec<Vector3<f64>> = nodes.iter().map(|&n| self.coordinates[n].into()).collect();
        let nodes = nodes.iter().zip(&QUADRATIC_TRIANGLE_NODES);
        nodes
            .filter_map(|(&node, at)| Some((node, unit(twice_area(&places, at))?)))
            .collect()
    }

    /// Area of a boundary triangle in m² and ∫ φ of its nodes over it.
    ///
    /// A third of the area for each corner of P1; on straight sides of P2 nothing for corners and a
    /// third for the middle of each edge.
    pub(crate) fn side_integrals(&self, facet: usize) -> (f64, Vec<(usize, f64)>) {
        let corners = self.corners(&self.facets[facet]);
        let area = triangle_area(&corners);
        let third = area / 3.0;
        let Some(mid_edges) = &self.mid_edges else {
            return (area, self.facets[facet].map(|node| (node, third)).to_vec());
        };
        let middles = self.corners(&mid_edges.facets[facet]);
        if is_straight(&corners, &TRIANGLE_EDGES, &middles) {
            let shares = [0.0, 0.0, 0.0, third, third, third];
            return (area, self.facet_nodes(facet).zip(shares).collect());
        }
        let (nodes, points) = self.points_on(facet, &WHOLE_SIDE);
        let area = points.iter().map(|p| p.area.norm()).sum();
        let integral = |k: usize| points.iter().map(|p| p.area.norm() * p.shape[k]).sum();
        (area, nodes.into_iter().zip((0..6).map(integral)).collect())
    }
}

/// Twice the area vector that a triangle with nodes at some places has for its reference area at a point; the same everywhere on straight sides.
fn twice_area(places: &[Vector3<f64>], at: &[f64; 3]) -> Vector3<f64> {
    if places.len() == 3 {
        return (places[1] - places[0]).cross(&(places[2] - places[0]));
    }
    let slopes = quadratic_triangle_slopes(at);
    let along = |k: usize| -> Vector3<f64> {
        let slope = |n: usize| slopes[n][k] - slopes[n][0];
        (0..6).map(|n| places[n] * slope(n)).sum()
    };
    along(1).cross(&along(2))
}

/// The direction of a vector, also of one whose squares underflow; none of the zero vector.
fn unit(vector: Vector3<f64>) -> Option<Vector3<f64>> {
    let largest = vector.amax();
    (largest > 0.0).then(|| (vector / largest).normalize())
}

/// Figures that say how well shaped a mesh is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Longest edge h in m.
    pub longest_edge: f64,
    /// Shortest edge in m.
    pub shortest_edge: f64,
    /// Smallest tetrahedron volume in m³.
    pub smallest_volume: f64,
    /// Total volume |Ω| in m³.
    pub total_volume: f64,
    /// Smallest [`shape`] of a tetrahedron.
    pub smallest_shape: f64,
    /// Mean of the same measure.
    pub mean_shape: f64,
}

impl Quality {
    /// Measures a mesh.
    #[must_use]
    pub fn of(mesh: &Mesh) -> Self {
        let mut quality = Self {
            longest_edge: 0.0,
            shortest_edge: f64::INFINITY,
            smallest_volume: f64::INFINITY,
            total_volume: 0.0,
            smallest_shape: f64::INFINITY,
            mean_shape: 0.0,
        };
        for nodes in &mesh.tetrahedra {
            let corners = mesh.corners(nodes);
            let volume = tetrahedron_volume(&corners);
            let lengths = edge_lengths(&corners);
            let shape = shape(&corners);
            quality.longest_edge = lengths.into_iter().fold(quality.longest_edge, f64::max);
            quality.shortest_edge = lengths.into_iter().fold(quality.shortest_edge, f64::min);
            quality.smallest_volume = quality.smallest_volume.min(volume);
            quality.total_volume += volume;
            quality.smallest_shape = quality.smallest_shape.min(shape);
            quality.mean_shape += shape / mesh.tetrahedra.len() as f64;
        }
        quality
    }
}

/// 12 (3V)^{2/3} / Σ l² of a tetrahedron: 1 is regular, 0 degenerate (Liu & Joe 1994); 0.4 where it is a fifth as high as wide.
#[must_use]
pub fn shape(corners: &[[f64; 3]; 4]) -> f64 {
    let squares: f64 = edge_lengths(corners).iter().map(|l| l * l).sum();
    12.0 * (3.0 * tetrahedron_volume(corners)).powf(2.0 / 3.0) / squares
}

pub(super) fn edge_lengths(corners: &[[f64; 3]; 4]) -> [f64; 6] {
    let p = corners.map(Vector3::from);
    [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)].map(|(a, b)| (p[a] - p[b]).norm())
}

/// The region of each tetrahedron: k for the last region k of the scene that holds it, else the number of its body's own
/// [material](Scene::materials) or 0; empty in a scene of one material.
pub(super) fn assign(scene: &Scene, mesh: &RawMesh) -> Result<Vec<usize>, InvalidValue> {
    let has_own = scene.bodies.iter().any(|body| body.material.is_some());
    if scene.regions.is_empty() && !has_own {
        return Ok(Vec::new());
    }
    let mut assigned = vec![0; mesh.tetrahedra.len()];
    for (body, range) in mesh.bodies.iter().enumerate() {
        assigned[range.tetrahedra.clone()].fill(scene.own_material(body));
    }
    for (i, region) in scene.regions.iter().enumerate() {
        let group = match &region.part {
            Part::Group(name) => mesh.group_names.iter().position(|n| n == name),
            Part::Box(_) => None,
        };
        let holds = |t: usize| match &region.part {
            Part::Group(_) => group.is_some_and(|g| mesh.tetrahedron_group[t] == g),
            Part::Box([low, high]) => {
                let centroid = centroid(&mesh.tetrahedra[t].map(|n| mesh.coordinates[n]));
                (0..3).all(|c| low[c] <= centroid[c] && centroid[c] <= high[c])
            }
        };
        let mut found = false;
        for t in (0..assigned.len()).filter(|&t| holds(t)) {
            assigned[t] = i + 1;
            found = true;
        }
        if !found {
            return Err(empty(i, &region.part, mesh));
        }
    }
    Ok(assigned)
}

fn empty(region: usize, part: &Part, mesh: &RawMesh) -> InvalidValue {
    InvalidValue {
        key: format!("region.{region}.part"),
        expected: match part {
            Part::Group(_) => format!(
                "one of the mesh's physical volumes: {}",
                mesh.group_names.join(", ")
            ),
            Part::Box(_) => "a box that holds the centroid of at least one tetrahedron".into(),
        },
        found: Written(part).to_string(),
        help: "a region without tetrahedra would have no effect; correct or remove it".into(),
    }
}

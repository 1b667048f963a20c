//! Where on the contact triangles the conditions of contact are measured.
//!
//! At the 16 points of a quadrature rule. Where they all stay outside the obstacle although a node of the triangle is inside, or the
//! obstacle may reach in between the nodes, the triangle is cut into four, again and again, until points see it.

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::{
    mesh::{DistanceBetweenNodes, Mesh, SurfaceFace},
    post::{Solved, SolvedContact},
    reference::{quadrature, shape::quadratic_triangle},
    scene::Quantity,
};

/// Most cuts of a triangle in search of the obstacle: places of a 50th of its edges are seen.
const MOST_CUTS: usize = 4;

/// Barycentric coordinates of the corners of a triangle.
const CORNERS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A point of a contact triangle.
#[derive(Clone, Copy)]
pub(super) struct ContactPoint {
    /// Its barycentric coordinates.
    pub(super) share: [f64; 3],
    /// Its share of the area.
    pub(super) weight: f64,
    /// By how much u_ν − d is less than interpolation between the nodes says, in m: distance and normal of the obstacle are those of the
    /// point.
    pub(super) beyond_nodes: f64,
}

/// Finds the points of each triangle.
pub(super) struct ContactPoints<'a> {
    mesh: &'a Mesh,
    contact: &'a SolvedContact<'a>,
    /// u at the nodes of the mesh in m.
    displacement: &'a [[f64; 3]],
    /// u_ν − d at the contact nodes in m.
    depth: Vec<f64>,
    /// What a distance between nodes follows from, of each face.
    faces: Vec<FaceDistance<'a>>,
}

/// The obstacle of a face and the gap of the scene before it, where they vary between nodes.
struct FaceDistance<'a> {
    obstacle: Option<DistanceBetweenNodes<'a>>,
    gap: Option<&'a Quantity>,
}

impl<'a> ContactPoints<'a> {
    /// For the displacement of the mesh, and (u_ν − d, u_t1, u_t2) of the contact nodes, in m.
    pub(super) fn new(
        solved: &'a Solved<'a>,
        contact: &'a SolvedContact<'a>,
        displacement: &'a [[f64; 3]],
        moved: &[[f64; 3]],
    ) -> Self {
        let (mesh, surface) = (solved.mesh, contact.state.surface);
        let entries = solved.scene.contact_order().into_iter();
        let face = |(entry, face): (usize, &SurfaceFace)| {
            let contact = &solved.scene.contacts[entry];
            let facets = &surface.facets[face.facets.clone()];
            let nodes = &surface.nodes[face.nodes.clone()];
            let obstacle = contact.obstacle.as_ref();
            FaceDistance {
                obstacle: obstacle
                    .and_then(|it| DistanceBetweenNodes::new(mesh, facets, nodes, it)),
                gap: Some(&contact.gap).filter(|gap| gap.constant().is_none()),
            }
        };
        Self {
            mesh,
            contact,
            displacement,
            depth: moved.iter().map(|at| at[0]).collect(),
            faces: entries.zip(&surface.faces).map(face).collect(),
        }
    }

    /// The points of each contact triangle, `[n_contact_facets]`.
    pub(super) fn of_facets(&self) -> Vec<Vec<ContactPoint>> {
        let places = 0..self.contact.state.surface.facets.len();
        let of_facet = |place| {
            let mut points = Vec::with_capacity(16);
            TriangleDepth::new(self, place).add_points(&CORNERS, 0, &mut points);
            points
        };
        places.into_par_iter().map(of_facet).collect()
    }
}

/// How deep the points of a contact triangle lie in the obstacle.
struct TriangleDepth<'a> {
    mesh: &'a Mesh,
    /// Its nodes in the mesh.
    nodes: Vec<usize>,
    /// u_ν at each of them in m.
    normal_part: Vec<f64>,
    /// u at the nodes of the mesh in m.
    displacement: &'a [[f64; 3]],
    /// u_ν − d at each of them in m.
    depth: Vec<f64>,
    obstacle: Option<&'a DistanceBetweenNodes<'a>>,
    gap: Option<&'a Quantity>,
}

impl<'a> TriangleDepth<'a> {
    fn new(points: &'a ContactPoints<'_>, place: usize) -> Self {
        let (mesh, surface) = (points.mesh, points.contact.state.surface);
        let facet = surface.facets[place];
        let nodes: Vec<usize> = mesh.facet_nodes(facet).collect();
        let local = |node: &usize| surface.contact_nodes(place, [*node])[0];
        let depth: Vec<f64> = nodes.iter().map(|node| points.depth[local(node)]).collect();
        let frame = &points.contact.state.interface.frame;
        let normal_part = |node: &usize| frame.normal_part(local(node), points.displacement[*node]);
        let [a, b, c] = mesh.corners(&mesh.facets[facet]).map(Vector3::from);
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        // Distances change no faster than places do.
        let is_near = depth.iter().any(|depth| depth + longest > 0.0);
        let faces = points.faces.iter().zip(&surface.faces);
        let of_face = faces.filter(|(_, face)| face.facets.contains(&place));
        let distance = of_face.map(|(distance, _)| distance).next();
        let obstacle = distance.and_then(|it| it.obstacle.as_ref());
        Self {
            mesh,
            normal_part: nodes.iter().map(normal_part).collect(),
            displacement: points.displacement,
            nodes,
            depth,
            obstacle: obstacle.filter(|_| is_near),
            gap: distance.and_then(|it| it.gap),
        }
    }

    /// Adds the points of a part of the triangle with some corners, which `cuts` cuts have made.
    fn add_points(&self, corners: &[[f64; 3]; 3], cuts: usize, points: &mut Vec<ContactPoint>) {
        let first = points.len();
        let share_of_area = 0.25_f64.powi(cuts as i32);
        points.extend(quadrature::triangle().map(|(share, weight)| {
            let share = quadrature::point(corners, &share);
            ContactPoint {
                share,
                weight: weight * share_of_area,
                beyond_nodes: self.beyond_nodes(share),
            }
        }));
        if cuts < MOST_CUTS && self.hides_obstacle(corners, &points[first..]) {
            points.truncate(first);
            let ([a, b, c], [ab, bc, ca]) = (*corners, middles(corners));
            for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]] {
                self.add_points(&part, cuts + 1, points);
            }
        }
    }

    /// Whether the obstacle may be inside a part of the triangle that its points see outside.
    fn hides_obstacle(&self, corners: &[[f64; 3]; 3], points: &[ContactPoint]) -> bool {
        if points
            .iter()
            .any(|point| self.depth_at(point.share, point.beyond_nodes) > 0.0)
        {
            return false;
        }
        let middles = middles(corners);
        let of_edges = corners.iter().chain(&middles).copied();
        let of_edges = of_edges.map(|share| (share, self.beyond_nodes(share)));
        let inside = points.iter().map(|point| (point.share, point.beyond_nodes));
        let (mut deepest, mut low, mut high) =
            (f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY);
        for (share, beyond) in of_edges.chain(inside) {
            deepest = deepest.max(self.depth_at(share, beyond));
            (low, high) = (low.min(beyond), high.max(beyond));
        }
        // What distances differ by between these places, they may differ by once more.
        deepest + (high - low) > 0.0
    }

    fn depth_at(&self, share: [f64; 3], beyond_nodes: f64) -> f64 {
        let terms = self.shape(share).into_iter().zip(&self.depth);
        terms.map(|(shape, depth)| shape * depth).sum::<f64>() - beyond_nodes
    }

    fn shape(&self, share: [f64; 3]) -> Vec<f64> {
        match self.mesh.mid_edges {
            None => share.to_vec(),
            Some(_) => quadratic_triangle(&share).to_vec(),
        }
    }

    fn beyond_nodes(&self, share: [f64; 3]) -> f64 {
        if self.obstacle.is_none() && self.gap.is_none() {
            return 0.0;
        }
        let shape = self.shape(share);
        let sum = |value: &dyn Fn(usize) -> f64| -> f64 {
            let terms = shape.iter().enumerate();
            terms.map(|(k, shape)| shape * value(k)).sum()
        };
        let place = |k: usize| self.mesh.coordinates[self.nodes[k]];
        let at = [0, 1, 2].map(|c| sum(&|k| place(k)[c]));
        let obstacle = self.obstacle.and_then(|it| it.at(at, &self.nodes, &shape));
        let obstacle = obstacle.map_or(0.0, |(beyond, normal)| {
            let moved = |k: usize| self.displacement[self.nodes[k]];
            let along: f64 = (0..3).map(|c| sum(&|k| moved(k)[c]) * normal[c]).sum();
            beyond - (along - sum(&|k| self.normal_part[k]))
        });
        let gap = self
            .gap
            .map_or(0.0, |gap| gap.at(at) - sum(&|k| gap.at(place(k))));
        obstacle + if gap.is_finite() { gap } else { 0.0 }
    }
}

/// The middles of the edges 0-1, 1-2, 2-0.
fn middles([a, b, c]: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let middle = |p: &[f64; 3], q: &[f64; 3]| std::array::from_fn(|k| (p[k] + q[k]) / 2.0);
    [middle(a, b), middle(b, c), middle(c, a)]
}

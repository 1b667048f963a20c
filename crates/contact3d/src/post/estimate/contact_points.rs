//! Where on the contact triangles the conditions of contact are measured.
//!
//! At the 16 points of a quadrature rule. Where they all stay outside the obstacle although it may reach into the triangle between them,
//! the triangle is cut into four, then the part in which it may reach deepest, and so on until points see it.
//!
//! A part of a triangle is outside if the Bernstein coefficients of the quadratic interpolation of u_ν − d are negative by more than
//! what the interpolation errs by at its points.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::{SolutionData, contact::varying_friction, facing::Facing};
use crate::{
    mesh::{DistanceBetweenNodes, Mesh, SurfaceFace, quarters_of},
    post::{Solved, SolvedContact},
    reference::{quadratic_triangle, quadrature},
    scene::{Follow, Quantity},
};

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
pub(in crate::post) struct ContactPoints<'a> {
    mesh: &'a Mesh,
    contact: &'a SolvedContact<'a>,
    /// u at the nodes of the mesh in m.
    displacement: &'a [[f64; 3]],
    /// Rows of the tools in m.
    tools: &'a [[f64; 3]],
    /// u_ν − d at the contact nodes in m.
    depth: Vec<f64>,
    /// The least depth that is looked for in m, a millionth of the largest displacement of the contact face: energies go with the power
    /// 2.5 of depths.
    shallowest: f64,
    /// The obstacle of each face and the gap of the scene before it, where they vary between nodes.
    faces: Vec<(Option<DistanceBetweenNodes<'a>>, Option<&'a Quantity>)>,
    /// Whether the friction of a face differs inside panes.
    friction_varies: Vec<bool>,
}

impl<'a> ContactPoints<'a> {
    /// For the displacement of the mesh, and (u_ν − d, u_t1, u_t2) of the contact nodes, in m.
    pub(in crate::post) fn new(
        solved: &'a Solved<'a>,
        contact: &'a SolvedContact<'a>,
        known: &SolutionData<'a>,
        moved: &[[f64; 3]],
    ) -> Self {
        let (mesh, surface) = (solved.mesh, contact.state.surface);
        let sizes = surface
            .nodes
            .iter()
            .map(|&node| Vector3::from(known.displacement[node]).norm());
        let largest = sizes.fold(0.0, f64::max);
        let entries = solved.scene.contact_order().into_iter();
        let face = |(entry, face): (usize, &SurfaceFace)| {
            let contact = &solved.scene.contacts[entry];
            let facets = &surface.facets[face.facets.clone()];
            let nodes = &surface.nodes[face.nodes.clone()];
            // A face that follows its tool is elsewhere by now: only its nodes know the present obstacle.
            let obstacle = contact.obstacle.as_ref();
            let obstacle = obstacle.filter(|_| solved.scene.follow_of(entry) == Follow::Start);
            (
                obstacle.and_then(|it| {
                    let obstacle = (it, mesh.surface_before(entry));
                    DistanceBetweenNodes::new(mesh, facets, nodes, obstacle)
                }),
                Some(&contact.gap).filter(|gap| gap.constant().is_none()),
            )
        };
        Self {
            mesh,
            contact,
            displacement: known.displacement,
            tools: known.tools,
            shallowest: 1e-6 * largest,
            depth: moved.iter().map(|at| at[0]).collect(),
            faces: entries.zip(&surface.faces).map(face).collect(),
            friction_varies: varying_friction(solved.scene)
                .iter()
                .map(Option::is_some)
                .collect(),
        }
    }

    /// (u_ν − d, u_t1, u_t2) at these places of each contact triangle in m, from its values at the contact nodes, `[n_contact_facets]`.
    pub(in crate::post) fn moved_at(
        &self,
        nodal: &[[f64; 3]],
        shares: &[[f64; 3]],
    ) -> Vec<Vec<[f64; 3]>> {
        let places = 0..self.contact.state.surface.facets.len();
        let of_facet = |place: usize| {
            let triangle = TriangleDepth::new(self, place);
            let nodes = self.contact.nodes_of(self.mesh, place);
            let at = |share: &[f64; 3]| {
                let shape = self.mesh.facet_shape(share);
                let [depth, first, second] = interpolated(nodal, &nodes, &shape);
                [depth - triangle.beyond_nodes(&shape), first, second]
            };
            shares.iter().map(at).collect()
        };
        places.into_par_iter().map(of_facet).collect()
    }

    /// The points of each contact triangle, `[n_contact_facets]`.
    pub(super) fn of_facets(&self) -> Vec<Vec<ContactPoint>> {
        let surface = self.contact.state.surface;
        let facing = Facing::new(self.mesh);
        let of_facet = |place: usize| {
            let mut points = TriangleDepth::new(self, place).points();
            let pane = surface.pane_of_facet(place);
            if pane.is_some_and(|pane| surface.touches_body(pane)) {
                let corners = self.mesh.facets[surface.facets[place]];
                let at = |share: &[f64; 3]| quadrature::point(&self.mesh.corners(&corners), share);
                points.retain(|it| facing.is_covered(place, at(&it.share)));
            }
            points
        };
        let places = 0..surface.facets.len();
        places.into_par_iter().map(of_facet).collect()
    }
}

/// A field of some nodes at a place of a triangle, by its shape functions.
pub(super) fn interpolated(field: &[[f64; 3]], nodes: &[usize], shape: &[f64]) -> [f64; 3] {
    let terms = || nodes.iter().zip(shape);
    std::array::from_fn(|c| terms().map(|(&n, w)| w * field[n][c]).sum())
}

/// How deep the points of a contact triangle lie in the obstacle.
struct TriangleDepth<'a> {
    of: &'a ContactPoints<'a>,
    /// Its nodes in the mesh.
    nodes: Vec<usize>,
    /// u against the obstacle at each of them in m.
    moved: Vec<[f64; 3]>,
    /// Its part along ν.
    normal_part: Vec<f64>,
    /// u_ν − d at each of them in m.
    depth: Vec<f64>,
    obstacle: Option<&'a DistanceBetweenNodes<'a>>,
    gap: Option<&'a Quantity>,
    friction_varies: bool,
}

/// A part of a contact triangle.
struct Part {
    /// Barycentric coordinates of its corners.
    corners: [[f64; 3]; 3],
    /// Its share of the area.
    share: f64,
    points: Vec<ContactPoint>,
    /// Points inside the obstacle.
    inside: usize,
    /// No point of the part is deeper in m.
    deepest: f64,
}

impl<'a> TriangleDepth<'a> {
    fn new(points: &'a ContactPoints<'a>, place: usize) -> Self {
        let (mesh, surface) = (points.mesh, points.contact.state.surface);
        let facet = surface.facets[place];
        let nodes: Vec<usize> = mesh.facet_nodes(facet).collect();
        let local = |node: &usize| surface.contact_nodes(place, [*node])[0];
        let depth: Vec<f64> = nodes.iter().map(|node| points.depth[local(node)]).collect();
        let frame = &points.contact.state.interface.frame;
        let relative = |node: &usize| {
            let at_node = |node: usize| points.displacement[node];
            frame.relative(local(node), *node, at_node, |row| points.tools[row])
        };
        let moved: Vec<[f64; 3]> = nodes.iter().map(relative).collect();
        let both = nodes.iter().zip(&moved);
        let normal_part = both.map(|(node, u)| frame.normal_part(local(node), *u));
        let normal_part = normal_part.collect();
        let longest = mesh.longest_edge(facet);
        // Distances change no faster than places do.
        let is_near = depth.iter().any(|depth| depth + longest > 0.0);
        let faces = points.faces.iter().zip(&surface.faces);
        let of_face = faces.filter(|(_, face)| face.facets.contains(&place));
        let distance = of_face.map(|(distance, _)| distance).next();
        let obstacle = distance.and_then(|(obstacle, _)| obstacle.as_ref());
        Self {
            of: points,
            normal_part,
            moved,
            nodes,
            depth,
            obstacle: obstacle.filter(|_| is_near),
            gap: distance.and_then(|(_, gap)| *gap),
            friction_varies: points.friction_varies[surface.face_number(place)],
        }
    }

    /// The points of the triangle.
    fn points(&self) -> Vec<ContactPoint> {
        let whole = self.part([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], 1.0);
        let has_formula = self.friction_varies
            || self.gap.is_some()
            || self.obstacle.is_some_and(|it| it.may_have_bumps());
        // A formula may have hills where no interpolation has any: it is looked at in more places.
        let mut parts = match has_formula {
            true => self.quarters(&whole).into(),
            false => vec![whole],
        };
        if parts.iter().all(|part| part.inside == 0) {
            self.search(&mut parts);
        }
        parts.into_iter().flat_map(|part| part.points).collect()
    }

    /// Cuts parts, into 128 at most, until 16 points are inside the obstacle, which tell the area of the place to a third, or none can be.
    fn search(&self, parts: &mut Vec<Part>) {
        while parts.len() < 128 {
            let seen: usize = parts.iter().map(|part| part.inside).sum();
            let is_cut =
                |part: &&Part| part.deepest > self.of.shallowest && part.inside < part.points.len();
            let next = parts.iter().enumerate().filter(|(_, part)| is_cut(part));
            let next = next.max_by(|(_, a), (_, b)| a.deepest.total_cmp(&b.deepest));
            let Some((next, _)) = next.filter(|_| seen < 16) else {
                break;
            };
            let part = parts.swap_remove(next);
            parts.extend(self.quarters(&part));
        }
    }

    fn quarters(&self, part: &Part) -> [Part; 4] {
        quarters_of(&part.corners).map(|corners| self.part(corners, part.share / 4.0))
    }

    fn part(&self, corners: [[f64; 3]; 3], share_of_area: f64) -> Part {
        let measured = |share: [f64; 3]| self.depth_at(share).0;
        let [a, b, c] = corners.map(measured);
        let [_, _, _, [bc, ca, ab]] = quarters_of(&corners);
        let [ab, bc, ca] = [ab, bc, ca].map(measured);
        let coefficients = [
            a,
            b,
            c,
            2.0 * ab - (a + b) / 2.0,
            2.0 * bc - (b + c) / 2.0,
            2.0 * ca - (c + a) / 2.0,
        ];
        let mut part = Part {
            corners,
            share: share_of_area,
            points: Vec::with_capacity(16),
            inside: 0,
            deepest: f64::NEG_INFINITY,
        };
        let mut interpolation_error = 0.0_f64;
        for (place, weight) in quadrature::triangle() {
            let share = quadrature::point(&corners, &place);
            let (depth, beyond_nodes) = self.depth_at(share);
            let terms = quadratic_triangle(&place)
                .into_iter()
                .zip([a, b, c, ab, bc, ca]);
            let interpolated: f64 = terms.map(|(shape, value)| shape * value).sum();
            interpolation_error = interpolation_error.max((depth - interpolated).abs());
            part.inside += usize::from(depth > 0.0);
            part.points.push(ContactPoint {
                share,
                weight: weight * share_of_area,
                beyond_nodes,
            });
        }
        part.deepest =
            interpolation_error + coefficients.into_iter().fold(f64::NEG_INFINITY, f64::max);
        part
    }

    /// u_ν − d at a point in m, and by how much it is less than interpolation between the nodes says.
    fn depth_at(&self, share: [f64; 3]) -> (f64, f64) {
        let shape = self.of.mesh.facet_shape(&share);
        let terms = shape.iter().zip(&self.depth);
        let interpolated = terms.map(|(shape, depth)| shape * depth).sum::<f64>();
        let beyond_nodes = self.beyond_nodes(&shape);
        (interpolated - beyond_nodes, beyond_nodes)
    }

    fn beyond_nodes(&self, shape: &[f64]) -> f64 {
        if self.obstacle.is_none() && self.gap.is_none() {
            return 0.0;
        }
        let sum = |value: &dyn Fn(usize) -> f64| -> f64 {
            let terms = shape.iter().enumerate();
            terms.map(|(k, shape)| shape * value(k)).sum()
        };
        let place = |k: usize| self.of.mesh.coordinates[self.nodes[k]];
        let at = [0, 1, 2].map(|c| sum(&|k| place(k)[c]));
        let obstacle = self.obstacle.and_then(|it| it.at(at, &self.nodes, shape));
        let obstacle = obstacle.map_or(0.0, |(beyond, normal)| {
            let moved = |k: usize| self.moved[k];
            let along: f64 = (0..3).map(|c| sum(&|k| moved(k)[c]) * normal[c]).sum();
            beyond - (along - sum(&|k| self.normal_part[k]))
        });
        let gap = self
            .gap
            .map_or(0.0, |gap| gap.at(at) - sum(&|k| gap.at(place(k))));
        obstacle + if gap.is_finite() { gap } else { 0.0 }
    }
}

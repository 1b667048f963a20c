//! Where the stress of an elastic body has no bound.
//!
//! Near an edge of the boundary stress goes as r^(λ − 1) with the distance r from it, and λ depends on the angle ω inside the body and on the
//! directions that either side holds (M. Williams, J. Appl. Mech. 19 (1952) 526). It is below 1
//!
//! * for ω > 180° where both sides hold the same,
//! * for ω > arccos √ν, taken as 45° since a load there makes a logarithm at equality, where one side holds all directions across the edge and the other one none,
//! * for ω > 90° where they differ otherwise: the body and its mirror image at the side make an edge of 2ω.
//!
//! Springs hold a direction as clamps do where one side of a triangle of the body is softer than they are, and contact without friction on
//! something rigid holds its normal where it is pressed. Where the part τ of a traction along a flat face jumps, stress goes as (2/π) τ ln r;
//! at a side that holds its normal alone a face and its mirror image have a jump of 2τ. Where a pressure jumps, it is bounded.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::{
    PaneState, Solved,
    estimate::{joint_sides, opposite_in},
};
use crate::{
    elasticity::{MaterialField, SurfaceLoad, stiffness_at},
    mesh::{GEOMETRY_TOLERANCE, MaterialNodes, Mesh, SidePart},
    reference::TRIANGLE_EDGES,
    scene::FaceLoad,
};

units::worded! {
    /// Where the stress of an elastic body has no bound; of several at a node the first.
    #[derive(PartialOrd, Ord)]
    pub enum StressConcentration {
        /// Two materials meet at the surface.
        Materials = "materials",
        /// The rim of a clamp.
        Clamp = "clamp",
        /// The rim of springs that are stiffer than the body.
        Springs = "springs",
        /// A re-entrant edge.
        Notch = "notch",
        /// A load along the face that ends on it.
        Shear = "shear",
        /// The edge of a punch.
        Contact = "contact",
    }
}

/// The least turn of the surface in degrees that is taken for an edge: a round hole is drawn with more than nine sides.
const EDGE: f64 = 40.0;

/// The least jump of a traction along the face over the largest stress that counts: a halving of triangles adds (2/π) ln 2 of the jump, less
/// than a hundredth of the stress below this.
pub(super) const JUMP: f64 = 0.02;

/// What concentrates stress at the nodes of a body.
pub(super) struct Concentrations<'a> {
    mesh: &'a Mesh,
    /// The directions that clamps and tools hold all over each boundary triangle, as a projection, `[n_facets]`.
    pub(super) clamped: Vec<Matrix3<f64>>,
    /// The normal of each triangle that is pressed without friction on something rigid, as a projection.
    support: BTreeMap<usize, Matrix3<f64>>,
    /// Whether each triangle is one of contact, `[n_facets]`.
    in_contact: Vec<bool>,
    /// `[n_nodes]`.
    of_nodes: Vec<Option<StressConcentration>>,
    /// Whether materials meet at the surface, `[n_nodes]`.
    materials: Vec<bool>,
}

impl<'a> Concentrations<'a> {
    /// Those of a body with the states of its panes, a displacement in m, reactions of its clamps in N and a largest stress in Pa.
    pub(super) fn new(
        solved: &Solved<'a>,
        rows: &MaterialNodes,
        panes: &[PaneState],
        (displacement, reaction): (&[[f64; 3]], &[[f64; 3]]),
        largest: f64,
    ) -> Self {
        let mesh = solved.mesh;
        let n_nodes = mesh.coordinates.len();
        let mut n_materials = vec![0; n_nodes];
        rows.nodes.iter().for_each(|&node| n_materials[node] += 1);
        let mut found = Self {
            mesh,
            clamped: clamped(solved),
            support: BTreeMap::new(),
            in_contact: vec![false; mesh.facets.len()],
            of_nodes: vec![None; n_nodes],
            materials: vec![false; n_nodes],
        };
        for node in (0..mesh.facets.len()).flat_map(|facet| mesh.facet_nodes(facet)) {
            found.materials[node] = n_materials[node] > 1;
        }
        found.support_by_contact(solved, panes);
        let edges: Vec<Edge> = edges(mesh).collect();
        found.add_edges(solved, &edges);
        found.add_held_points(solved, reaction, JUMP * largest);
        found.add_shear(solved, &edges, displacement, JUMP * largest);
        found
    }

    /// What concentrates stress at a node or at others near it: of linear tetrahedra the largest stress is often one behind the edge.
    pub(super) fn at(
        &self,
        near: impl IntoIterator<Item = usize>,
        node: usize,
    ) -> Option<StressConcentration> {
        if self.materials[node] {
            return Some(StressConcentration::Materials);
        }
        near.into_iter()
            .filter_map(|node| self.of_nodes[node])
            .min()
    }

    /// What concentrates stress at nodes of some triangles, apart from materials.
    pub(super) fn of_facets(&self, facets: Vec<usize>) -> Option<StressConcentration> {
        let nodes = facets.into_iter().flat_map(|it| self.mesh.facet_nodes(it));
        nodes.filter_map(|node| self.of_nodes[node]).min()
    }

    /// Whether a triangle is pressed without friction on something rigid.
    pub(super) fn is_supported(&self, facet: usize) -> bool {
        self.support.contains_key(&facet)
    }

    fn support_by_contact(&mut self, solved: &Solved<'_>, panes: &[PaneState]) {
        let Some(contact) = &solved.contact else {
            return;
        };
        let surface = contact.state.surface;
        let features = solved.scene.contact_features();
        for (place, &facet) in surface.facets.iter().enumerate() {
            self.in_contact[facet] = true;
            let features = &features[surface.face_number(place)];
            let is_rigid = solved.scene.contacts[features.entry].between.is_none();
            let mut here = surface.panes_of_facet(self.mesh, place).into_iter();
            let is_pressed = here.any(|pane| panes[pane].normal_stress < 0.0);
            if is_rigid && features.friction.is_none() && is_pressed {
                let normal = normal_at(self.mesh, facet, 0);
                self.support.insert(facet, normal * normal.transpose());
            }
        }
    }

    /// The directions held on both sides of an edge, for those that are held otherwise on each triangle. Where contact ends inside its face it
    /// ends without an edge.
    fn held_beside(&self, edge: &Edge, held: &[Matrix3<f64>]) -> [Matrix3<f64>; 2] {
        let is_inside = edge.sides.iter().all(|(facet, _)| self.in_contact[*facet]);
        edge.sides.map(
            |(facet, _)| match self.support.get(&facet).filter(|_| !is_inside) {
                Some(normal) => range_of(held[facet] + normal),
                None => held[facet],
            },
        )
    }

    fn add(&mut self, nodes: impl IntoIterator<Item = usize>, what: StressConcentration) {
        for node in nodes {
            let known = &mut self.of_nodes[node];
            *known = Some(known.map_or(what, |it| it.min(what)));
        }
    }

    /// Notches, and edges at which what is held changes; at the border of a joint of glued faces both bodies together make them.
    fn add_edges(&mut self, solved: &Solved<'_>, edges: &[Edge]) {
        let mesh = self.mesh;
        let mut held = self.clamped.clone();
        for (facet, directions, is_cut) in stiff_springs(solved) {
            if is_cut {
                self.add(mesh.facet_nodes(facet), StressConcentration::Springs);
            } else {
                held[facet] = range_of(held[facet] + directions);
            }
        }
        let joints = joint_sides(solved);
        let material = MaterialField::new(solved.scene, mesh);
        let compliances = material.compliances();
        let of_side = |facet: usize| compliances[material.region(joints[&facet].0)];
        for edge in edges {
            let Some((whole, joined)) = edge.with_other_body(mesh, &joints, edges) else {
                continue;
            };
            let is_singular =
                |held: &[Matrix3<f64>]| whole.is_singular(self.held_beside(&whole, held));
            let is_free = whole
                .sides
                .iter()
                .all(|(facet, _)| held[*facet] == Matrix3::zeros());
            let differ = |[own, other]: [usize; 2]| of_side(own) != of_side(other);
            let what = if joined.is_some_and(differ) {
                StressConcentration::Materials
            } else if is_free && is_singular(&held) {
                StressConcentration::Contact
            } else if is_singular(&self.clamped) {
                StressConcentration::Clamp
            } else if is_singular(&held) {
                StressConcentration::Springs
            } else if whole.angle >= 180.0 + EDGE {
                StressConcentration::Notch
            } else {
                continue;
            };
            let others = joined
                .into_iter()
                .flat_map(|[_, other]| mesh.facet_nodes(other));
            self.add(edge.nodes(mesh).into_iter().chain(others), what);
        }
    }

    /// Points and lines of the surface that clamps hold by more than some stress in Pa on the triangles around.
    fn add_held_points(&mut self, solved: &Solved<'_>, reaction: &[[f64; 3]], limit: f64) {
        let held = self.mesh.held_by(&solved.scene.clamps);
        let mut around = vec![(0.0, Matrix3::zeros()); held.len()];
        for facet in 0..self.mesh.facets.len() {
            let share = self.mesh.facet_area(facet) / 3.0;
            for node in self.mesh.facet_nodes(facet) {
                around[node].0 += share;
                around[node].1 += self.clamped[facet];
            }
        }
        for (node, (area, sides)) in around.into_iter().enumerate() {
            let is_held = |c: usize| held[node][c] && sides[(c, c)] == 0.0 && area > 0.0;
            if (0..3).any(|c| is_held(c) && reaction[node][c].abs() > limit * area) {
                self.add([node], StressConcentration::Clamp);
            }
        }
    }

    /// Where tractions of loads and springs along the face jump by more than a limit in Pa, inside triangles and between them.
    fn add_shear(
        &mut self,
        solved: &Solved<'_>,
        edges: &[Edge],
        displacement: &[[f64; 3]],
        limit: f64,
    ) {
        let mesh = self.mesh;
        let tractions = tractions(solved);
        let along_face = |number: usize, (facet, edge): (usize, usize), share: &[f64; 3]| {
            let normal = normal_at(mesh, facet, edge);
            let [place, moved] = [&mesh.coordinates[..], displacement]
                .map(|field| blend(field, &mesh.facets[facet], share));
            let traction = tractions[number].0(place, normal, moved);
            let free = traction - self.clamped[facet] * traction;
            free - normal * free.dot(&normal)
        };
        let mut whole = vec![Vec::new(); mesh.facets.len()];
        let mut jumps = Vec::new();
        for (number, (_, sides)) in tractions.iter().enumerate() {
            for side in sides {
                let Some(parts) = &side.cut else {
                    whole[side.facet].push(number);
                    continue;
                };
                // Corners of the part that are none of the triangle lie on its border.
                let mut border = parts.iter().flatten();
                let jump = |share: &[f64; 3]| along_face(number, (side.facet, 0), share).norm();
                if border.any(|share| share.iter().all(|s| *s < 1.0) && jump(share) > limit) {
                    jumps.extend(mesh.facet_nodes(side.facet));
                }
            }
        }
        let only = |on: &[usize], off: &[usize], side: (usize, usize)| -> Vector3<f64> {
            let only = on.iter().filter(|number| !off.contains(number));
            let mut middle = [0.5; 3];
            middle[(side.1 + 2) % 3] = 0.0;
            only.map(|&number| along_face(number, side, &middle)).sum()
        };
        for edge in edges
            .iter()
            .filter(|edge| (edge.angle - 180.0).abs() < EDGE)
        {
            let [first, second] = edge.sides.map(|(facet, _)| &whole[facet]);
            let jump = only(first, second, edge.sides[0]) - only(second, first, edge.sides[1]);
            if jump.norm() > limit {
                jumps.extend(edge.nodes(mesh));
            }
        }
        let is_square = |edge: &&Edge| (edge.angle - 90.0).abs() < EDGE / 2.0;
        for edge in edges.iter().filter(is_square) {
            let held = self.held_beside(edge, &self.clamped);
            for (mirror, loaded) in [(0, 1), (1, 0)] {
                let (facet, number) = edge.sides[mirror];
                let normal = normal_at(mesh, facet, number);
                // On its mirror image the shear is the opposite.
                let side = edge.sides[loaded];
                let jump = 2.0 * only(&whole[side.0], &[], side).dot(&normal).abs();
                if is_mirror(&held[mirror], &normal) && jump > limit {
                    jumps.extend(edge.nodes(mesh));
                }
            }
        }
        self.add(jumps, StressConcentration::Shear);
    }
}

/// An edge of the boundary.
#[derive(Clone, Copy)]
struct Edge {
    /// Two triangles there, and which of their edges it is.
    sides: [(usize, usize); 2],
    /// Its direction.
    along: Vector3<f64>,
    /// That inside the body in degrees.
    angle: f64,
}

impl Edge {
    fn nodes(&self, mesh: &Mesh) -> [usize; 3] {
        let (facet, edge) = self.sides[0];
        let nodes: Vec<usize> = mesh.facet_nodes(facet).collect();
        let [a, b] = TRIANGLE_EDGES[edge].map(|corner| nodes[corner]);
        [a, b, nodes.get(3 + edge).copied().unwrap_or(a)]
    }

    /// The edge that this one and the other body make where a joint of glued faces ends there, with the triangles of the joint on this body and
    /// on the other one; itself elsewhere, and `None` inside a joint.
    fn with_other_body(
        &self,
        mesh: &Mesh,
        joints: &BTreeMap<usize, (usize, f64, Vec<usize>)>,
        edges: &[Self],
    ) -> Option<(Self, Option<[usize; 2]>)> {
        let nodes = self.nodes(mesh);
        let [from, to] = [nodes[0], nodes[1]].map(|node| Vector3::from(mesh.coordinates[node]));
        let seen = |facet: usize| opposite_in(mesh, joints, facet, ((from + to) / 2.0).into());
        let (free, own, other) = match self.sides.map(|(facet, _)| seen(facet)) {
            [None, None] => return Some((*self, None)),
            [Some(_), Some(_)] => return None,
            [Some(other), None] => (1, 0, other),
            [None, Some(other)] => (0, 1, other),
        };
        let body = |edge: &Self| mesh.body_of_node(mesh.facets[edge.sides[0].0][0]);
        let of_other = mesh.body_of_node(mesh.facets[other][0]);
        let reach = GEOMETRY_TOLERANCE * mesh.extent();
        let beside = edges.iter().filter(|it| {
            it.angle < 180.0 - EDGE && body(it) == of_other && it.passes(mesh, nodes, reach)
        });
        let beside = beside.min_by(|a, b| a.angle.total_cmp(&b.angle));
        // The surface of the other body goes on beyond the joint, unless an edge of it lies there.
        let (facet, angle) = beside.map_or((other, 180.0), |it| {
            let outside = it
                .sides
                .into_iter()
                .find(|(facet, _)| seen(*facet).is_none());
            (outside.map_or(other, |(facet, _)| facet), it.angle)
        });
        let whole = Self {
            sides: [self.sides[free], (facet, 0)],
            along: self.along,
            angle: self.angle + angle,
        };
        Some((whole, Some([self.sides[own].0, other])))
    }

    /// Whether it passes the middle between two nodes, within a reach in m.
    fn passes(&self, mesh: &Mesh, [a, b, _]: [usize; 3], reach: f64) -> bool {
        let [from, to, ..] = self.nodes(mesh);
        let [a, b, from, to] = [a, b, from, to].map(|node| Vector3::from(mesh.coordinates[node]));
        let (middle, way) = ((a + b) / 2.0, to - from);
        let share = ((middle - from).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
        (from + way * share - middle).norm() <= reach
    }

    /// Whether stress has no bound there since the triangles hold these other directions than each other.
    fn is_singular(&self, held: [Matrix3<f64>; 2]) -> bool {
        // Projections onto different axes differ by one at least.
        if (held[0] - held[1]).norm() < 0.5 {
            return false;
        }
        let across = Matrix3::identity() - self.along * self.along.transpose();
        let n_across = held.map(|held| {
            let across = (across * held * across).symmetric_eigenvalues();
            across.iter().filter(|value| **value > 0.5).count()
        });
        let is_clamp = n_across.contains(&2) && n_across.contains(&0);
        self.angle > if is_clamp { 45.0 } else { 90.0 + EDGE / 2.0 }
    }
}

/// The edges of the boundary, each with two of its triangles.
fn edges(mesh: &Mesh) -> impl Iterator<Item = Edge> {
    let mut sides: BTreeMap<[usize; 2], Vec<(usize, usize)>> = BTreeMap::new();
    for (facet, corners) in mesh.facets.iter().enumerate() {
        for (edge, ends) in TRIANGLE_EDGES.iter().enumerate() {
            let mut ends = ends.map(|corner| corners[corner]);
            ends.sort_unstable();
            sides.entry(ends).or_default().push((facet, edge));
        }
    }
    sides.into_iter().flat_map(move |([a, b], sides)| {
        let [from, to] = [a, b].map(|node| Vector3::from(mesh.coordinates[node]));
        let pairs = sides.windows(2).map(|pair| {
            let [first, second] = [pair[0], pair[1]];
            let normals = [first, second].map(|(facet, edge)| normal_at(mesh, facet, edge));
            let other = blend(&mesh.coordinates, &mesh.facets[second.0], &[1.0 / 3.0; 3]);
            let turn = normals[0].angle(&normals[1]).to_degrees();
            let opens = (Vector3::from(other) - from).dot(&normals[0]) > 0.0;
            Edge {
                sides: [first, second],
                along: (to - from).normalize(),
                angle: 180.0 + if opens { turn } else { -turn },
            }
        });
        pairs.collect::<Vec<_>>()
    })
}

/// The outward unit normal of a boundary triangle, in the middle of an edge of it where it is curved.
pub(super) fn normal_at(mesh: &Mesh, facet: usize, edge: usize) -> Vector3<f64> {
    let normals = mesh.side_normals(facet);
    let normal = normals.get(3 + edge).or(normals.first());
    normal.map_or_else(Vector3::zeros, |(_, normal)| *normal)
}

/// Whether of the unit vectors along the axes one alone is held, and is the normal to the digits of a file: the body goes on in a mirror image.
pub(super) fn is_mirror(held: &Matrix3<f64>, normal: &Vector3<f64>) -> bool {
    (held - normal * normal.transpose()).norm() < GEOMETRY_TOLERANCE
}

/// A field of nodes at a place of a triangle.
fn blend(field: &[[f64; 3]], corners: &[usize; 3], share: &[f64; 3]) -> Vector3<f64> {
    let parts = corners.iter().zip(share);
    parts
        .map(|(node, share)| Vector3::from(field[*node]) * *share)
        .sum()
}

/// The projection onto the directions in which a sum of projections holds.
fn range_of(sum: Matrix3<f64>) -> Matrix3<f64> {
    let eigen = sum.symmetric_eigen();
    let held = (0..3).filter(|&k| eigen.eigenvalues[k] > 0.5);
    let held =
        held.map(|k| eigen.eigenvectors.column(k) * eigen.eigenvectors.column(k).transpose());
    held.sum()
}

/// The directions that clamps and tools hold all over each boundary triangle, as a projection, `[n_facets]`.
fn clamped(solved: &Solved<'_>) -> Vec<Matrix3<f64>> {
    let (scene, mesh) = (solved.scene, solved.mesh);
    let mut held = vec![Matrix3::zeros(); mesh.facets.len()];
    for clamp in &scene.clamps {
        let face = clamp.face.as_deref();
        for facet in (0..held.len()).filter(|&f| {
            let name = || &mesh.face_names[mesh.facet_face[f]];
            face.is_none_or(|face| name() == face)
                && mesh
                    .facet_nodes(f)
                    .all(|node| clamp.holds(&mesh.coordinates[node]))
        }) {
            for &component in &clamp.components {
                held[facet][(component as usize, component as usize)] = 1.0;
            }
        }
    }
    for face in scene.tools.iter().filter_map(|tool| tool.face.as_ref()) {
        mesh.facets_on(face)
            .for_each(|facet| held[facet] = Matrix3::identity());
    }
    held
}

/// The boundary triangles on springs that are stiffer than what of the body is as deep as the triangle is long, with the projection onto the
/// directions in which they are, and whether springs end inside.
fn stiff_springs(solved: &Solved<'_>) -> Vec<(usize, Matrix3<f64>, bool)> {
    let (scene, mesh) = (solved.scene, solved.mesh);
    let mut found = Vec::new();
    if scene.springs.is_empty() {
        return found;
    }
    let material = MaterialField::new(scene, mesh);
    let behind = mesh.behind(0..mesh.facets.len());
    for (index, spring) in scene.springs.iter().enumerate() {
        let sides = mesh.sides_of(&format!("spring.{index}"), &spring.part());
        for side in sides.unwrap_or_default() {
            let facet = side.facet;
            let middle = blend(&mesh.coordinates, &mesh.facets[facet], &[1.0 / 3.0; 3]);
            let normal = normal_at(mesh, facet, 0);
            let stiffness = stiffness_at(spring, index, middle.into(), &normal).unwrap_or_default();
            let of_body = material.plane_strain_modulus(behind[facet]) / mesh.longest_edge(facet);
            let directions = range_of(stiffness / of_body / 2.0);
            if directions != Matrix3::zeros() {
                found.push((facet, directions, side.cut.is_some()));
            }
        }
    }
    found
}

/// A traction in Pa at a place in m with an outward normal and a displacement in m.
type Traction<'a> = Box<dyn Fn(Vector3<f64>, Vector3<f64>, Vector3<f64>) -> Vector3<f64> + 'a>;

/// The tractions of loads and springs that may act along faces, each with where it acts.
fn tractions<'a>(solved: &Solved<'a>) -> Vec<(Traction<'a>, Vec<SidePart>)> {
    let (scene, mesh) = (solved.scene, solved.mesh);
    let loads = scene.face_loads();
    let loads = loads.filter(|load| !matches!(load, FaceLoad::Pressure(..)));
    let loads = loads.filter_map(|load| SurfaceLoad::new(load, mesh).ok());
    let loads = loads.map(|load| {
        let sides = load.sides.clone();
        let at = move |place: Vector3<f64>, normal: Vector3<f64>, _: Vector3<f64>| {
            Vector3::from(load.at(place.into(), normal.into()))
        };
        (Box::new(at) as Traction<'a>, sides)
    });
    let springs = scene
        .springs
        .iter()
        .enumerate()
        .filter_map(|(index, spring)| {
            let sides = mesh
                .sides_of(&format!("spring.{index}"), &spring.part())
                .ok()?;
            let at = move |place: Vector3<f64>, normal: Vector3<f64>, moved: Vector3<f64>| {
                let stiffness = stiffness_at(spring, index, place.into(), &normal);
                -(stiffness.unwrap_or_default() * moved)
            };
            Some((Box::new(at) as Traction<'a>, sides))
        });
    loads.chain(springs).collect()
}

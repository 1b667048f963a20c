//! What lies around a tetrahedron: neighbours, loads, supports and contact.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::{
    Field,
    box_load::BoxLoad,
    facing::Facing,
    joint::{joint_sides, traction_through},
};
use crate::{
    elasticity::{SurfaceLoad, stiffness_at},
    mesh::{Mesh, SidePart, area_share},
    post::{Solved, SolvedContact},
    reference::quadrature,
};

/// What loads a field: the solution, or the adjoint of a functional.
#[derive(Clone, Copy)]
pub(in crate::post) struct FieldLoads<'a> {
    /// Whether the loads of the scene act.
    pub(in crate::post) of_scene: bool,
    /// Contact stresses on the foundation, `[n_multipliers]`.
    pub(in crate::post) multiplier: &'a [f64],
    /// Tractions on the foundation at the contact nodes beside them, `[n_contact_nodes]`; empty for none.
    pub(in crate::post) at_nodes: &'a [[f64; 3]],
    /// A load on the part of the body in a box.
    pub(in crate::post) in_box: Option<&'a BoxLoad>,
}

impl<'a> FieldLoads<'a> {
    /// Those of a solution.
    pub(super) fn of_scene(solved: &'a Solved<'_>) -> Self {
        Self {
            of_scene: true,
            multiplier: &solved.solution.multiplier,
            at_nodes: &[],
            in_box: None,
        }
    }
}

/// A point at which a load or a spring on a part of a boundary triangle is integrated.
pub(super) struct PartPoint {
    /// Barycentric coordinates.
    pub(super) share: [f64; 3],
    /// Its share of the triangle's area.
    pub(super) weight: f64,
    /// Traction of the load in Pa.
    pub(super) traction: Vector3<f64>,
    /// Stiffness per area of the spring in Pa/m.
    pub(super) stiffness: Option<Matrix3<f64>>,
}

/// What acts on the boundary triangles of a solved problem.
#[derive(Debug)]
pub struct LoadedBoundary<'a> {
    solved: &'a Solved<'a>,
    /// Components that are held at nodes, `[n_nodes]`.
    pub(super) nodes_held: Vec<[bool; 3]>,
    /// Components that are held on a whole triangle, `[n_facets]`.
    pub held: Vec<[bool; 3]>,
    loads: Vec<SurfaceLoad<'a>>,
    /// Loads and springs on each triangle, as indices with what of it they act on, `[n_facets]`.
    loads_on: Vec<Vec<(usize, SidePart)>>,
    springs: Vec<Vec<(usize, SidePart)>>,
    /// The place of each triangle among those in contact, `[n_facets]`.
    contact: Vec<Option<usize>>,
    facing: Facing<'a>,
    joints: BTreeMap<usize, (usize, f64, Vec<usize>)>,
}

impl<'a> LoadedBoundary<'a> {
    /// That of a solved problem.
    #[must_use]
    pub fn new(solved: &'a Solved<'a>) -> Self {
        let mesh = solved.mesh;
        let nodes_held = mesh.held_nodes(solved.scene);
        let held = (0..mesh.facets.len()).map(|f| {
            let all = |c: usize| mesh.facet_nodes(f).all(|n| nodes_held[n][c]);
            std::array::from_fn(all)
        });
        let held = held.collect();
        let scene = solved.scene;
        let on_sides = |sources: &mut dyn Iterator<Item = Vec<SidePart>>| {
            let mut found = vec![Vec::new(); mesh.facets.len()];
            for (i, sides) in sources.enumerate() {
                for side in sides {
                    found[side.facet].push((i, side));
                }
            }
            found
        };
        // Parts that hold nothing were refused before A was assembled.
        let springs = scene.springs.iter();
        let mut springs = springs.map(|it| mesh.sides_of("", &it.part()).unwrap_or_default());
        let loads = scene.face_loads();
        // What is not finite was refused before the solve.
        let loads = loads.filter_map(|load| SurfaceLoad::new(load, mesh).ok());
        let loads: Vec<SurfaceLoad<'_>> = loads.collect();
        let mut contact = vec![None; mesh.facets.len()];
        if let Some(surface) = &mesh.contact {
            for (place, &facet) in surface.facets.iter().enumerate() {
                contact[facet] = Some(place);
            }
        }
        Self {
            solved,
            held,
            nodes_held,
            loads_on: on_sides(&mut loads.iter().map(|load| load.sides.clone())),
            loads,
            springs: on_sides(&mut springs),
            contact,
            facing: Facing::new(mesh),
            joints: joint_sides(solved),
        }
    }

    /// Stiffness per area in Pa/m of the springs at a point of a triangle with some outward unit normal; `None` without.
    pub(super) fn spring(
        &self,
        facet: usize,
        at: [f64; 3],
        normal: &Vector3<f64>,
    ) -> Option<Matrix3<f64>> {
        let whole = self.springs[facet]
            .iter()
            .filter(|(_, side)| side.cut.is_none());
        let stiffness = whole.filter_map(|(i, _)| self.stiffness_of(*i, at, normal));
        stiffness.reduce(|sum, stiffness| sum + stiffness)
    }

    fn stiffness_of(&self, i: usize, at: [f64; 3], normal: &Vector3<f64>) -> Option<Matrix3<f64>> {
        // What is not finite or semidefinite was refused before A was assembled.
        stiffness_at(&self.solved.scene.springs[i], i, at, normal).ok()
    }

    /// Points of the loads and springs that act on parts of a triangle.
    pub(super) fn visit_parts(
        &self,
        facet: usize,
        normal: &Vector3<f64>,
        take: &mut dyn FnMut(PartPoint),
    ) {
        let corners = self.solved.mesh.corners(&self.solved.mesh.facets[facet]);
        let points = |side: &SidePart| {
            let triangles = side.cut.clone().unwrap_or_default().into_iter();
            triangles.flat_map(move |triangle| {
                quadrature::triangle_4().map(move |(share, weight)| {
                    let share = quadrature::point(&triangle, &share);
                    let at = quadrature::point(&corners, &share);
                    (share, weight * area_share(&triangle), at)
                })
            })
        };
        for (i, side) in &self.loads_on[facet] {
            for (share, weight, at) in points(side) {
                let traction = self.loads[*i].at(at, (*normal).into()).into();
                take(PartPoint {
                    share,
                    weight,
                    traction,
                    stiffness: None,
                });
            }
        }
        for (i, side) in &self.springs[facet] {
            for (share, weight, at) in points(side) {
                let stiffness = self.stiffness_of(*i, at, normal);
                take(PartPoint {
                    share,
                    weight,
                    traction: Vector3::zeros(),
                    stiffness,
                });
            }
        }
    }

    /// The traction in Pa of loads and contact stresses of the solution at the centre of a triangle with some outward unit normal, with
    /// the loads at a point of it.
    #[must_use]
    pub fn traction_of_solution(
        &self,
        facet: usize,
        at: [f64; 3],
        normal: &Vector3<f64>,
    ) -> Vector3<f64> {
        let loads = FieldLoads::of_scene(self.solved);
        self.traction(facet, at, [1.0 / 3.0; 3], normal, &loads)
    }

    /// The traction in Pa on a field at a point of a triangle, as [`Self::traction`]; through joints that of the field itself passes.
    pub(super) fn traction_on(
        &self,
        facet: usize,
        at: [f64; 3],
        share: [f64; 3],
        normal: &Vector3<f64>,
        field: &Field<'_>,
    ) -> Vector3<f64> {
        let (mesh, stress) = (self.solved.mesh, field.internal);
        let passes = || traction_through(mesh, &self.joints, (facet, at), normal, stress);
        let sum = self.traction(facet, at, share, normal, &field.loads);
        match field.is_galerkin {
            true => sum + passes().unwrap_or_default(),
            false => sum,
        }
    }

    /// The prescribed traction in Pa at a point of a triangle with some outward unit normal; `share`
    /// are the barycentric coordinates of the point in the triangle's corners.
    fn traction(
        &self,
        facet: usize,
        at: [f64; 3],
        share: [f64; 3],
        normal: &Vector3<f64>,
        loads: &FieldLoads<'_>,
    ) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        let acting = self.loads_on[facet].iter().filter(|_| loads.of_scene);
        for (i, _) in acting.filter(|(_, side)| side.cut.is_none()) {
            sum += Vector3::from(self.loads[*i].at(at, (*normal).into()));
        }
        let Some(contact) = &self.solved.contact else {
            return sum;
        };
        if let Some(place) = self.contact[facet] {
            let pane = contact.state.surface.pane_of_facet(place);
            let is_of_pair = pane.is_some_and(|pane| contact.state.surface.touches_body(pane));
            if !is_of_pair || self.facing.is_covered(place, at) {
                sum -= self.on_side_with_panes(contact, place, share, loads);
            }
        }
        if let Some((place, share)) = self.facing.across(facet, at) {
            sum += self.on_side_with_panes(contact, place, share, loads);
        }
        sum
    }

    /// The contact stress in Pa at a point of a contact triangle that acts on what lies opposite.
    fn on_side_with_panes(
        &self,
        contact: &SolvedContact<'_>,
        place: usize,
        share: [f64; 3],
        loads: &FieldLoads<'_>,
    ) -> Vector3<f64> {
        let surface = contact.state.surface;
        let mut sum = contact_stress(self.solved, contact, place, share, loads.multiplier);
        if !loads.at_nodes.is_empty() {
            let face = surface.face_of_facet(place);
            let (nodes, weights) = carriers(self.solved.mesh, surface.facets[place], share);
            for (node, weight) in nodes.into_iter().zip(weights) {
                let local = surface.contact_node(face, node);
                let at_node = |n: usize| Vector3::from(loads.at_nodes[n]) * weight;
                sum += local.map_or(Vector3::zeros(), at_node);
            }
        }
        sum
    }
}

/// λ_ν ν + λ_t1 t₁ + λ_t2 t₂ at a point of a contact triangle: constant on panes; with nodal
/// multipliers between the nodes, linearly.
fn contact_stress(
    solved: &Solved<'_>,
    contact: &SolvedContact<'_>,
    place: usize,
    share: [f64; 3],
    multiplier: &[f64],
) -> Vector3<f64> {
    let surface = contact.state.surface;
    let frame = &contact.state.interface.frame;
    let layout = contact.coupling.layout;
    let stress = |pane: usize| -> Vector3<f64> {
        let pair = layout.tangential(pane);
        let tangential = pair.map_or([0.0; 2], |pair| pair.map(|j| multiplier[j]));
        frame
            .pane_vector(surface, pane, multiplier[pane], tangential)
            .into()
    };
    let acting = multipliers_at(solved.mesh, contact, place, share).into_iter();
    acting.map(|(pane, weight)| stress(pane) * weight).sum()
}

/// The multipliers that act at a point of a contact triangle, with their weights: that of its pane, or nodal ones, linear between the nodes
/// that carry them; nodes whose displacement is held carry none.
pub(in crate::post) fn multipliers_at(
    mesh: &Mesh,
    contact: &SolvedContact<'_>,
    place: usize,
    share: [f64; 3],
) -> Vec<(usize, f64)> {
    let surface = contact.state.surface;
    if let Some(pane) = surface.pane_of_facet(place) {
        return vec![(pane, 1.0)];
    }
    let (face, facet) = (surface.face_of_facet(place), surface.facets[place]);
    let (nodes, weights) = carriers(mesh, facet, share);
    let carried = nodes.into_iter().zip(weights).filter_map(|(node, weight)| {
        let pane = surface.carried_by(face, surface.contact_node(face, node)?)?;
        Some((pane, weight))
    });
    carried.collect()
}

/// The nodes of a triangle that carry linear functions on it, corners or middles of edges, and their weights at a point.
fn carriers(mesh: &Mesh, facet: usize, share: [f64; 3]) -> ([usize; 3], [f64; 3]) {
    match &mesh.mid_edges {
        None => (mesh.facets[facet], share),
        // The linear function with given values in the middle of the edges 0-1, 1-2, 2-0.
        Some(middles) => {
            let weights = [2, 0, 1].map(|opposite: usize| 1.0 - 2.0 * share[opposite]);
            (middles.facets[facet], weights)
        }
    }
}

//! Where the nodes of a curved face touch within an increment, from which their slip is counted.
//!
//! A node at the distance g > 0 of the obstacle when an increment begins does not rub until it touches. If it moves there along c, that is
//! after g (c·t) / (c·ν) along the axis t: nothing of it is slip. Counted from u_tⁿ⁻¹ as on flat faces, slip would hold the way along a
//! normal that turns, and what draws the free face inwards before it touches.
//!
//! c is how the nearest node moved against the obstacle in the increment that was open before and after it and came nearer; where no node
//! is open, the direction of the contact force. Both need a solution, so the increment is solved [again](PASSES).

use nalgebra::Vector3;

use super::Interface;
use crate::mesh::{ContactSurface, GEOMETRY_TOLERANCE, Mesh, SurfaceFace};

/// Solves of an increment in which panes of curved faces close, each with the slip counted from where the one before saw them touch: after
/// the third, stick zones and shear forces move by less than a percent.
pub(crate) const PASSES: usize = 3;

/// Least share of the contact pressures in their sum, and of a direction along ν, for the sum to say how a face closes: one in a cup closes
/// along no direction.
const LEAST_ALONG: f64 = 0.3;

/// A contact face before or after an increment.
#[derive(Debug)]
pub(crate) struct FaceState {
    /// Displacement of each contact node against its obstacle in m, `[n_contact_nodes]`.
    pub(crate) moved: Vec<Vector3<f64>>,
    /// λ_ν in Pa, `[n_panes]`; empty before the first increment.
    pub(crate) pressure: Vec<f64>,
}

impl FaceState {
    /// Whether each contact node has no pane that is pressed; a node without panes is not open.
    fn open_nodes(&self, mesh: &Mesh, surface: &ContactSurface, face: &SurfaceFace) -> Vec<bool> {
        let pressed = |pane: usize| self.pressure.get(pane).is_some_and(|p| *p > 0.0);
        let mut open = vec![None; face.nodes.len()];
        let mut add = |local: usize, pane: usize| {
            let is_open = open[local - face.nodes.start].unwrap_or(true) && !pressed(pane);
            open[local - face.nodes.start] = Some(is_open);
        };
        for pane in face.panes.clone().filter(|_| face.is_nodal) {
            surface
                .pane_weights(pane)
                .for_each(|(local, _)| add(local, pane));
        }
        for place in face.facets.clone() {
            let Some(pane) = surface.pane_of_facet(place) else {
                continue;
            };
            for node in mesh.facet_nodes(surface.facets[place]) {
                let local = surface.contact_node(face, node);
                add(local.expect("a node of its triangle"), pane);
            }
        }
        open.into_iter().map(|open| open == Some(true)).collect()
    }
}

impl Interface {
    /// The state of the face at displacements in m of the nodes and of the rows of the tools, and multipliers in Pa.
    pub(crate) fn state_at(
        &self,
        surface: &ContactSurface,
        at_node: impl Fn(usize) -> [f64; 3],
        tools: &[[f64; 3]],
        multiplier: &[f64],
    ) -> FaceState {
        let nodes = surface.nodes.iter().enumerate();
        let moved = nodes.map(|(local, &node)| {
            Vector3::from(self.frame.relative(local, node, &at_node, |row| tools[row]))
        });
        FaceState {
            moved: moved.collect(),
            pressure: multiplier.to_vec(),
        }
    }

    /// Whether panes of faces with friction may close along other directions than one normal of all: one of these faces, or the
    /// obstacle before it, is curved. Panes against another body, whose normals are means of both, count slip from where the step begins.
    pub(crate) fn closes_along_curves(&self, mesh: &Mesh) -> bool {
        mesh.contact.iter().any(|surface| {
            let mut faces = surface.faces.iter();
            faces.any(|face| self.is_curved(mesh, surface, face))
        })
    }

    fn is_curved(&self, mesh: &Mesh, surface: &ContactSurface, face: &SurfaceFace) -> bool {
        let first = face.panes.start;
        if first >= self.n_friction_panes() || surface.touches_body(first) {
            return false;
        }
        let normals = face
            .nodes
            .clone()
            .map(|local| self.frame.normal_at(local).into());
        let facets = surface.facets[face.facets.clone()].iter();
        let own = facets.flat_map(|facet| mesh.side_normals(*facet));
        turn(normals) || turn(own.map(|(_, normal)| normal))
    }

    /// (u_t1, u_t2) in m that slip is counted from, `[n_contact_nodes]`, if a curved face goes from one state to another; `None` where no node
    /// of such a face touches on this way.
    pub(crate) fn touching(
        &self,
        mesh: &Mesh,
        before: &FaceState,
        after: &FaceState,
    ) -> Option<Vec<[f64; 2]>> {
        let began = before.moved.iter().enumerate();
        let mut origin: Vec<[f64; 2]> = began
            .map(|(local, moved)| self.frame.tangential(local, (*moved).into()))
            .collect();
        let surface = mesh.contact.as_ref()?;
        let mut touches = false;
        for face in &surface.faces {
            if !self.is_curved(mesh, surface, face) {
                continue;
            }
            let [was_open, is_open] =
                [before, after].map(|state| state.open_nodes(mesh, surface, face));
            let change = |local: usize| after.moved[local] - before.moved[local];
            let normal = |local: usize| Vector3::from(self.frame.normal_at(local));
            let place = |local: usize| Vector3::from(mesh.coordinates[surface.nodes[local]]);
            let distance = |local: usize| {
                let gap = self.gap.as_ref().map_or(0.0, |gap| gap[local]);
                gap - before.moved[local].dot(&normal(local))
            };
            let largest = face.nodes.clone().map(distance).fold(0.0, f64::max);
            let approaching: Vec<usize> = (face.nodes.clone().zip(was_open.iter().zip(&is_open)))
                .filter(|(local, (was, is))| {
                    **was && **is && change(*local).dot(&normal(*local)) > 0.0
                })
                .map(|(local, _)| local)
                .collect();
            let force = self.force_direction(surface, face, after);
            for (local, (was, is)) in face.nodes.clone().zip(was_open.iter().zip(&is_open)) {
                let gap = distance(local);
                if !was || gap <= GEOMETRY_TOLERANCE * largest {
                    continue;
                }
                touches |= !is;
                let far = |k: &usize| (place(*k) - place(local)).norm_squared();
                let nearest = approaching.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
                let way = match nearest {
                    _ if *is => change(local),
                    Some(&k) => {
                        let along = change(k).dot(&normal(local));
                        if along <= 0.0 {
                            continue;
                        }
                        // It touches before the increment ends.
                        change(k) * (gap / along).min(1.0)
                    }
                    None => match force.map(|force| (force, force.dot(&normal(local)))) {
                        Some((force, along)) if along >= LEAST_ALONG => force * (gap / along),
                        _ => continue,
                    },
                };
                let way = self.frame.tangential(local, way.into());
                origin[local] = [0, 1].map(|k| origin[local][k] + way[k]);
            }
        }
        touches.then_some(origin)
    }

    /// The direction of Σ a λ_ν ν over a face; `None` where pressures cancel.
    fn force_direction(
        &self,
        surface: &ContactSurface,
        face: &SurfaceFace,
        state: &FaceState,
    ) -> Option<Vector3<f64>> {
        let (mut sum, mut whole) = (Vector3::zeros(), 0.0);
        for pane in face.panes.clone() {
            let force = surface.pane_area[pane] * state.pressure[pane].max(0.0);
            sum += Vector3::from(self.frame.pane_vector(surface, pane, force, [0.0; 2]));
            whole += force;
        }
        (sum.norm() > LEAST_ALONG * whole).then(|| sum.normalize())
    }
}

/// Whether unit vectors differ.
fn turn(mut normals: impl Iterator<Item = Vector3<f64>>) -> bool {
    let first = normals.next().unwrap_or_default();
    normals.any(|normal| (normal - first).norm() > GEOMETRY_TOLERANCE)
}

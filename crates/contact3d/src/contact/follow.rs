//! The contact face of a later increment, with the normals and distances of obstacles where body and tools are by then.
//!
//! A tool has moved by T and turned by ω, the body by u. A point x + u of the face lies before the obstacle as the point
//! c + Rᵀ(x + u − c − T) does before the one that rests, with the rotation R of ω: from there come ν and the distance d. What moves
//! further, Δu against the tool, then obeys Δ[u]·ν ≤ d, or [u]·ν ≤ d + [u⁰]·ν in terms of displacements from the beginning.

use nalgebra::{Rotation3, Vector3};

use super::{ContactFrame, Counterpart, Interface};
use crate::{
    elasticity::ToolPlace,
    mesh::{Mesh, distances_from, outward_before},
    scene::{Follow, HalfSpace, InvalidValue, Obstacle, Scene},
};

impl Interface {
    /// The same for displacements of the nodes in m before the increment, and T in m and ω in radians of the tools as they are driven to by its end.
    ///
    /// # Errors
    /// A node without a normal of the obstacle.
    pub fn at_present(
        mut self,
        scene: &Scene,
        mesh: &Mesh,
        displacement: &[[f64; 3]],
        motions: &[[[f64; 3]; 2]],
    ) -> Result<Self, InvalidValue> {
        let Some(mut surface) = mesh.contact.clone() else {
            return Ok(self);
        };
        let features = scene.contact_features();
        let places = ToolPlace::of_scene(scene, mesh);
        let n = surface.nodes.len();
        let mut opposite = std::mem::take(&mut self.frame.opposite);
        let mut normals: Vec<[f64; 3]> = (0..n).map(|local| surface.normal_at(local)).collect();
        let mut gap = self.gap.take().unwrap_or_else(|| vec![0.0; n]);
        for (face, has) in surface.faces.iter().zip(&features) {
            let contact = &scene.contacts[has.entry];
            let tool = scene.tool_on(has.entry);
            let Some(tool) = tool.filter(|_| scene.follow_of(has.entry) == Follow::Increment)
            else {
                continue;
            };
            let [shift, turn] = motions[tool].map(Vector3::from);
            let (rotation, point) = (
                Rotation3::from_scaled_axis(turn),
                Vector3::from(places[tool].point),
            );
            let at = |local: usize| Vector3::from(mesh.coordinates[surface.nodes[local]]);
            let now = |local: usize| at(local) + Vector3::from(displacement[surface.nodes[local]]);
            let obstacle = contact.obstacle.clone().unwrap_or_else(|| {
                let outward = Vector3::from(normals[face.nodes.start]);
                Obstacle::HalfSpace(HalfSpace {
                    point: at(face.nodes.start).into(),
                    normal: (-outward).into(),
                })
            });
            let outward = outward_before(&obstacle, mesh, &surface.facets[face.facets.clone()]);
            let before_obstacle = face.nodes.clone().map(|local| {
                let place = rotation.inverse() * (now(local) - point - shift);
                let outward = outward.get(&surface.nodes[local]).copied();
                let outward = outward.unwrap_or_default();
                ((point + place).into(), rotation.inverse() * outward)
            });
            let before_obstacle: Vec<([f64; 3], Vector3<f64>)> = before_obstacle.collect();
            let obstacle = (&obstacle, mesh.surface_before(has.entry));
            let seen = distances_from(obstacle, &before_obstacle)?;
            for (local, (normal, distance)) in face.nodes.clone().zip(seen) {
                let normal = rotation * Vector3::from(normal);
                let initial = surface.clearance.get(local).copied().unwrap_or(0.0);
                gap[local] += distance - initial;
                normals[local] = normal.into();
                if let Counterpart::Tool(opposite) = &mut opposite[local] {
                    let from_point = now(local) + normal * distance - point - shift;
                    opposite.lever = (from_point / places[tool].arm).into();
                }
            }
        }
        surface.normals = normals;
        self.frame = ContactFrame::new(scene, &features, &surface, mesh)?;
        self.frame.opposite = opposite;
        let rows = tool_rows(scene, mesh, motions);
        for (face, has) in surface.faces.iter().zip(&features) {
            if scene.follow_of(has.entry) == Follow::Start {
                continue;
            }
            for local in face.nodes.clone() {
                let (node, at_node) = (surface.nodes[local], |node: usize| displacement[node]);
                let moved = self.frame.relative(local, node, at_node, |row| rows[row]);
                gap[local] += self.frame.normal_part(local, moved);
            }
        }
        self.gap = Some(gap);
        Ok(self)
    }

    /// (u_t1, u_t2) against the obstacles at the contact nodes in m, of the same displacements and motions.
    #[must_use]
    pub fn tangential_of(
        &self,
        scene: &Scene,
        mesh: &Mesh,
        displacement: &[[f64; 3]],
        motions: &[[[f64; 3]; 2]],
    ) -> Vec<[f64; 2]> {
        let rows = tool_rows(scene, mesh, motions);
        let nodes = mesh.contact.iter().flat_map(|surface| &surface.nodes);
        let moved = nodes.enumerate().map(|(local, &node)| {
            let at_node = |node: usize| displacement[node];
            let moved = self.frame.relative(local, node, at_node, |row| rows[row]);
            self.frame.tangential(local, moved)
        });
        moved.collect()
    }
}

/// The rows of the tools of a scene at T in m and ω in radians of each.
pub(crate) fn tool_rows(scene: &Scene, mesh: &Mesh, motions: &[[[f64; 3]; 2]]) -> Vec<[f64; 3]> {
    let places = ToolPlace::of_scene(scene, mesh);
    let rows = motions.iter().zip(&places);
    rows.flat_map(|(motion, place)| place.rows(*motion))
        .collect()
}

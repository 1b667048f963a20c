//! The contact faces of a scene on its mesh.

use std::collections::BTreeSet;

use super::{
    ContactSurface, Mesh, MeshError, Origin, brick, contact_parts,
    contact_surface::{ContactFace, FaceTriangle, plane_of},
    obstacle::Approach,
    patches,
};
use crate::scene::{BrickFace, Contact, Invalid, MultiplierSpace, Scene, Shape, Written};

/// Largest distance of a contact node from the plane of its face, over the extent of the face:
/// the digits that mesh files keep.
pub(super) const FLAT: f64 = 1e-6;

impl Mesh {
    /// One contact face of a scene with its panes or nodal multipliers.
    pub(super) fn contact_surface(
        &self,
        scene: &Scene,
        entry: usize,
        origin: Origin,
        held: &[[bool; 3]],
    ) -> Result<ContactSurface, MeshError> {
        let (contact, key) = (&scene.contacts[entry], scene.contact_key(entry));
        let facets = self.contact_facets(scene, entry)?;
        let corners: Vec<[usize; 3]> = facets.iter().map(|&f| self.facets[f]).collect();
        let face = self.contact_face(contact, &facets, origin);
        let face = face.map_err(|invalid| under(&key, invalid))?;
        let cells = match (&scene.body.shape, origin) {
            (Shape::Brick(spec), Origin::First) => Some(spec),
            (Shape::Brick(_), Origin::Cut { .. }) | (Shape::Gmsh(_), _) => None,
        };
        Ok(match (contact.multipliers, cells) {
            (MultiplierSpace::Nodal, _) => ContactSurface::nodal(face, |node, normal| {
                (0..3).all(|c| normal[c] == 0.0 || held[node][c])
            }),
            (MultiplierSpace::Panes, Some(spec)) => {
                let per_pane = scene.body.element.cells_per_pane();
                let panes = |triangles: &[[usize; 3]]| {
                    let side = BrickFace::named(&contact.face);
                    let triangles = triangles.iter().copied();
                    side.map_or_else(Vec::new, |s| brick::panes(spec, s, per_pane, triangles))
                };
                let whole: Vec<[usize; 3]> = self
                    .facets_on(&contact.face)
                    .map(|f| self.facets[f])
                    .collect();
                let part = contact_parts::panes_of_part(&panes(&whole), panes(&corners), || {
                    Invalid {
                        key: format!("{key}.box"),
                        expected: "a box that cuts no pane".into(),
                        found: Written(&contact.corners).to_string(),
                        help: "a pane is 2 x 2 cells of the contact face, with body.element = \"P2\" one; nodal multipliers may be cut anywhere".into(),
                    }
                })?;
                ContactSurface::with_panes(face, part)
            }
            (MultiplierSpace::Panes, None) => {
                let is_free = |node: usize| held[node] == [false; 3];
                let carriers: Vec<[usize; 3]> = face.triangles.iter().map(|t| t.carriers).collect();
                let panes = patches::build(&self.coordinates, &corners, &carriers, is_free)
                    .map_err(|invalid| under(&key, invalid))?;
                ContactSurface::with_panes(face, panes)
            }
        })
    }

    /// The triangles of the contact face with its normals and its distance from an obstacle.
    fn contact_face(
        &self,
        contact: &Contact,
        facets: &[usize],
        origin: Origin,
    ) -> Result<ContactFace, Invalid> {
        let nodes: BTreeSet<usize> = facets.iter().flat_map(|&f| self.facet_nodes(f)).collect();
        let nodes: Vec<usize> = nodes.into_iter().collect();
        let (normals, clearance) = match &contact.obstacle {
            None => (vec![self.flat_normal(contact, facets)?], Vec::new()),
            Some(obstacle) => {
                let approach = Approach::new(self, facets, &nodes, obstacle, origin.faceting())?;
                (approach.normals, approach.clearance)
            }
        };
        Ok(ContactFace {
            nodes,
            normals,
            clearance,
            triangles: facets.iter().map(|&f| self.face_triangle(f)).collect(),
        })
    }

    /// The outward normal of a contact face without an obstacle, which is flat.
    fn flat_normal(&self, contact: &Contact, facets: &[usize]) -> Result<[f64; 3], Invalid> {
        let corners = facets.iter().map(|&f| self.facets[f]);
        let others = facets.iter().flat_map(|&f| self.facet_nodes(f));
        let (normal, unevenness) =
            plane_of(&self.coordinates, corners, others).unwrap_or(([0.0; 3], f64::INFINITY));
        if unevenness.is_nan() || unevenness > FLAT {
            return Err(Invalid {
                key: "contact.face".into(),
                expected: "a flat face, or contact.obstacle for a curved one".into(),
                found: format!(
                    "{}, whose nodes are up to {unevenness:.1e} of its extent away from a plane",
                    Written(&contact.face)
                ),
                help: "without an obstacle the foundation is flat; say what the face may touch, such as [contact.obstacle.half_space], or describe a small unevenness of a flat face by contact.gap".into(),
            });
        }
        Ok(normal)
    }

    /// A triangle of the contact face with the integrals of its nodes' shape functions.
    fn face_triangle(&self, facet: usize) -> FaceTriangle {
        let (area, integrals) = self.side_integrals(facet);
        let middles = self.mid_edges.as_ref().map(|m| m.facets[facet]);
        FaceTriangle {
            facet,
            area,
            integrals,
            carriers: middles.unwrap_or(self.facets[facet]),
        }
    }
}

/// What is wrong with a contact face, under its key in the scene.
fn under(key: &str, invalid: Invalid) -> Invalid {
    let rest = invalid.key.strip_prefix("contact").map(str::to_owned);
    Invalid {
        key: rest.map_or(invalid.key, |rest| format!("{key}{rest}")),
        ..invalid
    }
}

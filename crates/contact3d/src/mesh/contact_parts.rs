//! Which triangles a contact face has, and what faces that meet must not do.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Matrix3, Vector3};

use super::{
    ContactSurface, GEOMETRY_TOLERANCE, Mesh, MeshError, brick, centroid,
    contact_surface::{ContactFace, FaceTriangle, plane_of},
    face_part::share_inside,
    macro_elements, obstacle,
};
use crate::scene::{Contact, InvalidValue, MultiplierSpace, Scene, Written, place_words};

impl Mesh {
    /// The triangles of a contact of the scene, as indices into the boundary's.
    ///
    /// # Errors
    /// A box that cuts a triangle or holds none.
    pub(super) fn contact_facets(
        &self,
        scene: &Scene,
        entry: usize,
    ) -> Result<Vec<usize>, InvalidValue> {
        let contact = &scene.contacts[entry];
        let whole: Vec<usize> = self.facets_on(&contact.face).collect();
        let Some(corners) = contact.corners else {
            return Ok(whole);
        };
        let mut inside = Vec::new();
        for facet in whole {
            let triangle = self.corners(&self.facets[facet]);
            let share = share_inside(&triangle, &corners);
            if share > 1.0 - GEOMETRY_TOLERANCE {
                inside.push(facet);
            } else if share > GEOMETRY_TOLERANCE {
                return Err(InvalidValue {
                    key: format!("{}.box", scene.contact_key(entry)),
                    expected: "a box whose sides follow the edges of the triangles".into(),
                    found: format!(
                        "{}, which cuts the triangle around {}",
                        Written(&corners),
                        place_words(centroid(&triangle))
                    ),
                    help: "move the box to planes between cells, or the planes to the box with body.brick.coordinates; in a Gmsh file give each part a physical surface of its own".into(),
                });
            }
        }
        if inside.is_empty() {
            return Err(InvalidValue {
                key: format!("{}.box", scene.contact_key(entry)),
                expected: format!("a box that holds triangles of {}", Written(&contact.face)),
                found: Written(&corners).to_string(),
                help: "move or widen it; it may be as flat as the face".into(),
            });
        }
        Ok(inside)
    }
}

/// Panes numbered without those that a part of a face leaves out; `all` is the pane of every triangle of the whole face and
/// `part` of those in contact.
///
/// # Errors
/// A pane of which the part has some triangles only.
pub(super) fn panes_of_part(
    all: &[usize],
    part: Vec<usize>,
    refuse: impl Fn() -> InvalidValue,
) -> Result<Vec<usize>, InvalidValue> {
    if all.len() == part.len() {
        return Ok(part);
    }
    let count = |panes: &[usize]| {
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        for pane in panes {
            *counts.entry(*pane).or_default() += 1;
        }
        counts
    };
    let (whole, found) = (count(all), count(&part));
    if found.iter().any(|(pane, count)| whole[pane] != *count) {
        return Err(refuse());
    }
    let number: BTreeMap<usize, usize> = found.into_keys().zip(0..).collect();
    Ok(part.iter().map(|pane| number[pane]).collect())
}

/// Refuses triangles in two contacts, and nodes that carry more conditions than they have displacements: a node whose
/// multipliers are its own holds one normal displacement for each face, and with friction all three. Panes have free nodes
/// of their own, so that faces with panes may meet anywhere. A glued node that follows others carries none.
///
/// # Errors
/// The key of the later contact.
pub(super) fn check_meeting(
    scene: &Scene,
    mesh: &Mesh,
    surface: &ContactSurface,
    held: &[[bool; 3]],
) -> Result<(), InvalidValue> {
    let order = scene.contact_order();
    let entries = || surface.faces.iter().zip(&order);
    let mut taken: BTreeMap<usize, usize> = BTreeMap::new();
    for (face, &entry) in entries() {
        for &facet in &surface.facets[face.facets.clone()] {
            let Some(other) = taken.insert(facet, entry) else {
                continue;
            };
            let middle = centroid(&mesh.corners(&mesh.facets[facet]));
            let between = scene.contacts[entry.max(other)].between.is_some();
            let (name, help) = match between {
                true => (
                    "panes_on",
                    "give the panes of both to the faces that they do not share",
                ),
                false => ("box", "make one of the boxes smaller"),
            };
            return Err(InvalidValue {
                key: format!("{}.{name}", scene.contact_key(entry.max(other))),
                expected: "triangles that are in no other contact".into(),
                found: format!("one around {} that is", place_words(middle)),
                help: format!(
                    "{} has it as well; {help}",
                    scene.contact_key(entry.min(other))
                ),
            });
        }
    }
    let mut carriers: BTreeMap<usize, Vec<(usize, usize)>> = BTreeMap::new();
    let follow: BTreeSet<usize> = mesh.glued.iter().map(|it| it.node).collect();
    for (face, &entry) in entries().filter(|(face, _)| face.is_nodal) {
        for local in face.nodes.clone() {
            if follow.contains(&surface.nodes[local]) {
                let at = place_words(mesh.coordinates[surface.nodes[local]]);
                return Err(InvalidValue {
                    key: format!("{}.multipliers", scene.contact_key(entry)),
                    expected: "nodes that follow no others, for those carry no conditions".into(),
                    found: format!("one at {at} that is glued"),
                    help: "write multipliers = \"panes\": panes have nodes of their own".into(),
                });
            }
            if surface.carried_by(face, local).is_some() {
                let at = carriers.entry(surface.nodes[local]).or_default();
                at.push((entry, local));
            }
        }
    }
    let crowded = carriers.into_iter().find(|(node, at)| {
        let friction = at
            .iter()
            .any(|(entry, _)| scene.friction_on(*entry).is_some());
        let normals = at.iter().map(|(_, local)| surface.normal_at(*local));
        at.len() > 1 && (friction || !independent(normals.collect(), &held[*node]))
    });
    match crowded {
        None => Ok(()),
        Some((node, at)) => Err(too_many_conditions(scene, mesh.coordinates[node], at)),
    }
}

fn too_many_conditions(scene: &Scene, at: [f64; 3], faces: Vec<(usize, usize)>) -> InvalidValue {
    let entries: Vec<usize> = faces.into_iter().map(|(entry, _)| entry).collect();
    let last = entries.iter().max().copied().unwrap_or_default();
    let others = entries.iter().filter(|entry| **entry != last);
    let others: Vec<String> = others.map(|entry| scene.contact_key(*entry)).collect();
    InvalidValue {
        key: format!("{}.multipliers", scene.contact_key(last)),
        expected: "nodes that carry no more conditions than they have displacements".into(),
        found: format!(
            "the node at {}, which carries those of {} as well",
            place_words(at),
            others.join(" and ")
        ),
        help: "write multipliers = \"panes\" on one of these faces: panes have nodes of their own; frictionless nodal faces may meet at an edge".into(),
    }
}

/// Whether unit normals stay independent along the components that are not held: by their Gram determinant, the square of the volume
/// that they span.
fn independent(normals: Vec<[f64; 3]>, held: &[bool; 3]) -> bool {
    let free = |normal: [f64; 3]| -> Vector3<f64> {
        Vector3::from_fn(|c, _| if held[c] { 0.0 } else { normal[c] })
    };
    let free: Vec<Vector3<f64>> = normals.into_iter().map(free).collect();
    if free.len() > 3 {
        return false;
    }
    let entry = |i: usize, j: usize| match (free.get(i), free.get(j)) {
        (Some(a), Some(b)) => a.dot(b),
        _ => f64::from(i == j),
    };
    Matrix3::from_fn(entry).determinant() > GEOMETRY_TOLERANCE
}

impl Mesh {
    /// One contact face of a scene with its panes or nodal multipliers.
    pub(super) fn contact_surface(
        &self,
        scene: &Scene,
        entry: usize,
        cut_faceting: Option<f64>,
        held: &[[bool; 3]],
    ) -> Result<ContactSurface, MeshError> {
        let (contact, key) = (&scene.contacts[entry], scene.contact_key(entry));
        if let Some(pair) = &contact.between {
            return Ok(self.pair_surface(scene, entry, (pair, cut_faceting), held)?);
        }
        let facets = self.contact_facets(scene, entry)?;
        let corners: Vec<[usize; 3]> = facets.iter().map(|&f| self.facets[f]).collect();
        let face = self.contact_face((entry, contact), &facets, cut_faceting);
        let face = face.map_err(|invalid| under(&key, invalid))?;
        let brick = scene.brick_face(&contact.face);
        let cells = brick.filter(|_| cut_faceting.is_none());
        Ok(match (contact.multipliers, cells) {
            (MultiplierSpace::Nodal, _) => ContactSurface::nodal(face, |node, normal| {
                (0..3).all(|c| normal[c] == 0.0 || held[node][c])
            }),
            (MultiplierSpace::Panes, Some(_)) => {
                let panes =
                    |triangles: &[[usize; 3]]| self.brick_panes(scene, &contact.face, triangles);
                let whole: Vec<[usize; 3]> = self
                    .facets_on(&contact.face)
                    .map(|f| self.facets[f])
                    .collect();
                let part = panes_of_part(&panes(&whole), panes(&corners), || {
                    InvalidValue {
                        key: format!("{key}.box"),
                        expected: "a box that cuts no pane".into(),
                        found: Written(&contact.corners).to_string(),
                        help: "a pane is 2 x 2 cells of the contact face, with body.element = \"P2\" one; nodal multipliers may be cut anywhere".into(),
                    }
                })?;
                ContactSurface::with_panes(face, part)
            }
            (MultiplierSpace::Panes, None) => {
                let panes = self.grouped_panes(&facets, held);
                let panes = panes.map_err(|invalid| under(&key, invalid))?;
                ContactSurface::with_panes(face, panes)
            }
        })
    }

    /// The panes of some triangles on a face of a brick: squares of cells; none for other faces.
    pub(super) fn brick_panes(
        &self,
        scene: &Scene,
        face: &str,
        triangles: &[[usize; 3]],
    ) -> Vec<usize> {
        let Some((spec, side)) = scene.brick_face(face) else {
            return Vec::new();
        };
        let per_pane = scene.element().cells_per_pane();
        let first = triangles.first().map_or(0, |[node, ..]| *node);
        let first = self.body_nodes(self.body_of_node(first)).start;
        let triangles = triangles.iter().map(|nodes| nodes.map(|n| n - first));
        brick::panes(spec, side, per_pane, triangles)
    }

    /// The panes of some boundary triangles of a mesh without cells: groups around free nodes.
    pub(super) fn grouped_panes(
        &self,
        facets: &[usize],
        held: &[[bool; 3]],
    ) -> Result<Vec<usize>, InvalidValue> {
        let corners: Vec<[usize; 3]> = facets.iter().map(|&f| self.facets[f]).collect();
        let carriers = facets.iter().map(|&f| self.face_triangle(f).carriers);
        let carriers: Vec<[usize; 3]> = carriers.collect();
        let is_free = |node: usize| held[node] == [false; 3];
        macro_elements(&self.coordinates, &corners, &carriers, is_free)
    }

    /// The triangles of the contact face with its normals and its distance from an obstacle.
    fn contact_face(
        &self,
        (entry, contact): (usize, &Contact),
        facets: &[usize],
        cut_faceting: Option<f64>,
    ) -> Result<ContactFace, InvalidValue> {
        let nodes: BTreeSet<usize> = facets.iter().flat_map(|&f| self.facet_nodes(f)).collect();
        let nodes: Vec<usize> = nodes.into_iter().collect();
        let (normals, clearance) = match &contact.obstacle {
            None => (vec![self.flat_normal(contact, facets)?], Vec::new()),
            Some(obstacle) => {
                let faceting = cut_faceting.unwrap_or(0.0);
                let obstacle = (obstacle, self.surface_before(entry));
                obstacle::gap_function(self, facets, &nodes, contact, obstacle, faceting)?
            }
        };
        Ok(ContactFace {
            opposite: None,
            nodes,
            normals,
            clearance,
            triangles: facets.iter().map(|&f| self.face_triangle(f)).collect(),
        })
    }

    /// The outward normal of a contact face without an obstacle, which is flat.
    fn flat_normal(&self, contact: &Contact, facets: &[usize]) -> Result<[f64; 3], InvalidValue> {
        let corners = facets.iter().map(|&f| self.facets[f]);
        let others = facets.iter().flat_map(|&f| self.facet_nodes(f));
        let (normal, unevenness) =
            plane_of(&self.coordinates, corners, others).unwrap_or(([0.0; 3], f64::INFINITY));
        if unevenness.is_nan() || unevenness > GEOMETRY_TOLERANCE {
            return Err(InvalidValue {
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
    pub(super) fn face_triangle(&self, facet: usize) -> FaceTriangle {
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
pub(super) fn under(key: &str, invalid: InvalidValue) -> InvalidValue {
    let rest = invalid.key.strip_prefix("contact").map(str::to_owned);
    InvalidValue {
        key: rest.map_or(invalid.key, |rest| format!("{key}{rest}")),
        ..invalid
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn shares_of_a_triangle_are_areas() {
        for (low, high, share) in [
            ([0.0, 0.0, 0.0], [1.0, 1.0, 0.0], 1.0),
            ([0.0, 0.0, -1.0], [0.5, 0.5, 1.0], 0.5),
            ([0.5, 0.0, 0.0], [1.0, 1.0, 0.0], 0.25),
            ([0.0, 0.0, 0.1], [1.0, 1.0, 1.0], 0.0),
            ([1.0, 0.0, 0.0], [2.0, 1.0, 0.0], 0.0),
            ([-1e12, -1e12, -1e12], [0.5, 1e12, 1e12], 0.75),
        ] {
            // Some roundings of areas near 1.
            assert!((share_inside(&TRIANGLE, &[low, high]) - share).abs() < 1e-15);
        }
    }

    /// Cells of 1e-9 of the coordinates are the narrowest that a brick may have.
    #[test]
    fn a_side_on_a_plane_between_cells_cuts_none() {
        for width in [1e-3, 1e-6, 1.1e-9] {
            let beyond = TRIANGLE.map(|[x, y, z]| [1.0 + width * x, y, z]);
            let inside = TRIANGLE.map(|[x, y, z]| [1.0 - width * x, y, z]);
            // Typed with ten digits.
            for side in [1.0, 1.0 + width / 10.0_f64.max(width * 1e10)] {
                let corners = [[0.0, 0.0, 0.0], [side, 1.0, 0.0]];
                assert_eq!(share_inside(&beyond, &corners), 0.0, "{width}");
                let share = share_inside(&inside, &corners);
                assert!((share - 1.0).abs() < 1e-9, "{width}: {share}");
            }
        }
    }

    #[test]
    fn normals_are_independent_along_what_is_free() {
        let (x, z) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        assert!(independent(vec![x, z], &[false; 3]));
        assert!(!independent(vec![x, z], &[false, false, true]));
        assert!(!independent(vec![x, x], &[false; 3]));
    }

    #[test]
    fn panes_of_a_part_are_numbered_anew_and_never_cut() {
        let refuse = || InvalidValue {
            key: String::new(),
            expected: String::new(),
            found: String::new(),
            help: String::new(),
        };
        let all = [0, 0, 1, 1, 2, 2];
        assert_eq!(
            panes_of_part(&all, vec![1, 1, 2, 2], refuse).unwrap(),
            [0, 0, 1, 1]
        );
        assert!(panes_of_part(&all, vec![1, 2, 2], refuse).is_err());
    }
}

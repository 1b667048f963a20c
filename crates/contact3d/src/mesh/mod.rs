//! Conforming tetrahedral meshes of the body, their boundary and the contact surface.

mod bisection;
mod bodies;
mod brick;
mod contact_parts;
mod contact_surface;
mod face_part;
mod glue;
mod gmsh;
mod inspection;
mod macro_elements;
mod material_nodes;
mod obstacle;
mod opposite;
mod quadratic;
mod refined;
mod side;

use std::{collections::BTreeMap, ops::Range, path::Path, sync::Arc};

use thiserror::Error;

pub use bisection::Descendant;
pub use bodies::BodyRange;
pub use brick::{brick, brick_counts};
pub use contact_surface::{ContactSurface, SurfaceFace};
pub use face_part::SidePart;
pub(crate) use face_part::{area_share, quarters_of, triangle_in_box};
pub use glue::GluedNode;
pub(crate) use glue::whole;
pub use gmsh::{FilePosition, GmshError, GmshFlaw, digest_of, parse as parse_gmsh};
pub use inspection::{FaceInspection, MeshInspection};
pub use macro_elements::macro_elements;
pub use material_nodes::MaterialNodes;
pub use obstacle::TriangulatedSurface;
pub(crate) use obstacle::{DistanceBetweenNodes, distances_from, outward_before};
pub use opposite::Opposite;
pub use quadratic::{IsoparametricMap, MidEdgeNodes};
pub use refined::{RefinableBody, RefinedLevel};
pub(crate) use side::SidePoint;
pub use side::{Quality, is_straight, shape, sorted};

use crate::scene::{Clamp, ElementOrder, InvalidValue, Scene, Written, nearest};

/// What the digits of mesh files and of typed numbers leave of places, directions and areas, relative to the size of what they belong
/// to: far more than roundings and the tolerance of CAD kernels (1e-8 of the part), far less than any element worth having.
pub(crate) const GEOMETRY_TOLERANCE: f64 = 1e-6;

/// Largest depth of an interference, and largest gap between glued faces, over the size of the body: what is pressed apart or drawn together
/// by more is not deformed slightly.
pub(crate) const DEEPEST_INTERFERENCE: f64 = 0.1;

/// Roundings of coordinates in mesh files, and of typed coordinates, over the lengths that they make.
const COORDINATE_ROUNDING: f64 = 1e-9;

/// Why a scene has no usable mesh.
#[derive(Debug, Error)]
pub enum MeshError {
    /// The scene asks for what the mesh does not have.
    #[error(transparent)]
    Scene(#[from] InvalidValue),
    /// The mesh file.
    #[error(transparent)]
    Gmsh(#[from] GmshError),
}

/// Nodes, tetrahedra and named boundary of a body, before the scene's parts are found on it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawMesh {
    /// Node coordinates, `[n_nodes]`, in m.
    pub coordinates: Vec<[f64; 3]>,
    /// Nodes of each tetrahedron, `[n_tetrahedra]`, positively oriented.
    pub tetrahedra: Vec<[usize; 4]>,
    /// Physical volume of each tetrahedron as an index into `group_names`; empty without groups.
    pub tetrahedron_group: Vec<usize>,
    /// Names of the physical volumes.
    pub group_names: Vec<String>,
    /// Nodes of each boundary triangle, `[n_facets]`, counter-clockwise seen from outside.
    pub facets: Vec<[usize; 3]>,
    /// The face of each boundary triangle as an index into `face_names`, `[n_facets]`.
    pub facet_face: Vec<usize>,
    /// Names of the faces.
    pub face_names: Vec<String>,
    /// Mid-edge nodes of each tetrahedron on [`TETRAHEDRON_EDGES`](crate::reference::TETRAHEDRON_EDGES), where the body comes with them.
    pub mid_edges: Option<Vec<[usize; 6]>>,
    /// Where each of several bodies lies; empty for one.
    pub bodies: Vec<BodyRange>,
    /// Obstacles of triangles, by the number of their contact in the scene.
    pub obstacles: BTreeMap<usize, Arc<TriangulatedSurface>>,
}

impl RawMesh {
    /// The body of a scene.
    fn of_scene(scene: &Scene, folder: &Path) -> Result<Self, MeshError> {
        let mut raw = Self::of_bodies(scene, folder)?;
        check_face_names(scene, &raw.face_names)?;
        let body = extents(&raw.coordinates).into_iter().fold(0.0, f64::max);
        raw.obstacles = obstacle::surfaces_of(scene, folder, body)?;
        Ok(raw)
    }
}

/// A conforming mesh of positively oriented tetrahedra.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Node coordinates, `[n_nodes]`, in m.
    pub coordinates: Vec<[f64; 3]>,
    /// Nodes of each tetrahedron, `[n_tetrahedra]`, positively oriented.
    pub tetrahedra: Vec<[usize; 4]>,
    /// Region of each tetrahedron, `[n_tetrahedra]`: 0 for the body's own material, k for the k-th
    /// region of the scene; empty in a scene without regions.
    pub tetrahedron_region: Vec<usize>,
    /// Nodes of each boundary triangle, `[n_facets]`, counter-clockwise seen from outside.
    pub facets: Vec<[usize; 3]>,
    /// The face of each boundary triangle as an index into `face_names`, `[n_facets]`.
    pub facet_face: Vec<usize>,
    /// Names of the faces.
    pub face_names: Vec<String>,
    /// Mid-edge nodes; `None` in a mesh of linear tetrahedra.
    pub mid_edges: Option<MidEdgeNodes>,
    /// Where each of several bodies lies; empty for one.
    pub bodies: Vec<BodyRange>,
    /// Obstacles of triangles, by the number of their contact in the scene.
    pub obstacles: BTreeMap<usize, Arc<TriangulatedSurface>>,
    /// Nodes that follow those of a face that theirs is glued to, before those that they follow; empty without glued faces.
    pub glued: Vec<GluedNode>,
    /// Of each pair of glued faces the largest distance in m that closes between them, negative where they overlap; 0 up to what triangles leave of curved faces.
    pub joint_gap: Vec<f64>,
    /// Of each pair the largest share of a triangle of both faces that is glued.
    pub joint_cover: Vec<[f64; 2]>,
    /// The contact face Γ_c; `None` in a scene without contact.
    pub contact: Option<ContactSurface>,
}

impl Mesh {
    /// Makes the mesh a scene asks for; mesh files are looked for in `folder`.
    ///
    /// # Errors
    /// [`MeshError`] for an unusable mesh file, and for faces and regions that the scene names and
    /// the mesh does not have.
    pub fn of_scene(scene: &Scene, folder: &Path) -> Result<Self, MeshError> {
        let raw = RawMesh::of_scene(scene, folder)?;
        let regions = side::assign(scene, &raw)?;
        Self::new(scene, raw, regions, None)
    }

    /// The mesh of the same scene with other cells of its brick.
    ///
    /// # Errors
    /// As [`Self::of_scene`].
    pub(crate) fn of_other_cells(&self, scene: &Scene) -> Result<Self, MeshError> {
        let raw = RawMesh {
            obstacles: self.obstacles.clone(),
            ..RawMesh::of_bodies(scene, Path::new(""))?
        };
        let regions = side::assign(scene, &raw)?;
        Self::new(scene, raw, regions, None)
    }

    /// A mesh of a scene's body with a region for each tetrahedron. One that was cut from a first one comes with what that left of
    /// curved contact faces, in m; the first one of a brick consists of whole cells.
    fn new(
        scene: &Scene,
        raw: RawMesh,
        tetrahedron_region: Vec<usize>,
        cut_faceting: Option<f64>,
    ) -> Result<Self, MeshError> {
        let mut mesh = Self::without_contact(scene, raw, tetrahedron_region)?;
        mesh.check_clamp_boxes(&scene.clamps)?;
        mesh.check_face_parts(scene)?;
        mesh.glue(scene, cut_faceting.unwrap_or(0.0))?;
        let mut held = mesh.held_nodes(scene);
        // As those of held nodes, their displacements are no unknowns of the contact face.
        let glued = mesh.glued.iter();
        glued.for_each(|glued| held[glued.node] = [true; 3]);
        let order = scene.contact_order().into_iter();
        let surfaces = order.map(|entry| mesh.contact_surface(scene, entry, cut_faceting, &held));
        mesh.contact = ContactSurface::joined(surfaces.collect::<Result<_, MeshError>>()?);
        if let Some(surface) = &mesh.contact {
            contact_parts::check_meeting(scene, &mesh, surface, &held)?;
        }
        Ok(mesh)
    }

    fn without_contact(
        scene: &Scene,
        raw: RawMesh,
        tetrahedron_region: Vec<usize>,
    ) -> Result<Self, InvalidValue> {
        let mut mesh = Self {
            coordinates: raw.coordinates,
            tetrahedra: raw.tetrahedra,
            tetrahedron_region,
            facets: raw.facets,
            facet_face: raw.facet_face,
            face_names: raw.face_names,
            mid_edges: None,
            bodies: raw.bodies,
            obstacles: raw.obstacles,
            glued: Vec::new(),
            joint_gap: Vec::new(),
            joint_cover: Vec::new(),
            contact: None,
        };
        mesh.set_element(scene.element(), raw.mid_edges)?;
        Ok(mesh)
    }

    /// Gives the tetrahedra the mid-edge nodes that quadratic ones have: those of the body, or new
    /// ones in the middle of straight edges.
    fn set_element(
        &mut self,
        element: ElementOrder,
        known: Option<Vec<[usize; 6]>>,
    ) -> Result<(), InvalidValue> {
        match (element, known) {
            (ElementOrder::P1, None) => Ok(()),
            (ElementOrder::P1, Some(_)) => Err(InvalidValue {
                key: "body.element".into(),
                expected: "\"P2\" for a mesh of second-order tetrahedra".into(),
                found: "\"P1\"".into(),
                help:
                    "set body.element = \"P2\", of several bodies in every [[body]], or make the mesh with elements of the first order"
                        .into(),
            }),
            (ElementOrder::P2, Some(known)) => {
                let corners = &self.tetrahedra;
                self.mid_edges = Some(MidEdgeNodes::with_facets(known, corners, &self.facets));
                Ok(())
            }
            (ElementOrder::P2, None) => {
                let (corners, facets) = (&self.tetrahedra, &self.facets);
                let middles = MidEdgeNodes::add_straight(&mut self.coordinates, corners, facets);
                self.mid_edges = Some(middles);
                Ok(())
            }
        }
    }

    /// A quarter of the volume of each tetrahedron at each of its corners in m³, `[n_nodes]`: weights with which means over nodes are those of
    /// the body, however its mesh is refined.
    #[must_use]
    pub fn corner_volumes(&self) -> Vec<f64> {
        let mut volumes = vec![0.0; self.coordinates.len()];
        for corners in &self.tetrahedra {
            let quarter = tetrahedron_volume(&self.corners(corners)) / 4.0;
            corners.iter().for_each(|&node| volumes[node] += quarter);
        }
        volumes
    }

    /// Which components of each node the clamps hold, and the tools that faces are bonded to, `[n_nodes, 3]`.
    #[must_use]
    pub fn held_nodes(&self, scene: &Scene) -> Vec<[bool; 3]> {
        let mut held = self.held_by(&scene.clamps);
        let of_tools = self.nodes_of_tools(scene);
        of_tools.for_each(|node| held[node] = [true; 3]);
        held
    }

    /// The nodes of the faces that are bonded to tools, some of them repeatedly.
    fn nodes_of_tools(&self, scene: &Scene) -> impl Iterator<Item = usize> {
        let faces = scene.tools.iter().filter_map(|tool| tool.face.as_ref());
        let facets = faces.flat_map(|face| self.facets_on(face));
        facets.flat_map(|facet| self.facet_nodes(facet))
    }

    /// Which components of each node some clamps hold, `[n_nodes, 3]`.
    pub(crate) fn held_by(&self, clamps: &[Clamp]) -> Vec<[bool; 3]> {
        let mut held = vec![[false; 3]; self.coordinates.len()];
        for clamp in clamps {
            for node in self.clamped_nodes(clamp) {
                for &component in &clamp.components {
                    held[node][component as usize] = true;
                }
            }
        }
        held
    }

    /// The nodes of a clamp, some of them repeatedly.
    pub fn clamped_nodes(&self, clamp: &Clamp) -> impl Iterator<Item = usize> {
        let facets = clamp.face.iter().flat_map(|face| self.facets_on(face));
        let all = (0..self.coordinates.len()).filter(|_| clamp.face.is_none());
        let nodes = facets.flat_map(|facet| self.facet_nodes(facet)).chain(all);
        nodes.filter(|&node| clamp.holds(&self.coordinates[node]))
    }

    /// Refuses a box that holds no node, which would have no effect.
    fn check_clamp_boxes(&self, clamps: &[Clamp]) -> Result<(), InvalidValue> {
        for (i, clamp) in clamps.iter().enumerate() {
            if let Some(corners) = clamp.corners
                && self.clamped_nodes(clamp).next().is_none()
            {
                return Err(InvalidValue {
                    key: format!("clamp.{i}.box"),
                    expected: format!(
                        "a box that holds at least one node of {}",
                        clamp.face.as_deref().unwrap_or("the mesh")
                    ),
                    found: Written(&corners).to_string(),
                    help: "a box around no node would hold nothing; move or widen it".into(),
                });
            }
        }
        Ok(())
    }

    /// Where each body lies.
    #[must_use]
    pub fn body_ranges(&self) -> Vec<BodyRange> {
        if self.bodies.is_empty() {
            return vec![BodyRange {
                name: String::new(),
                nodes: 0..self.coordinates.len(),
                tetrahedra: 0..self.tetrahedra.len(),
            }];
        }
        self.bodies.clone()
    }

    /// The nodes of a body.
    #[must_use]
    pub fn body_nodes(&self, body: usize) -> Range<usize> {
        let body = self.bodies.get(body);
        body.map_or(0..self.coordinates.len(), |body| body.nodes.clone())
    }

    /// The body that a node belongs to.
    #[must_use]
    pub fn body_of_node(&self, node: usize) -> usize {
        self.bodies.partition_point(|body| body.nodes.end <= node)
    }

    /// Largest extent of the body along a coordinate axis in m.
    #[must_use]
    pub fn extent(&self) -> f64 {
        extents(&self.coordinates).into_iter().fold(0.0, f64::max)
    }

    /// Corner coordinates of a tetrahedron or a triangle.
    #[must_use]
    pub fn corners<const K: usize>(&self, nodes: &[usize; K]) -> [[f64; 3]; K] {
        nodes.map(|node| self.coordinates[node])
    }

    /// Area in m² of the straight triangle between the corners of a boundary triangle.
    #[must_use]
    pub fn facet_area(&self, facet: usize) -> f64 {
        triangle_area(&self.corners(&self.facets[facet]))
    }

    /// Longest edge of a boundary triangle in m.
    pub(crate) fn longest_edge(&self, facet: usize) -> f64 {
        let [a, b, c] = self
            .corners(&self.facets[facet])
            .map(nalgebra::Vector3::from);
        (b - a).norm().max((c - b).norm()).max((a - c).norm())
    }

    /// The triangles of the obstacle of a contact of the scene, where it consists of some.
    #[must_use]
    pub fn surface_before(&self, entry: usize) -> Option<&TriangulatedSurface> {
        self.obstacles.get(&entry).map(Arc::as_ref)
    }

    /// The boundary triangles of one face, as indices; none for a name the mesh does not have.
    pub fn facets_on(&self, face: &str) -> impl Iterator<Item = usize> + '_ {
        let number = self.face_names.iter().position(|name| name == face);
        (0..self.facets.len()).filter(move |&f| Some(self.facet_face[f]) == number)
    }
}

/// Refuses a face that the scene names and the mesh does not have.
fn check_face_names(scene: &Scene, names: &[String]) -> Result<(), InvalidValue> {
    for (key, face) in scene.named_faces() {
        if !names.contains(&face) {
            return Err(InvalidValue {
                key,
                expected: format!("one of the mesh's faces: {}", names.join(", ")),
                found: Written(&face).to_string(),
                help: nearest(&face, names).unwrap_or_default()
                    + "physical surfaces of the Gmsh file name the faces",
            });
        }
    }
    Ok(())
}

/// The mean of the corners of a triangle or a tetrahedron.
pub(crate) fn centroid<const K: usize>(corners: &[[f64; 3]; K]) -> [f64; 3] {
    std::array::from_fn(|c| corners.iter().map(|x| x[c]).sum::<f64>() / K as f64)
}

/// Area of a triangle in m².
#[must_use]
pub fn triangle_area(corners: &[[f64; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(nalgebra::Vector3::from);
    (b - a).cross(&(c - a)).norm() / 2.0
}

/// Signed volume of a tetrahedron in m³, positive for the orientation used here.
#[must_use]
pub fn tetrahedron_volume(corners: &[[f64; 3]; 4]) -> f64 {
    let [a, b, c, d] = corners.map(nalgebra::Vector3::from);
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
}

/// How far points lie apart along each coordinate axis; −∞ without points.
#[must_use]
pub fn extents(points: &[[f64; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|c| {
        let values = points.iter().map(|x| x[c]);
        values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
    })
}

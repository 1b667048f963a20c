//! Conforming tetrahedral meshes of the body, their boundary and the contact surface.

mod brick;
mod contact_surface;
mod quality;

pub use brick::brick;
pub use contact_surface::ContactSurface;
pub use quality::Quality;

use crate::scene::{Body, Face, Scene};

/// A conforming mesh of positively oriented tetrahedra.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Node coordinates, `[n_nodes]`, in m.
    pub coordinates: Vec<[f64; 3]>,
    /// Nodes of each tetrahedron, `[n_tetrahedra]`, positively oriented.
    pub tetrahedra: Vec<[usize; 4]>,
    /// Nodes of each boundary triangle, `[n_facets]`, counter-clockwise seen from outside.
    pub facets: Vec<[usize; 3]>,
    /// The face each boundary triangle belongs to, `[n_facets]`.
    pub facet_face: Vec<Face>,
    /// The contact face Γ_c with its panes.
    pub contact: ContactSurface,
}

impl Mesh {
    /// Makes the mesh a scene asks for.
    #[must_use]
    pub fn of_scene(scene: &Scene) -> Self {
        let Body::Brick(spec) = &scene.body;
        brick(spec, scene.contact.face)
    }

    /// Corner coordinates of a tetrahedron or a triangle.
    #[must_use]
    pub fn corners<const K: usize>(&self, nodes: &[usize; K]) -> [[f64; 3]; K] {
        nodes.map(|node| self.coordinates[node])
    }

    /// The boundary triangles of one face.
    pub fn facets_on(&self, face: Face) -> impl Iterator<Item = &[usize; 3]> {
        self.facets
            .iter()
            .zip(&self.facet_face)
            .filter(move |(_, f)| **f == face)
            .map(|(t, _)| t)
    }
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

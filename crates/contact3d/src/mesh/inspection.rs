//! What a mesh file holds: faces, parts, sizes and quality, before any scene is written for it.

use std::path::Path;

use nalgebra::Vector3;

use super::{GmshError, Mesh, Quality, gmsh, tetrahedron_volume};
use crate::scene::GmshFile;

/// What a mesh file holds, in the unit of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshInspection {
    /// Nodes, mid-edge ones included.
    pub n_nodes: usize,
    /// Tetrahedra.
    pub n_tetrahedra: usize,
    /// Whether the tetrahedra are of the second order.
    pub is_quadratic: bool,
    /// Two opposite corners of the box around the body, [min, max].
    pub bounds: [[f64; 3]; 2],
    /// Edges, volumes and shapes.
    pub quality: Quality,
    /// The physical surfaces.
    pub faces: Vec<FaceInspection>,
    /// Nodes, tetrahedra and boundary triangles.
    pub mesh: Mesh,
    /// The physical volumes, with their numbers of tetrahedra and their volumes.
    pub parts: Vec<(String, usize, f64)>,
}

/// A physical surface.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceInspection {
    /// Its name.
    pub name: String,
    /// Its triangles.
    pub n_facets: usize,
    /// Their area.
    pub area: f64,
    /// The outward unit normal of a flat face; `None` where normals turn.
    pub normal: Option<[f64; 3]>,
    /// The mean of outward unit normals over the face; its length is 1 for a flat face and 0 for a closed one.
    pub mean_normal: [f64; 3],
}

impl MeshInspection {
    /// Reads a file of Gmsh, in its own unit.
    ///
    /// # Errors
    /// As for a scene with this file: [`GmshError`].
    pub fn read(path: &Path) -> Result<Self, GmshError> {
        let file = GmshFile {
            file: path.to_owned(),
            volume: None,
            unit: 1.0,
            digest: None,
        };
        let raw = gmsh::read(&file, Path::new(""))?;
        let is_quadratic = raw.mid_edges.is_some();
        let part = |number: usize, name: &String| {
            let own = (0..raw.tetrahedra.len()).filter(|&t| raw.tetrahedron_group[t] == number);
            let volume =
                |t: usize| tetrahedron_volume(&raw.tetrahedra[t].map(|n| raw.coordinates[n]));
            (name.clone(), own.clone().count(), own.map(volume).sum())
        };
        let parts = raw.group_names.iter().enumerate();
        let parts = parts.map(|(number, name)| part(number, name)).collect();
        let mesh = Mesh {
            coordinates: raw.coordinates,
            tetrahedra: raw.tetrahedra,
            facets: raw.facets,
            facet_face: raw.facet_face,
            face_names: raw.face_names,
            ..Mesh::default()
        };
        let end = |pick: fn(f64, f64) -> f64| {
            let places = mesh.coordinates.iter().copied();
            places
                .reduce(|a, b| std::array::from_fn(|c| pick(a[c], b[c])))
                .unwrap_or_default()
        };
        Ok(Self {
            n_nodes: mesh.coordinates.len(),
            n_tetrahedra: mesh.tetrahedra.len(),
            is_quadratic,
            bounds: [end(f64::min), end(f64::max)],
            quality: Quality::of(&mesh),
            faces: mesh
                .face_names
                .iter()
                .map(|name| face(&mesh, name))
                .collect(),
            parts,
            mesh,
        })
    }
}

fn face(mesh: &Mesh, name: &str) -> FaceInspection {
    let areas: Vec<Vector3<f64>> = mesh
        .facets_on(name)
        .map(|facet| {
            let [a, b, c] = mesh.corners(&mesh.facets[facet]).map(Vector3::from);
            (b - a).cross(&(c - a)) / 2.0
        })
        .collect();
    let sum: Vector3<f64> = areas.iter().sum();
    let mean = sum.normalize();
    let area = areas.iter().map(Vector3::norm).sum();
    // No triangle is turned more than a tenth of a degree, of which 1 − cos is 1.5e-6.
    let is_flat = areas
        .iter()
        .all(|area| area.dot(&mean) >= (1.0 - 1.5e-6) * area.norm());
    FaceInspection {
        name: name.to_owned(),
        n_facets: areas.len(),
        area,
        normal: is_flat.then(|| mean.into()),
        mean_normal: (sum / area).into(),
    }
}

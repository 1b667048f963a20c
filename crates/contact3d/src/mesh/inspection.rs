//! What a mesh file holds: faces, parts, sizes and quality, before any scene is written for it.

use std::path::Path;

use nalgebra::Vector3;
use rstar::{RTree, primitives::GeomWithData};

use super::{GmshError, Mesh, Quality, RawMesh, centroid, gmsh, tetrahedron_volume};
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
    /// Reads a file of Gmsh, in its own unit; physical volumes that share no nodes are bodies, whose names their faces begin with.
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
        let raw = match gmsh::read(&file, Path::new("")) {
            Ok(raw) => raw,
            Err(flaw) => volumes_of(&file).ok_or(flaw)?,
        };
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
            bodies: raw.bodies,
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

impl MeshInspection {
    /// The faces of different bodies that lie on each other somewhere, by the nearest of their triangles.
    #[must_use]
    pub fn meeting_faces(&self) -> Vec<[&str; 2]> {
        let of = |face: usize| {
            let facet = self.mesh.facets_on(&self.faces[face].name).next();
            facet.map(|facet| self.mesh.body_of_node(self.mesh.facets[facet][0]))
        };
        let trees: Vec<_> = self
            .faces
            .iter()
            .map(|face| self.middles_of(face))
            .collect();
        let pairs = (0..trees.len()).flat_map(|k| (0..k).map(move |first| [first, k]));
        let pairs = pairs.filter(|[a, b]| of(*a) != of(*b));
        let pairs = pairs.filter(|[a, b]| trees[*a].iter().any(|it| is_on(it, &trees[*b])));
        pairs
            .map(|pair| pair.map(|k| &*self.faces[k].name))
            .collect()
    }

    /// The middles of the triangles of a face with their area vectors.
    fn middles_of(&self, face: &FaceInspection) -> RTree<GeomWithData<[f64; 3], Vector3<f64>>> {
        let facets = self.mesh.facets_on(&face.name);
        let middles = facets.map(|facet| {
            let corners = self.mesh.corners(&self.mesh.facets[facet]);
            let [a, b, c] = corners.map(Vector3::from);
            GeomWithData::new(centroid(&corners), (b - a).cross(&(c - a)) / 2.0)
        });
        RTree::bulk_load(middles.collect())
    }
}

/// Whether a triangle looks at the nearest one of another face, beside it and in its plane to a tenth of the size of the larger one.
fn is_on(
    triangle: &GeomWithData<[f64; 3], Vector3<f64>>,
    others: &RTree<GeomWithData<[f64; 3], Vector3<f64>>>,
) -> bool {
    let Some(other) = others.nearest_neighbor(*triangle.geom()) else {
        return false;
    };
    let way = Vector3::from(*other.geom()) - Vector3::from(*triangle.geom());
    let reach = triangle.data.norm().max(other.data.norm()).sqrt();
    let turn = triangle.data.angle(&other.data).to_degrees();
    let along = way.dot(&triangle.data.normalize()).abs();
    turn > 150.0 && along < 0.1 * reach && way.norm() < 2.0 * reach
}

/// The physical volumes of a file as bodies of their own; `None` where they are none.
fn volumes_of(file: &GmshFile) -> Option<RawMesh> {
    let names = gmsh::volume_names(&file.file);
    let mut joined = RawMesh::default();
    for name in &names {
        let volume = GmshFile {
            volume: Some(name.clone()),
            ..file.clone()
        };
        let raw = gmsh::read(&volume, Path::new("")).ok()?;
        joined.append(raw, name.replace(['.', ' '], "_"), [0.0; 3]);
    }
    joined.group_names.clone_from(&names);
    (names.len() > 1).then_some(joined)
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

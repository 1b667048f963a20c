//! The picture of a mesh file.

use std::path::PathBuf;

use contact3d::{mesh::MeshInspection, scene::escape_control};
use plots::{MeshPicture, mesh_page};

use super::{PictureFolder, picture::PAGE_WIDTH};
use crate::pipeline::StageError;

/// Its name.
pub(super) const MESH: &str = "mesh";

/// Draws the faces of a mesh by their names, as SVG and PNG; returns the files.
pub fn draw_mesh(
    folder: &PictureFolder,
    title: &str,
    inspection: &MeshInspection,
) -> Result<Vec<PathBuf>, StageError> {
    let mesh = &inspection.mesh;
    let names: Vec<String> = mesh
        .face_names
        .iter()
        .map(|name| escape_control(name))
        .collect();
    let page = mesh_page(&MeshPicture {
        title: &escape_control(title),
        coordinates: &mesh.coordinates,
        triangles: &mesh.facets,
        face: &mesh.facet_face,
        names: &names,
    });
    folder.save([(MESH, page, PAGE_WIDTH)])
}

//! The mesh of a scene, and the file it may come from.

use std::{fs, path::PathBuf};

use contact3d::{
    mesh::{Mesh, MeshError, Refinement, digest_of},
    scene::{GmshFile, Invalid, SceneFile},
};

use super::{StageError, resources};

/// The mesh of a scene after a refinement.
///
/// # Errors
/// A mesh the scene cannot have, a mesh file that cannot be used.
pub fn mesh_of(input: &SceneFile, refinement: &Refinement) -> Result<Mesh, StageError> {
    let mesh = Mesh::refined(&input.scene, &input.folder, refinement);
    mesh.map_err(|error| refused(input, error))
}

/// A mesh that cannot be, with the line of the scene that asks for it.
pub(super) fn refused(input: &SceneFile, error: MeshError) -> StageError {
    match error {
        MeshError::Scene(invalid) => input.refuse(invalid).into(),
        MeshError::Gmsh(error) => error.into(),
    }
}

/// The mesh file that a scene names.
#[must_use]
pub fn mesh_file(input: &SceneFile) -> Option<PathBuf> {
    Some(input.folder.join(&input.scene.body.mesh_file()?.file))
}

/// Writes the digest of a mesh file into the scene, so that a changed file makes the mesh stale. A
/// file that is too large to be read is not even digested.
///
/// # Errors
/// A file that cannot be read, or is not the one of the digest in the scene; too little memory for
/// it.
pub fn pin_mesh_file(input: &mut SceneFile) -> Result<(), StageError> {
    let Some(mut gmsh) = input.scene.body.mesh_file().cloned() else {
        return Ok(());
    };
    pin(&mut gmsh, input)?;
    if let Some(own) = input.scene.body.mesh_file_mut() {
        *own = gmsh;
    }
    Ok(())
}

/// The same for a mesh file of the body of a scene.
///
/// # Errors
/// As [`pin_mesh_file`].
pub(super) fn pin(gmsh: &mut GmshFile, input: &SceneFile) -> Result<(), StageError> {
    let path = input.folder.join(&gmsh.file);
    if let Ok(metadata) = fs::metadata(&path) {
        resources::admit_memory(resources::need_of_mesh_file(metadata.len()))?;
    }
    let digest = digest_of(&path).map_err(|error| {
        input.refuse(Invalid {
            key: "body.gmsh.file".into(),
            expected: "a Gmsh file that can be read, beside the scene".into(),
            found: format!("{}: {error}", path.display()),
            help: "paths are relative to the scene file".into(),
        })
    })?;
    if gmsh.digest.as_ref().is_some_and(|given| *given != digest) {
        return Err(input
            .refuse(Invalid {
                key: "body.gmsh.digest".into(),
                expected: "the digest of the file".into(),
                found: digest,
                help: "the mesh file has changed; remove the key to accept it".into(),
            })
            .into());
    }
    gmsh.digest = Some(digest);
    Ok(())
}

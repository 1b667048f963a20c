//! The stage `mesh`, and the mesh file that a scene names.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use contact3d::{
    Problem,
    contact::Interface,
    elasticity::{Loads, prescribed_displacements, refuse_rigid_motions},
    mesh::{Mesh, MeshError, Quality, RefinedLevel, digest_of},
    scene::{InvalidValue, Obstacle, Scene, SceneFile},
};
use runfile::{GroupWriter, Reader, StoreError};

use super::{StageError, resources};
use crate::format;

/// Makes the mesh after some cuts unless it is made, and tries loads, prescribed displacements, gap and friction on it.
///
/// # Errors
/// A mesh or loads the scene cannot have, too little memory or disk space.
pub(super) fn make(
    input: &SceneFile,
    refinement: &[RefinedLevel],
    made: Option<Mesh>,
    run_file: &Path,
) -> Result<Problem, StageError> {
    resources::admit(resources::need_of_mesh(input), run_file)?;
    let mesh = Arc::new(match made {
        Some(mesh) => mesh,
        None => mesh_of(input, refinement)?,
    });
    let scene = &input.scene;
    let tried = refuse_rigid_motions(scene, &mesh)
        .and_then(|()| try_loads(scene, &mesh))
        .and_then(|()| try_steps(scene, &mesh))
        .and_then(|()| Problem::of_checked(scene.clone(), mesh));
    Ok(tried.map_err(|invalid| input.refuse(invalid))?)
}

fn try_loads(scene: &Scene, mesh: &Mesh) -> Result<(), InvalidValue> {
    Loads::of(scene).nodal_forces(mesh)?;
    prescribed_displacements(scene, mesh).map(drop)
}

/// Tries loads and gap of every step of a load history: between two ends they are means.
fn try_steps(scene: &Scene, mesh: &Mesh) -> Result<(), InvalidValue> {
    for (step, at_end) in scene.at_ends().enumerate() {
        let at_end = at_end?;
        let tried = try_loads(&at_end, mesh).and_then(|()| Interface::new(&at_end, mesh).map(drop));
        tried.map_err(|invalid| invalid.in_step(step))?;
    }
    Ok(())
}

/// The scene on its stored mesh.
pub(super) fn read(reader: &Reader, input: &SceneFile) -> Result<Problem, StageError> {
    let mesh = Arc::new(format::read_mesh(reader)?);
    let problem = Problem::of_checked(input.scene.clone(), mesh);
    Ok(problem.map_err(|invalid| input.refuse(invalid))?)
}

/// Writes the mesh with its quality.
pub(super) fn write(writer: &mut GroupWriter<'_>, problem: &Problem) -> Result<(), StoreError> {
    let (mesh, interface) = (problem.mesh(), problem.interface());
    let names = interface.map_or(&[][..], |laws| &laws.names);
    format::write_mesh(writer, mesh, names, &Quality::of(mesh))
}

/// The mesh of a scene after a refinement.
pub fn mesh_of(input: &SceneFile, refinement: &[RefinedLevel]) -> Result<Mesh, StageError> {
    let mesh = Mesh::refined(&input.scene, &input.folder, refinement);
    mesh.map_err(|error| match error {
        MeshError::Scene(invalid) => input.refuse(invalid).into(),
        MeshError::Gmsh(error) => error.into(),
    })
}

/// The files of meshes and of obstacles that a scene names.
pub fn mesh_files(input: &SceneFile) -> Vec<PathBuf> {
    let mut input = input.clone();
    let folder = std::mem::take(&mut input.folder);
    let files = named_files(&mut input.scene).into_iter();
    files.map(|(_, _, file, _)| folder.join(file)).collect()
}

/// The key, the kind, the path and the digest of each file that a scene names.
fn named_files(scene: &mut Scene) -> Vec<(String, &'static str, PathBuf, &mut Option<String>)> {
    let body_keys: Vec<String> = (0..scene.bodies.len()).map(|k| scene.body_key(k)).collect();
    let contact_keys: Vec<String> = (0..scene.contacts.len())
        .map(|entry| scene.contact_key(entry))
        .collect();
    let meshes = scene.bodies.iter_mut().zip(body_keys);
    let meshes = meshes.filter_map(|(body, key)| {
        let gmsh = body.gmsh.as_mut()?;
        let file = gmsh.file.clone();
        Some((format!("{key}.gmsh"), "a Gmsh file", file, &mut gmsh.digest))
    });
    let surfaces = scene.contacts.iter_mut().zip(contact_keys);
    let surfaces = surfaces.filter_map(|(contact, key)| {
        let Some(Obstacle::Surface(surface)) = &mut contact.obstacle else {
            return None;
        };
        let file = surface.file.clone();
        let key = format!("{key}.obstacle.surface");
        Some((key, "an STL or Gmsh file", file, &mut surface.digest))
    });
    meshes.chain(surfaces).collect()
}

/// Writes the digests of the files that a scene names into it, so that a changed file makes the mesh stale. A
/// file that is too large to be read is not even digested.
///
/// # Errors
/// A file that cannot be read, or is not the one of the digest in the scene; too little memory for
/// it.
pub fn pin_mesh_file(input: &mut SceneFile) -> Result<(), StageError> {
    let mut scene = input.scene.clone();
    for (key, kind, file, given) in named_files(&mut scene) {
        let path = input.folder.join(&file);
        if let Ok(metadata) = fs::metadata(&path) {
            resources::admit_memory(resources::need_of_mesh_file(metadata.len()))?;
        }
        let digest = digest_of(&path).map_err(|error| {
            input.refuse(InvalidValue {
                key: format!("{key}.file"),
                expected: format!("{kind} that can be read, beside the scene"),
                found: format!("{}: {error}", path.display()),
                help: "paths are relative to the scene file".into(),
            })
        })?;
        if given.as_ref().is_some_and(|given| *given != digest) {
            return Err(input
                .refuse(InvalidValue {
                    key: format!("{key}.digest"),
                    expected: "the digest of the file".into(),
                    found: digest,
                    help: "the file has changed; remove the key to accept it".into(),
                })
                .into());
        }
        *given = Some(digest);
    }
    input.scene = scene;
    Ok(())
}

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
    scene::{GmshFile, InvalidValue, Scene, SceneFile},
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
        tried.map_err(|invalid| InvalidValue {
            key: format!("step.{step}"),
            expected: format!("{}: {}", invalid.key, invalid.expected),
            ..invalid
        })?;
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

/// The mesh files that a scene names.
pub fn mesh_files(input: &SceneFile) -> Vec<PathBuf> {
    let files = input
        .scene
        .bodies
        .iter()
        .filter_map(|body| body.gmsh.as_ref());
    files.map(|gmsh| input.folder.join(&gmsh.file)).collect()
}

/// Writes the digest of a mesh file into the scene, so that a changed file makes the mesh stale. A
/// file that is too large to be read is not even digested.
///
/// # Errors
/// A file that cannot be read, or is not the one of the digest in the scene; too little memory for
/// it.
pub fn pin_mesh_file(input: &mut SceneFile) -> Result<(), StageError> {
    for body in 0..input.scene.bodies.len() {
        let Some(mut gmsh) = input.scene.bodies[body].gmsh.clone() else {
            continue;
        };
        pin(&mut gmsh, &input.scene.body_key(body), input)?;
        input.scene.bodies[body].gmsh = Some(gmsh);
    }
    Ok(())
}

/// The same for a mesh file of a body of a scene under its key.
fn pin(gmsh: &mut GmshFile, body: &str, input: &SceneFile) -> Result<(), StageError> {
    let path = input.folder.join(&gmsh.file);
    if let Ok(metadata) = fs::metadata(&path) {
        resources::admit_memory(resources::need_of_mesh_file(metadata.len()))?;
    }
    let digest = digest_of(&path).map_err(|error| {
        input.refuse(InvalidValue {
            key: format!("{body}.gmsh.file"),
            expected: "a Gmsh file that can be read, beside the scene".into(),
            found: format!("{}: {error}", path.display()),
            help: "paths are relative to the scene file".into(),
        })
    })?;
    if gmsh.digest.as_ref().is_some_and(|given| *given != digest) {
        return Err(input
            .refuse(InvalidValue {
                key: format!("{body}.gmsh.digest"),
                expected: "the digest of the file".into(),
                found: digest,
                help: "the mesh file has changed; remove the key to accept it".into(),
            })
            .into());
    }
    gmsh.digest = Some(digest);
    Ok(())
}

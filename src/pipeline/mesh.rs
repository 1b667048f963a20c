//! The stage `mesh`, and the mesh file that a scene names.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use contact3d::{
    contact::Interface,
    elasticity::{Loads, prescribed_displacements, refuse_rigid_motions},
    mesh::{Mesh, MeshError, Quality, Refinement, digest_of},
    scene::{
        Body, Clamp, Contact, GmshFile, Invalid, MultiplierSpace, Obstacle, Parameters, Part,
        Scene, SceneFile, Shape,
    },
    solver::ContactState,
};
use runfile::{GroupWriter, Reader, StoreError};
use serde::Serialize;

use super::{StageError, resources};
use crate::format;

/// What the stage depends on.
pub(super) struct Inputs<'a> {
    pub(super) input: &'a SceneFile,
    /// The cuts that lead from the first mesh to this one.
    pub(super) refinement: &'a Refinement,
    /// Where the mesh will be stored.
    pub(super) run_file: &'a Path,
}

/// The mesh of a scene with the laws of its contact face.
#[derive(Debug)]
pub(super) struct Meshed {
    pub(super) mesh: Arc<Mesh>,
    /// `None` without contact.
    pub(super) interface: Option<Interface>,
}

/// Makes the mesh, and tries loads, prescribed displacements, gap and friction on it.
///
/// # Errors
/// A mesh or loads the scene cannot have, too little memory or disk space.
pub(super) fn run(inputs: &Inputs<'_>) -> Result<Meshed, StageError> {
    let Inputs {
        input,
        refinement,
        run_file,
    } = inputs;
    let need = match &input.scene.body.shape {
        Shape::Brick(brick) => resources::need_of_brick(brick, input.scene.body.element),
        Shape::Gmsh(gmsh) => {
            let file = fs::metadata(input.folder.join(&gmsh.file));
            resources::need_of_mesh_file(file.map_or(0, |file| file.len()))
        }
    };
    resources::admit(need, run_file)?;
    let mesh = mesh_of(input, refinement)?;
    refuse_rigid_motions(&input.scene, &mesh)
        .and_then(|()| Loads::of(&input.scene).nodal_forces(&mesh).map(drop))
        .and_then(|()| prescribed_displacements(&input.scene, &mesh).map(drop))
        .and_then(|()| try_steps(&input.scene, &mesh))
        .map_err(|invalid| input.refuse(invalid))?;
    Meshed::new(Arc::new(mesh), input)
}

/// Tries loads and gap of every step of a load history: between two ends they are means.
fn try_steps(scene: &Scene, mesh: &Mesh) -> Result<(), Invalid> {
    let increments = scene.increments().into_iter();
    for end in increments.filter(|increment| increment.share >= 1.0) {
        let at_end = scene.at_increment(end)?;
        let tried = Loads::of(&at_end).nodal_forces(mesh).map(drop);
        let tried = tried.and_then(|()| prescribed_displacements(&at_end, mesh).map(drop));
        let tried = tried.and_then(|()| Interface::new(&at_end, mesh).map(drop));
        tried.map_err(|invalid| Invalid {
            key: format!("step.{}", end.step),
            expected: format!("{}: {}", invalid.key, invalid.expected),
            ..invalid
        })?;
    }
    Ok(())
}

/// Reads the mesh back.
///
/// # Errors
/// Missing or altered datasets; laws of the contact face that no problem can have.
pub(super) fn read(reader: &Reader, input: &SceneFile) -> Result<Meshed, StageError> {
    Meshed::new(Arc::new(format::read_mesh(reader)?), input)
}

/// Writes the mesh with its quality.
pub(super) fn write(writer: &mut GroupWriter<'_>, meshed: &Meshed) -> Result<(), StoreError> {
    let names = meshed
        .interface
        .as_ref()
        .map_or(&[][..], |laws| &laws.names);
    format::write_mesh(writer, &meshed.mesh, names, &Quality::of(&meshed.mesh))
}

/// The part of a scene that the stage depends on directly.
#[derive(Serialize)]
pub(super) struct Settings<'a> {
    body: &'a Body,
    /// Digest of the refinement; none for the body's own mesh.
    refinement: Option<&'a str>,
    /// At zero: the mesh does not depend on the displacements of clamps.
    clamp: Vec<Clamp>,
    contact_face: Option<&'a str>,
    multipliers: Option<MultiplierSpace>,
    #[serde(skip_serializing_if = "Option::is_none")]
    obstacle: Option<&'a Obstacle>,
    parts: Vec<&'a Part>,
    /// The contact faces, where they are more than one whole face.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    contacts: Vec<FaceSettings<'a>>,
    /// What the formulas of obstacles use.
    #[serde(skip_serializing_if = "Parameters::is_empty")]
    parameters: Parameters,
}

/// Whether a key is one of an obstacle, whose normals and distances are part of the mesh.
pub(super) fn of_obstacle(key: &str) -> bool {
    key.starts_with("contact.") && key.contains(".obstacle.")
}

/// What the mesh depends on of one of several contact faces, in the order of their multipliers.
#[derive(Serialize)]
struct FaceSettings<'a> {
    name: &'a str,
    face: &'a str,
    #[serde(rename = "box")]
    corners: Option<[[f64; 3]; 2]>,
    multipliers: MultiplierSpace,
    #[serde(skip_serializing_if = "Option::is_none")]
    obstacle: Option<&'a Obstacle>,
}

impl<'a> Settings<'a> {
    pub(super) fn of(scene: &'a Scene, refinement: Option<&'a str>) -> Self {
        Self {
            body: &scene.body,
            refinement,
            clamp: scene.clamps.iter().map(Clamp::at_zero).collect(),
            contact_face: only_contact(scene).map(|c| c.face.as_str()),
            multipliers: only_contact(scene).map(|c| c.multipliers),
            obstacle: only_contact(scene).and_then(|c| c.obstacle.as_ref()),
            parts: scene.regions.iter().map(|region| &region.part).collect(),
            contacts: match only_contact(scene) {
                Some(contact) if contact.corners.is_none() => Vec::new(),
                _ => contacts_in_order(scene).map(FaceSettings::of).collect(),
            },
            parameters: scene.parameters_used(of_obstacle),
        }
    }
}

impl<'a> FaceSettings<'a> {
    fn of(contact: &'a Contact) -> Self {
        Self {
            name: contact.name(),
            face: &contact.face,
            corners: contact.corners,
            multipliers: contact.multipliers,
            obstacle: contact.obstacle.as_ref(),
        }
    }
}

/// The contact face of a scene with one, whose stages are named as those of scenes always were.
pub(super) fn only_contact(scene: &Scene) -> Option<&Contact> {
    match scene.contacts.as_slice() {
        [only] => Some(only),
        _ => None,
    }
}

/// The contact faces of a scene with several, in the order of their multipliers; none for one.
pub(super) fn several_contacts(scene: &Scene) -> impl Iterator<Item = (usize, &Contact)> {
    let order = match scene.contacts.len() {
        1 => Vec::new(),
        _ => scene.contact_order(),
    };
    order.into_iter().map(|i| (i, &scene.contacts[i]))
}

fn contacts_in_order(scene: &Scene) -> impl Iterator<Item = &Contact> {
    let order = scene.contact_order().into_iter();
    order.map(|i| &scene.contacts[i])
}

impl Meshed {
    /// The laws of a scene on a mesh of its body.
    ///
    /// # Errors
    /// Laws that no problem can have.
    pub(super) fn new(mesh: Arc<Mesh>, input: &SceneFile) -> Result<Self, StageError> {
        let interface = Interface::new(&input.scene, &mesh);
        let interface = interface.map_err(|invalid| input.refuse(invalid))?;
        Ok(Self { mesh, interface })
    }

    /// The contact face and its laws; `None` without contact.
    pub(super) fn contact(&self) -> Option<ContactState<'_>> {
        Some(ContactState {
            surface: self.mesh.contact.as_ref()?,
            interface: self.interface.as_ref()?,
        })
    }
}

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

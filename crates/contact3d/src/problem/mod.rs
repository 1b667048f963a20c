//! A scene from its mesh to its report, in memory: what a user of this crate begins with.
//!
//! [`Problem`] is a scene that fits its mesh, [`AssembledProblem`] the same with the stiffness
//! factorised, from which any number of solves start, also with other loads and other friction.

mod assembled;
mod error;
mod load_history;
mod reuse;

pub use assembled::AssembledProblem;
pub use error::ProblemError;
pub use load_history::SteppedProblem;

use std::{path::Path, sync::Arc};

use crate::{
    contact::{Interface, Past},
    elasticity::idle_loads,
    mesh::Mesh,
    scene::{Scene, SceneFile, Warning},
};

/// A scene on its mesh, with the laws of its contact face.
#[derive(Debug)]
pub struct Problem {
    scene: Scene,
    mesh: Arc<Mesh>,
    interface: Option<Interface>,
}

impl Problem {
    /// Checks a scene and meshes its body; a mesh file is looked for in the working directory.
    ///
    /// # Errors
    /// [`ProblemError::Invalid`] for a value that no problem of this kind can have,
    /// [`ProblemError::Mesh`] for an unusable mesh file.
    pub fn new(scene: Scene) -> Result<Self, ProblemError> {
        Self::in_folder(scene, Path::new(""))
    }

    /// As [`Self::new`], with a mesh file looked for in `folder`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn in_folder(scene: Scene, folder: &Path) -> Result<Self, ProblemError> {
        let scene = scene.checked()?;
        let mesh = Mesh::of_scene(&scene, folder)?;
        Self::of_checked(scene, Arc::new(mesh))
    }

    /// Reads a scene file and meshes its body; a mesh file is looked for beside the scene.
    ///
    /// # Errors
    /// As [`Self::new`], and [`ProblemError::Scene`] for a file that is no scene.
    pub fn read(path: &Path) -> Result<Self, ProblemError> {
        let file = SceneFile::read(path)?;
        Self::in_folder(file.scene, &file.folder)
    }

    /// A scene on a mesh of its body that exists already.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn on_mesh(scene: Scene, mesh: Mesh) -> Result<Self, ProblemError> {
        Self::of_checked(scene.checked()?, Arc::new(mesh))
    }

    /// A scene that has been checked, on a mesh of its body.
    pub fn of_checked(scene: Scene, mesh: Arc<Mesh>) -> Result<Self, ProblemError> {
        let interface = Interface::new(&scene, &mesh)?;
        Ok(Self {
            scene,
            mesh,
            interface,
        })
    }

    /// The same problem in a later step of a load history.
    fn after(mut self, past: Option<Past>) -> Self {
        if let Some(past) = past {
            self.interface = self.interface.map(|interface| interface.after(past));
        }
        self
    }

    /// Assembles the stiffness and factorises it, on the threads of rayon's current pool. The bits of the
    /// result do not depend on their number.
    ///
    /// # Errors
    /// [`ProblemError::Assembly`] when the stiffness has no Cholesky factor, a load no value, or the
    /// clamps let the body move as a rigid one.
    pub fn assemble(self) -> Result<AssembledProblem, ProblemError> {
        AssembledProblem::new(self)
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Its mesh.
    #[must_use]
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The laws of the contact face; `None` without contact.
    #[must_use]
    pub fn interface(&self) -> Option<&Interface> {
        self.interface.as_ref()
    }

    /// What is allowed in the scene and probably not meant.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = self.scene.warnings();
        warnings.extend(idle_loads(&self.scene, &self.mesh));
        if let Some(interface) = &self.interface {
            let length = self.scene.units.length();
            warnings.extend(interface.warnings(self.mesh.extent(), length));
        }
        warnings
    }
}

use std::path::Path;

use super::{ContactReport, SolveSceneError, Solved, SolvedContact};
use crate::{
    contact::Interface,
    dual::DualSystem,
    mesh::Mesh,
    scene::{Invalid, Scene, SolveSettings},
    solver::{ContactState, NeedsExplicit, Solution, Start, solve},
};

/// A scene meshed and assembled in memory, with all that was made on the way.
#[derive(Debug)]
pub struct AssembledScene {
    /// The scene.
    pub scene: Scene,
    /// Its mesh.
    pub mesh: Mesh,
    /// The laws of the contact face; `None` without contact.
    pub interface: Option<Interface>,
    /// A, l and the dual problem.
    pub system: DualSystem,
}

impl AssembledScene {
    /// Assembles a scene whose mesh file, if it has one, lies in `folder`.
    ///
    /// # Errors
    /// [`SolveSceneError`].
    pub fn new(scene: Scene, folder: &Path, threads: usize) -> Result<Self, SolveSceneError> {
        let mesh = Mesh::of_scene(&scene, folder)?;
        Self::on_mesh(scene, mesh, threads)
    }

    /// Assembles a scene on a mesh of its body.
    ///
    /// # Errors
    /// [`SolveSceneError`].
    pub fn on_mesh(scene: Scene, mesh: Mesh, threads: usize) -> Result<Self, SolveSceneError> {
        let system = DualSystem::new(&scene, &mesh, threads)?;
        let interface = Interface::new(&scene, &mesh)?;
        Ok(Self {
            scene,
            mesh,
            interface,
            system,
        })
    }

    /// Γ_c and its laws; `None` without contact.
    #[must_use]
    pub fn contact_state(&self) -> Option<ContactState<'_>> {
        let (surface, interface) = self.mesh.contact.as_ref().zip(self.interface.as_ref())?;
        Some(ContactState { surface, interface })
    }

    /// Solves from λ = 0; a solve that does not converge is a solution with a status.
    ///
    /// # Errors
    /// [`NeedsExplicit`] when Newton's method is asked for and S is not dense.
    pub fn solve(&self, settings: &SolveSettings) -> Result<Solution, NeedsExplicit> {
        solve(
            &self.system,
            self.contact_state().as_ref(),
            settings,
            Start::default(),
            &mut |_| {},
        )
    }

    /// Zones, stresses, resultants and certificate of a solution.
    ///
    /// # Errors
    /// A load that is not finite.
    pub fn report(&self, solution: &Solution) -> Result<ContactReport, Invalid> {
        let contact = self.system.contact.as_ref().zip(self.contact_state());
        ContactReport::new(&Solved {
            scene: &self.scene,
            mesh: &self.mesh,
            system: &self.system.assembly.primal,
            contact: contact.map(|(contact, state)| SolvedContact {
                coupling: &contact.coupling,
                state,
            }),
            solution,
        })
    }
}

use std::path::Path;

use super::{ContactReport, SolveSceneError, Solved, SolvedContact};
use crate::{
    contact::Interface,
    dual::DualSystem,
    mesh::Mesh,
    scene::{Invalid, Scene},
    solver::{ContactState, Solution, Start, solve},
};

/// A scene meshed, assembled and solved in memory, with all that was made on the way.
#[derive(Debug)]
pub struct SolvedScene {
    /// The scene.
    pub scene: Scene,
    /// Its mesh.
    pub mesh: Mesh,
    /// The laws of the contact face; `None` without contact.
    pub interface: Option<Interface>,
    /// A, l and the dual problem.
    pub system: DualSystem,
    /// λ and u, with the status of the solve.
    pub solution: Solution,
}

impl SolvedScene {
    /// Solves a scene whose mesh file, if it has one, lies in `folder`.
    ///
    /// # Errors
    /// [`SolveSceneError`]. A solve that does not converge is not an error: its status says so.
    pub fn new(scene: Scene, folder: &Path, threads: usize) -> Result<Self, SolveSceneError> {
        let mesh = Mesh::of_scene(&scene, folder)?;
        let system = DualSystem::new(&scene, &mesh, threads)?;
        let interface = Interface::new(&scene, &mesh)?;
        let solution = solve(
            &system,
            contact_state(&mesh, interface.as_ref()).as_ref(),
            &scene.solve,
            Start::default(),
            &mut |_| {},
        )?;
        Ok(Self {
            scene,
            mesh,
            interface,
            system,
            solution,
        })
    }

    /// Γ_c and its laws; `None` without contact.
    #[must_use]
    pub fn contact_state(&self) -> Option<ContactState<'_>> {
        contact_state(&self.mesh, self.interface.as_ref())
    }

    /// Zones, stresses, resultants and certificate.
    ///
    /// # Errors
    /// A load that is not finite.
    pub fn report(&self) -> Result<ContactReport, Invalid> {
        let contact = self.system.contact.as_ref().zip(self.contact_state());
        ContactReport::new(&Solved {
            scene: &self.scene,
            mesh: &self.mesh,
            system: &self.system.assembly.primal,
            contact: contact.map(|(contact, state)| SolvedContact {
                coupling: &contact.coupling,
                state,
            }),
            solution: &self.solution,
        })
    }
}

fn contact_state<'a>(mesh: &'a Mesh, interface: Option<&'a Interface>) -> Option<ContactState<'a>> {
    let (surface, interface) = mesh.contact.as_ref().zip(interface)?;
    Some(ContactState { surface, interface })
}

//! Any scene, assembled and solved as the program does it, without files.

use std::path::Path;

use contact3d_pipe::{
    contact::Interface,
    dual::DualSystem,
    mesh::Mesh,
    post::{ContactReport, Solved, SolvedContact},
    scene::Scene,
    solver::{ContactState, Solution, Start, solve},
};

pub(crate) struct Case {
    pub(crate) scene: Scene,
    pub(crate) mesh: Mesh,
    pub(crate) system: DualSystem,
    pub(crate) interface: Option<Interface>,
    pub(crate) solution: Solution,
}

impl Case {
    /// Solves a scene that needs no mesh file.
    pub(crate) fn new(scene: Scene) -> Self {
        Self::try_new(scene, Path::new("")).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Solves the scene of a text.
    pub(crate) fn of(text: &str) -> Self {
        Self::new(Scene::parse("test", text).unwrap_or_else(|error| panic!("{error}\n{text}")))
    }

    pub(crate) fn try_new(scene: Scene, folder: &Path) -> Result<Self, String> {
        let mesh = Mesh::of_scene(&scene, folder).map_err(|e| e.to_string())?;
        let system = DualSystem::new(&scene, &mesh, 1).map_err(|e| e.to_string())?;
        let interface = Interface::new(&scene, &mesh).map_err(|e| format!("{e:?}"))?;
        let state = state(&mesh, interface.as_ref());
        let solution = solve(
            &system,
            state.as_ref(),
            &scene.solve,
            Start::default(),
            &mut |_| {},
        );
        let solution = solution.map_err(|e| e.to_string())?;
        Ok(Self {
            scene,
            mesh,
            system,
            interface,
            solution,
        })
    }

    pub(crate) fn report(&self) -> ContactReport {
        let state = state(&self.mesh, self.interface.as_ref());
        let contact = self.system.contact.as_ref().zip(state);
        let solved = Solved {
            scene: &self.scene,
            mesh: &self.mesh,
            system: &self.system.assembly.primal,
            contact: contact.map(|(contact, state)| SolvedContact {
                coupling: &contact.coupling,
                state,
            }),
            solution: &self.solution,
        };
        ContactReport::new(&solved).expect("finite loads")
    }

    /// Displacement of every node in m.
    pub(crate) fn displacement(&self) -> Vec<[f64; 3]> {
        let dofs = &self.system.assembly.primal.dofs;
        dofs.to_nodes(&self.solution.displacement)
    }

    /// Numbers of panes m and of contact nodes.
    pub(crate) fn sizes(&self) -> (usize, usize) {
        let surface = self.mesh.contact.as_ref().expect("a contact face");
        (surface.n_panes(), surface.nodes.len())
    }
}

fn state<'a>(mesh: &'a Mesh, interface: Option<&'a Interface>) -> Option<ContactState<'a>> {
    let state = mesh.contact.as_ref().zip(interface);
    state.map(|(surface, interface)| ContactState { surface, interface })
}

//! Any scene, assembled and solved as the program does it, without files.

use std::path::Path;

use contact3d_pipe::{
    post::{ContactReport, SolvedScene},
    scene::Scene,
};

pub(crate) struct Case(pub(crate) SolvedScene);

impl std::ops::Deref for Case {
    type Target = SolvedScene;

    fn deref(&self) -> &SolvedScene {
        &self.0
    }
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
        let solved = SolvedScene::new(scene, folder, 1);
        solved.map(Self).map_err(|error| error.to_string())
    }

    pub(crate) fn report(&self) -> ContactReport {
        self.0.report().expect("finite loads")
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

//! Any scene, assembled and solved as the program does it, without files.

use std::path::Path;

use contact3d::{
    post::{AssembledScene, ContactReport, SolveSceneError},
    scene::Scene,
    solver::Solution,
};

pub(crate) struct Case {
    pub(crate) problem: AssembledScene,
    pub(crate) solution: Solution,
}

impl std::ops::Deref for Case {
    type Target = AssembledScene;

    fn deref(&self) -> &AssembledScene {
        &self.problem
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
        let solved = || -> Result<Self, SolveSceneError> {
            let problem = AssembledScene::new(scene, folder, 1)?;
            let solution = problem.solve(&problem.scene.solve)?;
            Ok(Self { problem, solution })
        };
        solved().map_err(|error| error.to_string())
    }

    pub(crate) fn report(&self) -> ContactReport {
        self.problem.report(&self.solution).expect("finite loads")
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

//! Any scene, assembled and solved as the program does it, without files.

use std::path::Path;

use contact3d::{
    AssembledProblem, Problem, ProblemError, contact::Interface, post::ContactReport, scene::Scene,
    solver::Solution,
};

/// A solved scene; the last increment of one with a load history.
pub(crate) struct Case {
    pub(crate) problem: AssembledProblem,
    pub(crate) solution: Solution,
}

impl std::ops::Deref for Case {
    type Target = AssembledProblem;

    fn deref(&self) -> &AssembledProblem {
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
        let solved = || -> Result<Self, ProblemError> {
            let problem = Problem::in_folder(scene, folder)?.assemble()?;
            if problem.scene().has_history() {
                let history = problem.solve_history(&problem.scene().solve)?;
                let (problem, solution) = (history.problem, history.solution);
                return Ok(Self { problem, solution });
            }
            let solution = problem.solve(&problem.scene().solve)?;
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

    /// The laws of the contact face.
    pub(crate) fn interface(&self) -> &Interface {
        self.contact_side().expect("contact").interface
    }

    /// Numbers of panes m and of contact nodes.
    pub(crate) fn sizes(&self) -> (usize, usize) {
        let surface = self.mesh().contact.as_ref().expect("a contact face");
        (surface.n_panes(), surface.nodes.len())
    }
}

//! What the integration tests share: scenes from `pipelines/` and a solve without files.
#![allow(dead_code, reason = "each test file uses a part of it")]

use std::path::{Path, PathBuf};

use contact3d_pipe::{
    dual::{Assembly, ImplicitOperator},
    mesh::Mesh,
    post::{ContactReport, Solved},
    scene::{Body, Scene},
    solver::{ContactState, Inner, Solution, successive_approximations},
};

/// The repository's `pipelines/` folder.
pub(crate) fn pipelines() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines")
}

/// The scene of one of the paper's tables at a refinement, 3 n_div × n_div × n_div cells.
pub(crate) fn hkl_scene(table: usize, n_div: usize) -> Scene {
    let name = format!("hkl2011_table{table}.toml");
    let text = std::fs::read_to_string(pipelines().join(&name)).expect("pipeline file");
    let mut scene = Scene::parse(&name, &text).expect("valid pipeline");
    let Body::Brick(brick) = &mut scene.body;
    brick.cells = [3 * n_div, n_div, n_div];
    scene
}

/// A problem assembled in memory.
pub(crate) struct Problem {
    pub(crate) mesh: Mesh,
    pub(crate) assembly: Assembly,
}

impl Problem {
    pub(crate) fn new(scene: &Scene) -> Self {
        let mesh = Mesh::of_scene(scene);
        let assembly = Assembly::new(scene, &mesh, 1).expect("positive definite stiffness");
        Self { mesh, assembly }
    }

    /// Algorithm 4.1 with KPRGP on the implicit operator.
    pub(crate) fn solve(&self, scene: &Scene) -> Solution {
        let frame = scene.contact.frame();
        let contact = ContactState {
            surface: &self.mesh.contact,
            frame: &frame,
            law: &scene.friction,
        };
        successive_approximations(
            Inner::Kprgp,
            &mut ImplicitOperator::new(&self.assembly),
            &self.assembly,
            &contact,
            &scene.solve,
            |_, _| {},
        )
    }

    pub(crate) fn report(&self, scene: &Scene, solution: &Solution) -> ContactReport {
        ContactReport::new(&Solved {
            scene,
            mesh: &self.mesh,
            system: &self.assembly.primal,
            solution,
        })
    }
}

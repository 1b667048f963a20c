//! What the integration tests share: scenes from `pipelines/` and a solve without files.
#![allow(dead_code, unused_imports, reason = "each test file uses a part of it")]

mod case;

use std::path::{Path, PathBuf};

use contact3d::{
    contact::Interface,
    dual::{Assembly, ContactSystem, ImplicitOperator},
    mesh::{ContactSurface, Mesh},
    post::{ContactReport, Solved, SolvedContact},
    scene::{Body, Scene},
    solver::{ContactState, Inner, Solution, Start, successive_approximations},
};

pub(crate) use case::Case;

/// The repository's `pipelines/` folder.
pub(crate) fn pipelines() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines")
}

/// The scene of one of the paper's tables at a refinement, 3 n_div × n_div × n_div cells.
pub(crate) fn hkl_scene(table: usize, n_div: usize) -> Scene {
    let name = format!("hkl2011_table{table}.toml");
    let text = std::fs::read_to_string(pipelines().join(&name)).expect("pipeline file");
    let mut scene = Scene::parse(&name, &text).expect("valid pipeline");
    refine(&mut scene, [3 * n_div, n_div, n_div]);
    scene
}

/// Sets the cells of a brick.
pub(crate) fn refine(scene: &mut Scene, cells: [usize; 3]) {
    match &mut scene.body {
        Body::Brick(brick) => brick.cells = cells,
        Body::Gmsh(_) => panic!("expected a brick"),
    }
}

/// A contact problem assembled in memory; S stays implicit.
pub(crate) struct Problem {
    pub(crate) mesh: Mesh,
    pub(crate) interface: Interface,
    pub(crate) assembly: Assembly,
    pub(crate) contact: ContactSystem,
}

impl Problem {
    pub(crate) fn new(scene: &Scene) -> Self {
        let mesh = Mesh::of_scene(scene, Path::new("")).expect("a brick");
        let interface = interface(scene, &mesh);
        let assembly = Assembly::new(scene, &mesh, 1).expect("positive definite stiffness");
        let surface = mesh.contact.as_ref().expect("a contact face");
        let contact = ContactSystem::new(&assembly, surface, &interface);
        Self {
            mesh,
            interface,
            assembly,
            contact,
        }
    }

    pub(crate) fn surface(&self) -> &ContactSurface {
        self.mesh.contact.as_ref().expect("a contact face")
    }

    fn state<'a>(&'a self, interface: &'a Interface) -> ContactState<'a> {
        ContactState {
            surface: self.surface(),
            interface,
        }
    }

    /// Algorithm 4.1 with KPRGP on the implicit operator, for a scene that may have another law.
    pub(crate) fn solve(&self, scene: &Scene) -> Solution {
        let interface = interface(scene, &self.mesh);
        successive_approximations(
            Inner::Kprgp,
            &mut ImplicitOperator::new(&self.assembly, &self.contact),
            &self.assembly,
            &self.state(&interface),
            interface.coulomb().expect("Coulomb friction"),
            &scene.solve,
            Start::default(),
            &mut |_| {},
        )
    }

    pub(crate) fn report(&self, scene: &Scene, solution: &Solution) -> ContactReport {
        let interface = interface(scene, &self.mesh);
        let solved = Solved {
            scene,
            mesh: &self.mesh,
            system: &self.assembly.primal,
            contact: Some(SolvedContact {
                coupling: &self.contact.coupling,
                state: self.state(&interface),
            }),
            solution,
        };
        ContactReport::new(&solved).expect("finite loads")
    }
}

fn interface(scene: &Scene, mesh: &Mesh) -> Interface {
    let interface = Interface::new(scene, mesh).expect("finite formulas");
    interface.expect("a scene with contact")
}

//! What the integration tests share: scenes from `pipelines/` and a solve without files.

mod case;

use std::path::{Path, PathBuf};

use contact3d::{
    AssembledProblem, Problem,
    dual::{Assembly, BodyOperator, ContactOperator, ContactSystem},
    mesh::{ContactSurface, Mesh},
    post::ContactReport,
    scene::{DualOperatorKind, Scene},
    solver::{
        ContactBody, ContactSide, Inner, MethodResult, Solution, Start, SuccessiveApproximations,
    },
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
    scene.as_brick_mut().expect("a brick").cells = cells;
}

/// A contact problem assembled in memory; S stays implicit.
pub(crate) struct Implicit(AssembledProblem);

impl Implicit {
    pub(crate) fn new(scene: &Scene) -> Self {
        let problem = Problem::new(implicit(scene)).expect("a brick in contact");
        let assembled = problem.assemble();
        Self(assembled.expect("positive definite stiffness"))
    }

    pub(crate) fn assembly(&self) -> &Assembly {
        &self.0.system.assembly
    }

    pub(crate) fn contact(&self) -> &ContactSystem {
        self.0.system.contact.as_ref().expect("contact")
    }

    pub(crate) fn mesh(&self) -> &Mesh {
        self.0.mesh()
    }

    pub(crate) fn state(&self) -> ContactSide<'_> {
        self.0.contact_side().expect("contact")
    }

    pub(crate) fn body(&self) -> ContactBody<'_> {
        ContactBody {
            assembly: self.assembly(),
            face: self.state(),
        }
    }

    pub(crate) fn surface(&self) -> &ContactSurface {
        self.state().surface
    }

    /// The same for a scene that may have another law.
    fn of(&self, scene: &Scene) -> AssembledProblem {
        let other = self.0.with_scene(implicit(scene));
        other.unwrap_or_else(|error| panic!("{error}"))
    }

    /// Algorithm 4.1 with KPRGP on the implicit operator, for a scene that may have another law.
    pub(crate) fn solve(&self, scene: &Scene) -> MethodResult {
        let problem = self.of(scene);
        let laws = problem.contact_side().expect("contact").laws();
        let mut operator = ContactOperator::implicit(self.assembly(), self.contact());
        let method = SuccessiveApproximations {
            inner: Inner::Kprgp,
            body: &self.body(),
            laws: &laws,
            law: laws.coulomb().expect("Coulomb friction"),
            settings: &scene.solve,
        };
        let mut held = BodyOperator::Constrained(&mut operator);
        method.solve(&mut held, Start::default(), &mut |_| {})
    }

    pub(crate) fn report(&self, scene: &Scene, solution: &Solution) -> ContactReport {
        self.of(scene).report(solution).expect("finite loads")
    }
}

fn implicit(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.assemble.dual_operator = DualOperatorKind::Implicit;
    scene
}

use std::path::Path;

use crate::{
    contact::Interface,
    dual::{DualSystem, ExplicitDual},
    linalg::norm,
    mesh::{ContactSurface, Mesh},
    post::{ContactReport, SolveSceneError, Solved, SolvedContact},
    scene::{DualOperatorKind, Invalid, Scene, SolveSettings},
    solver::{ContactState, Solution, Start, solve},
};

/// A stress this much below those of the load is none.
const ZERO: f64 = 1e-12;

/// A scene with contact, assembled in memory with the dense dual operator.
pub(super) struct Problem {
    pub(super) scene: Scene,
    pub(super) mesh: Mesh,
    interface: Interface,
    pub(super) system: DualSystem,
}

impl Problem {
    /// Assembles a scene; mesh files are looked for in `folder`.
    pub(super) fn new(
        scene: Scene,
        folder: &Path,
        threads: usize,
    ) -> Result<Self, SolveSceneError> {
        let mesh = Mesh::of_scene(&scene, folder)?;
        Self::on_mesh(scene, mesh, threads)
    }

    /// Assembles a scene on a mesh of its body.
    pub(super) fn on_mesh(
        mut scene: Scene,
        mesh: Mesh,
        threads: usize,
    ) -> Result<Self, SolveSceneError> {
        scene.assemble.dual_operator = DualOperatorKind::Explicit;
        let interface = Interface::new(&scene, &mesh)?.ok_or_else(no_contact)?;
        let system = DualSystem::new(&scene, &mesh, threads)?;
        Ok(Self {
            scene,
            mesh,
            interface,
            system,
        })
    }

    pub(super) fn surface(&self) -> &ContactSurface {
        self.mesh.contact.as_ref().expect("checked when assembled")
    }

    pub(super) fn contact(&self) -> ContactState<'_> {
        ContactState {
            surface: self.surface(),
            interface: &self.interface,
        }
    }

    pub(super) fn dual(&self) -> &ExplicitDual {
        let contact = self.system.contact.as_ref();
        let dual = contact.and_then(|contact| contact.explicit.as_ref());
        dual.expect("assembled with contact and the dense operator")
    }

    pub(super) fn solve(&self, settings: &SolveSettings) -> Result<Solution, SolveSceneError> {
        let contact = self.contact();
        let start = Start::default();
        let solution = solve(&self.system, Some(&contact), settings, start, &mut |_| {})?;
        Ok(solution)
    }

    pub(super) fn report(&self, solution: &Solution) -> Result<ContactReport, SolveSceneError> {
        let coupling = self
            .system
            .contact
            .as_ref()
            .map(|contact| &contact.coupling);
        Ok(ContactReport::new(&Solved {
            scene: &self.scene,
            mesh: &self.mesh,
            system: &self.system.assembly.primal,
            contact: coupling.map(|coupling| SolvedContact {
                coupling,
                state: self.contact(),
            }),
            solution,
        })?)
    }

    /// ‖λ' − λ‖ / ‖λ‖ for the answer λ. Where that is zero to rounding, over ‖ρh‖: the stresses that
    /// would push the free body back.
    pub(super) fn distance(&self, other: &[f64], answer: &[f64]) -> f64 {
        let difference: Vec<f64> = other.iter().zip(answer).map(|(x, y)| x - y).collect();
        let (difference, size) = (norm(&difference), norm(answer));
        if difference == 0.0 {
            return 0.0;
        }
        let dual = self.dual();
        let pushed: Vec<f64> = (0..answer.len())
            .filter(|&j| dual.column(j)[j] > 0.0)
            .map(|j| dual.rhs[j] / dual.column(j)[j])
            .collect();
        let pushed = norm(&pushed);
        difference / if size > ZERO * pushed { size } else { pushed }
    }
}

fn no_contact() -> Invalid {
    Invalid {
        key: "contact".into(),
        expected: "a scene with contact".into(),
        found: "none".into(),
        help: "without contact there is one linear system, and nothing to compare".into(),
    }
}

//! A problem with its dual operator as a dense matrix, which all checks work on.

use std::{path::Path, sync::Arc};

use crate::shared::dual_of;
use contact3d::{
    AssembledProblem, Problem, ProblemError,
    adaptation::adapted,
    dual::{ContactSystem, ExplicitDual},
    linalg::{Precision, difference, norm},
    mesh::{ContactSurface, Mesh, RefinedLevel},
    scene::{DualOperatorKind, FactorPrecision, InvalidValue, Scene},
    solver::{ContactSide, Solution},
};

/// A scene with contact, assembled in memory with the dense dual operator.
pub(super) struct ExplicitProblem {
    pub(super) assembled: AssembledProblem,
    /// The scene; that of the problem is the last increment of its load history, where it has one.
    pub(super) scene: Scene,
    /// How its mesh came from the first one.
    pub(super) refinement: Vec<RefinedLevel>,
    /// The dual problem with its balance where the body floats.
    balanced: Option<ContactSystem>,
}

impl ExplicitProblem {
    /// Assembles a scene on the mesh it asks for, an adaptive one included; mesh files are looked for
    /// in `folder`.
    pub(super) fn new(scene: Scene, folder: &Path) -> Result<Self, ProblemError> {
        let scene = scene.with_first_mesh();
        let refinement = match scene.adapt {
            None => Vec::new(),
            Some(_) => adapted(scene.clone(), folder)?.1.adaptation.refinement,
        };
        Self::refined(scene, folder, refinement)
    }

    /// Assembles a scene on a refined mesh.
    pub(super) fn refined(
        scene: Scene,
        folder: &Path,
        refinement: Vec<RefinedLevel>,
    ) -> Result<Self, ProblemError> {
        let mesh = Mesh::refined(&scene, folder, &refinement)?;
        Ok(Self {
            refinement,
            ..Self::on_mesh(scene, mesh)?
        })
    }

    /// Assembles a scene on a mesh of its body.
    pub(super) fn on_mesh(mut scene: Scene, mesh: Mesh) -> Result<Self, ProblemError> {
        if !scene.has_contact() {
            return Err(no_contact().into());
        }
        scene.assemble.dual_operator = DualOperatorKind::Explicit;
        let problem = Problem::of_checked(scene.clone(), Arc::new(mesh))?;
        let mut assembled = problem.assemble()?;
        if scene.has_history() {
            assembled = assembled.solve_history(&scene.solve)?.problem;
        }
        let system = &assembled.system;
        let contact = system.contact.as_ref().zip(assembled.contact_side());
        let balanced = contact.and_then(|(dual, state)| {
            dual.balanced(&system.assembly, state.surface, state.interface)
        });
        Ok(Self {
            balanced,
            assembled,
            scene,
            refinement: Vec::new(),
        })
    }

    /// Precision of the factor.
    pub(super) fn precision(&self) -> Precision {
        self.assembled.system.assembly.factor.precision()
    }

    /// The same problem with a factor in double precision; `None` where this one has it.
    pub(super) fn in_double_precision(
        &self,
        scene: &Scene,
        folder: &Path,
    ) -> Result<Option<Self>, ProblemError> {
        if self.precision() == Precision::Double {
            return Ok(None);
        }
        let mut scene = scene.clone();
        scene.assemble.factor = FactorPrecision::Double;
        Self::refined(scene, folder, self.refinement.clone()).map(Some)
    }

    pub(super) fn surface(&self) -> &ContactSurface {
        self.contact().surface
    }

    pub(super) fn contact(&self) -> ContactSide<'_> {
        let contact = self.assembled.contact_side();
        contact.expect("checked when assembled")
    }

    pub(super) fn dual(&self) -> &ExplicitDual {
        let balanced = self.balanced.as_ref().and_then(ContactSystem::explicit);
        balanced.unwrap_or_else(|| dual_of(&self.assembled))
    }

    /// The unknowns of an answer: its multipliers, and its rigid motions where the body floats.
    pub(super) fn unknowns(&self, multiplier: &[f64], answer: &Solution) -> Vec<f64> {
        let known = self.dual().rigid.as_ref().zip(answer.rigid.as_ref());
        let motion = known.map(|(balance, rigid)| balance.unknown_motion(&rigid.motion));
        [multiplier, &motion.unwrap_or_default()].concat()
    }

    /// ‖λ' − λ‖ / ‖λ‖ for the answer λ. Where that is zero to rounding, over ‖ρh‖: the stresses
    /// that would push the free body back.
    pub(super) fn distance(&self, other: &[f64], answer: &[f64]) -> f64 {
        let (difference, size) = (norm(&difference(other, answer)), norm(answer));
        if difference == 0.0 {
            return 0.0;
        }
        let dual = self.dual();
        let pushed: Vec<f64> = (0..answer.len())
            .filter(|&j| dual.column(j)[j] > 0.0)
            .map(|j| dual.rhs[j] / dual.column(j)[j])
            .collect();
        let pushed = norm(&pushed);
        // A stress this much below those of the load is none.
        difference / if size > 1e-12 * pushed { size } else { pushed }
    }
}

fn no_contact() -> InvalidValue {
    InvalidValue {
        key: "contact".into(),
        expected: "a scene with contact".into(),
        found: "none".into(),
        help: "without contact there is one linear system, and nothing to compare".into(),
    }
}

//! A problem with the forms of its contact face, and Ψ on it.

use std::{path::Path, sync::Arc};

use faer::Mat;

use super::{
    FrictionFunctional,
    bound::{NormConstants, OnPanes},
    contraction::{AtSolution, LocalContraction},
    face::{FaceForms, FaceGram, PaneIntegrals, TriangulatedFace},
    successive::Mapping,
    trace::{SpaceNorms, first_sobolev_gram},
};
use contact3d::{
    AssembledProblem, Problem, ProblemError,
    contact::{CoulombLaw, Interface, nodal_tangential},
    dual::{DualSystem, ExplicitDual, LocalStiffness},
    linalg::{CholeskyFactor, CscMatrix, Factor, FactorStructure, Work, Workspace},
    mesh::{ContactSurface, Mesh},
    scene::{DualOperatorKind, FactorPrecision, Invalid, Scene},
    solver::{ContactState, Solution},
};

/// A problem with Coulomb friction on linear tetrahedra, with the forms of its contact face.
pub(super) struct TheoryProblem {
    pub(super) assembled: AssembledProblem,
    local: LocalStiffness,
    pub(super) face: TriangulatedFace,
    pub(super) forms: FaceForms,
    pub(super) rows: PaneIntegrals,
    /// In H¹(Ω)³ and in the energy norm.
    pub(super) grams: [FaceGram; 2],
    pub(super) sobolev: (CscMatrix, CholeskyFactor),
    norms: SpaceNorms,
    pub(super) glued: [Mat<f64>; 2],
    compliance: Mat<f64>,
}

impl TheoryProblem {
    pub(super) fn new(mut scene: Scene, folder: &Path) -> Result<Self, ProblemError> {
        scene.assemble.dual_operator = DualOperatorKind::Explicit;
        scene.assemble.factor = FactorPrecision::Double;
        let mesh = Mesh::of_scene(&scene, folder)?;
        let assembled = Problem::of_checked(scene, Arc::new(mesh))?.assemble()?;
        crate::floating::refuse_floating(&assembled, "the constants of the theory")?;
        let contact = assembled
            .contact_state()
            .ok_or_else(|| singular("no contact"))?;
        let (surface, frame) = (contact.surface, &contact.interface.frame);
        let primal = &assembled.system().assembly.primal;
        let dofs = &primal.dofs;
        if surface.nodes.iter().any(|&n| dofs.held_at(n) != [0.0; 3]) {
            return Err(moved_face().into());
        }
        let gram = first_sobolev_gram(assembled.mesh(), dofs);
        // K has the pattern of A where materials couple all components, so the order of A's factor serves it.
        let order = assembled
            .system()
            .assembly
            .factor
            .structure()
            .permutation
            .clone();
        let structure = FactorStructure::analyse(&gram, order);
        let factor = structure
            .and_then(|structure| CholeskyFactor::of_structure(structure, &gram, &Work::default()));
        let factor = factor.map_err(|_| singular("H¹"))?;
        let Factor::Double(stiffness) = &*assembled.system().assembly.factor else {
            return Err(singular("single precision"));
        };
        let grams = [&factor, stiffness].map(|f| FaceGram::new(f, surface, frame, dofs));
        let face = TriangulatedFace::new(assembled.mesh(), surface, dofs);
        let forms = face.forms();
        let rows = PaneIntegrals::of_surface(surface);
        let glued = |gram: &FaceGram| gram.normal_glued(&rows).ok_or_else(|| singular("Q"));
        let glued = [glued(&grams[0])?, glued(&grams[1])?];
        let norms = SpaceNorms::new(forms.mass.clone(), glued.to_vec());
        let dual = assembled
            .system()
            .contact
            .as_ref()
            .and_then(|c| c.explicit());
        Ok(Self {
            local: LocalStiffness::new(dual.ok_or_else(|| singular("S"))?),
            norms: norms.ok_or_else(|| singular("Q"))?,
            compliance: grams[1].tangential_by_multipliers(&rows),
            face,
            forms,
            rows,
            grams,
            sobolev: (gram, factor),
            glued,
            assembled,
        })
    }

    pub(super) fn system(&self) -> &DualSystem {
        self.assembled.system()
    }

    pub(super) fn contact(&self) -> ContactState<'_> {
        self.assembled
            .contact_state()
            .expect("checked when assembled")
    }

    pub(super) fn dual(&self) -> &ExplicitDual {
        let contact = self.system().contact.as_ref();
        contact
            .and_then(|c| c.explicit())
            .expect("assembled with the dense operator")
    }

    pub(super) fn sobolev_gram(&self) -> &FaceGram {
        &self.grams[0]
    }

    pub(super) fn into_sobolev_gram(self) -> (TriangulatedFace, FaceGram) {
        let [gram, _] = self.grams;
        (self.face, gram)
    }

    pub(super) fn law(&self) -> &CoulombLaw {
        self.contact()
            .interface
            .coulomb()
            .expect("checked before meshing")
    }

    pub(super) fn surface(&self) -> &ContactSurface {
        self.contact().surface
    }

    /// Ψ′ at a solution for the law of an interface.
    pub(super) fn contraction(
        &self,
        interface: &Interface,
        solution: &Solution,
        with_paper: bool,
    ) -> Option<LocalContraction> {
        let dofs = &self.system().assembly.primal.dofs;
        let contact = self.contact();
        let tangential = nodal_tangential(
            contact.surface,
            &interface.frame,
            dofs,
            &solution.displacement,
        );
        let at = AtSolution {
            dual: self.dual(),
            local: &self.local,
            laws: ContactState {
                interface,
                ..contact
            }
            .laws(),
            law: interface.coulomb()?,
            face: &self.face,
            compliance: &self.compliance,
            multiplier: &solution.multiplier,
            tangential: &tangential,
        };
        at.contraction(&self.norms, with_paper)
    }

    pub(super) fn functional(&self, solution: &Solution) -> Option<FrictionFunctional> {
        let contact = self.contact();
        let (normal, pairs) = self.dual().layout.split(&solution.multiplier);
        let dofs = &self.system().assembly.primal.dofs;
        let frame = &contact.interface.frame;
        let tangential = nodal_tangential(contact.surface, frame, dofs, &solution.displacement);
        let at = OnPanes {
            face: &self.face,
            surface: contact.surface,
            law: self.law(),
            normal,
            pairs,
            slip: &contact.interface.slip.operator.slip(&tangential),
            tangential: &tangential,
        };
        at.functional()
    }

    /// (u_t1, u_t2) at the contact nodes of a multiplier.
    pub(super) fn tangential(&self, multiplier: &[f64]) -> Vec<[f64; 2]> {
        let system = self.system();
        let coupled = system.contact.as_ref().expect("checked when assembled");
        let displacement =
            coupled.displacement(&system.assembly, multiplier, &mut Workspace::default());
        let contact = self.contact();
        let dofs = &system.assembly.primal.dofs;
        nodal_tangential(
            contact.surface,
            &contact.interface.frame,
            dofs,
            &displacement,
        )
    }

    pub(super) fn mapping<'a>(
        &'a self,
        norms: &[NormConstants],
        local: Option<&LocalContraction>,
        tangential: &'a dyn Fn(&[f64]) -> Vec<[f64; 2]>,
    ) -> Mapping<'a> {
        Mapping {
            dual: self.dual(),
            local: &self.local,
            laws: self.contact().laws(),
            law: self.law(),
            face: &self.face,
            norms: &self.norms,
            radii: norms.iter().map(|norm| norm.radii).collect(),
            weights: match local {
                None => vec![0.0; norms.len()],
                Some(local) => local.parts.iter().map(|parts| parts.weight()).collect(),
            },
            tangential,
        }
    }
}

fn moved_face() -> Invalid {
    Invalid {
        key: "clamp".into(),
        expected: "contact nodes that are held at zero, or not at all".into(),
        found: "clamps with a value on contact nodes".into(),
        help: "traces that vanish where they are held are what HKL section 3 is about; hold other faces, or leave value out".into(),
    }
}

fn singular(form: &str) -> ProblemError {
    ProblemError::Invalid(Invalid {
        key: "contact".into(),
        expected: "forms of the contact face that have a factor, HKL (3.1)".into(),
        found: format!("a singular one ({form})"),
        help: "choose panes that are wider than the triangles, or nodal multipliers".into(),
    })
}

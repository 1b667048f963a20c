//! The whole assembled problem.

use std::{
    sync::{Arc, OnceLock},
    time::Instant,
};

use super::{
    Assembly, AssemblyError, ContactSystem, ExplicitDual, InsufficientResource, LocalStiffness,
    OperatorEstimate, Requirement, assembly::Analysed, need::FACTORISING,
};
use crate::{
    contact::{Coupling, Interface},
    linalg::{CscMatrix, EngineError, Factor, Precision, Work, difference, norm},
    mesh::{ContactSurface, Mesh},
    scene::{DualOperatorKind, FactorPrecision, InvalidValue, Scene},
};

/// How a problem is assembled.
#[derive(Clone, Copy)]
pub struct Assembling<'a> {
    /// Asked before the stiffness and before the factor are allocated.
    pub admit: &'a dyn Fn(Requirement) -> Result<(), InsufficientResource>,
    /// Told of each long step whose operations are counted, with what shows from then on how far it is.
    pub begun: &'a dyn Fn(&'static str, &Arc<Work>),
    /// The command line of the program that is to hold the factor; `None` for this one.
    pub engine: Option<&'a str>,
}

impl Default for Assembling<'_> {
    /// All is admitted, nothing is watched, and the factor stays here.
    fn default() -> Self {
        Self {
            admit: &|_| Ok(()),
            begun: &|_, _| (),
            engine: None,
        }
    }
}

/// The assembled problem: the elastic body, and its contact where the scene has one.
///
/// A clone shares all that does not depend on the loads: A, its factor, S and the contact compliance.
#[derive(Debug, Clone, PartialEq)]
pub struct DualSystem {
    /// A, l and the factor.
    pub assembly: Assembly,
    /// B, h and perhaps S; `None` without contact.
    pub contact: Option<ContactSystem>,
    /// The same with contact springs, whatever its loads, once a solve asked for it; `None` where nothing can be made.
    pub(super) contact_springs: Arc<OnceLock<Option<DualSystem>>>,
}

impl DualSystem {
    /// From its parts.
    #[must_use]
    pub fn of(assembly: Assembly, contact: Option<ContactSystem>) -> Self {
        Self {
            assembly,
            contact,
            contact_springs: Arc::default(),
        }
    }

    /// Assembles and factorises, and forms S when the scene or the estimate asks for it.
    ///
    /// # Errors
    /// [`AssemblyError`] when A has no Cholesky factor, a formula of the scene has no value, or a number overflows.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Result<Self, AssemblyError> {
        let interface = Interface::new(scene, mesh).map_err(AssemblyError::Scene)?;
        Self::assembled(scene, mesh, interface.as_ref(), &Assembling::default())
    }

    /// As [`Self::new`], with the frame, the gap and the laws of the contact face as they were read from the scene, and as [`Assembling`] says. Where the choice is free and the dense operator does not fit, it is not formed.
    ///
    /// # Errors
    /// As [`Self::new`], and what `admit` refuses.
    pub fn assembled(
        scene: &Scene,
        mesh: &Mesh,
        interface: Option<&Interface>,
        assembling: &Assembling<'_>,
    ) -> Result<Self, AssemblyError> {
        let analysed = Analysed::new(scene, mesh, assembling.admit)?;
        let face = mesh.contact.as_ref().zip(interface);
        let coupling =
            face.map(|(surface, interface)| interface.coupling(surface, &analysed.primal.dofs));
        let dense = coupling
            .as_ref()
            .and_then(|coupling| dense_operator(scene, mesh, &analysed, coupling));
        let contact = coupling.as_ref().zip(face);
        let form = |precision, dense: Option<&OperatorEstimate>| {
            Self::formed(&analysed, contact, precision, dense, assembling)
        };
        if assembling.engine.is_some() {
            require_single_precision(scene)?;
            return form(Precision::Single, dense.as_ref())?.validated();
        }
        if let Some(single) = in_single_precision(scene, &analysed, dense.as_ref(), &form)? {
            return Ok(single);
        }
        match form(Precision::Double, dense.as_ref()) {
            Err(AssemblyError::InsufficientResource(_))
                if dense.is_some() && scene.assemble.dual_operator == DualOperatorKind::Auto =>
            {
                form(Precision::Double, None)
            }
            formed => formed,
        }
    }

    /// Factorises, and forms S where it is estimated.
    fn formed(
        analysed: &Analysed,
        contact: Option<(&Coupling, (&ContactSurface, &Interface))>,
        precision: Precision,
        dense: Option<&OperatorEstimate>,
        assembling: &Assembling<'_>,
    ) -> Result<Self, AssemblyError> {
        let begin = |step, operations| {
            let work = Arc::new(Work::of(operations));
            (assembling.begun)(step, &work);
            work
        };
        let Analysed {
            primal, structure, ..
        } = analysed;
        let assembly = if let Some(engine) = assembling.engine {
            let rows = contact.filter(|_| dense.is_some());
            let transposed = rows.map_or_else(
                || CscMatrix::empty(primal.dofs.n_free),
                |(coupling, _)| coupling.transposed.clone(),
            );
            analysed.factorise_by(engine, transposed)?
        } else {
            let stiffness = &primal.stiffness;
            let required = Requirement::of_factor(stiffness, structure, precision, dense);
            (assembling.admit)(required)?;
            analysed.factorise(precision, &begin(FACTORISING, structure.operations()))?
        };
        let mut system = Self::of(assembly, None);
        if let Some((coupling, face)) = contact {
            let assembly = &mut system.assembly;
            let (unconstrained, dofs) = (assembly.unconstrained(), &assembly.primal.dofs);
            let coupling = coupling.clone();
            let mut contact = ContactSystem::new(coupling, &unconstrained, dofs, face.0, face.1);
            if let Some(estimate) = dense {
                let started = Instant::now();
                let work = begin("forming the dual operator", estimate.explicit_operations);
                contact.make_explicit(assembly, &unconstrained, face, &work);
                assembly.seconds.dual_operator = started.elapsed().as_secs_f64();
            }
            system.contact = Some(contact);
        }
        if let Some(failure) = system.assembly.factor.failure() {
            return Err(failure.into());
        }
        system.require_finite().map_err(AssemblyError::Scene)?;
        Ok(system)
    }

    /// The system, if the factor of its engine serves.
    fn validated(self) -> Result<Self, AssemblyError> {
        match &*self.assembly.factor {
            Factor::Remote(factor) if !self.is_well_preconditioned() => {
                let name = factor.name();
                Err(factor
                    .failure()
                    .unwrap_or(EngineError::TooInexact { name })
                    .into())
            }
            _ => Ok(self),
        }
    }

    /// As [`Self::apply`], with B, S and h for other normals and opposite points of the contact face, on the same factor.
    pub(crate) fn apply_to_face(
        &mut self,
        scene: &Scene,
        mesh: &Mesh,
        (surface, interface): (&ContactSurface, &Interface),
    ) -> Result<(), InvalidValue> {
        self.assembly.primal.apply_loads(scene, mesh)?;
        let is_explicit = |contact: &ContactSystem| contact.explicit().is_some();
        let was_explicit = self.contact.as_ref().is_some_and(is_explicit);
        let (assembly, dofs) = (&self.assembly, &self.assembly.primal.dofs);
        let (coupling, unconstrained) =
            (interface.coupling(surface, dofs), assembly.unconstrained());
        let mut contact = ContactSystem::new(coupling, &unconstrained, dofs, surface, interface);
        if was_explicit {
            let (face, unwatched) = ((surface, interface), Work::default());
            contact.make_explicit(assembly, &unconstrained, face, &unwatched);
        }
        self.contact = Some(contact);
        self.contact_springs = Arc::default();
        self.require_finite()
    }

    /// Replaces l, h and the free slip by those of a scene that differs in its loads, the displacements of its clamps, its
    /// gap or its friction only: one solve with the factor.
    ///
    /// # Errors
    /// A formula of the scene that has no value, numbers that overflow.
    pub fn apply_loads(&mut self, scene: &Scene, mesh: &Mesh) -> Result<(), InvalidValue> {
        let interface = Interface::new(scene, mesh)?;
        self.apply(scene, mesh, interface.as_ref())
    }

    /// As [`Self::apply_loads`], with the laws of the contact face as they are in a step of a load history.
    ///
    /// # Errors
    /// As [`Self::apply_loads`].
    pub fn apply(
        &mut self,
        scene: &Scene,
        mesh: &Mesh,
        interface: Option<&Interface>,
    ) -> Result<(), InvalidValue> {
        self.assembly.primal.apply_loads(scene, mesh)?;
        if let Some(face) = mesh.contact.as_ref().zip(interface) {
            self.update_rhs(face);
        }
        self.require_finite()
    }

    /// Recomputes h and the free slip of the load that the assembly has.
    pub(super) fn update_rhs(&mut self, (surface, interface): (&ContactSurface, &Interface)) {
        let Some(contact) = &mut self.contact else {
            return;
        };
        let unconstrained = self.assembly.unconstrained();
        let dofs = &self.assembly.primal.dofs;
        contact.apply_loads(&unconstrained, dofs, surface, interface);
        if let Some(explicit) = contact.explicit_mut() {
            explicit.apply_loads(&unconstrained, surface, &interface.frame, dofs);
        }
    }

    /// Refuses a problem whose assembled numbers overflowed: no solve could begin, and no file would hold them.
    fn require_finite(&self) -> Result<(), InvalidValue> {
        let found = [
            ("stiffness", self.assembly.primal.stiffness.data.as_slice()),
            ("load", self.assembly.primal.load.as_slice()),
        ];
        let contact = self.contact.iter().flat_map(|contact| {
            let dense = contact.explicit();
            let compliance = dense.and_then(|dense| dense.compliance.as_ref());
            [
                Some(("right-hand side h", contact.dual_rhs())),
                dense.map(|dense| ("dual operator S", dense.operator.as_slice())),
                compliance.map(|c| ("compliance of the contact face", c.matrix.as_slice())),
                compliance.map(|c| ("free slip", c.slip_free.as_flattened())),
            ]
        });
        let mut arrays = found.into_iter().chain(contact.flatten());
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        match arrays.find(|(_, values)| !finite(values)) {
            None => Ok(()),
            Some((name, _)) => Err(InvalidValue {
                key: "material".into(),
                expected: "moduli, loads and sizes that double precision can compute with".into(),
                found: format!("a {name} that is not finite"),
                help: "choose units in which stiffness, loads and lengths are moderate".into(),
            }),
        }
    }
}

/// Engines answer in single precision.
fn require_single_precision(scene: &Scene) -> Result<(), AssemblyError> {
    match scene.assemble.factor {
        FactorPrecision::Auto | FactorPrecision::Single => Ok(()),
        FactorPrecision::Double => Err(AssemblyError::Scene(InvalidValue {
            key: "assemble.factor".into(),
            expected: "auto or single with an engine".into(),
            found: "double".into(),
            help: "leave --engine out, or the key; answers have double precision either way".into(),
        })),
    }
}

/// The problem with a factor in single precision, where the scene asks for one or it pays and serves.
fn in_single_precision(
    scene: &Scene,
    analysed: &Analysed,
    dense: Option<&OperatorEstimate>,
    form: &impl Fn(Precision, Option<&OperatorEstimate>) -> Result<DualSystem, AssemblyError>,
) -> Result<Option<DualSystem>, AssemblyError> {
    match scene.assemble.factor {
        FactorPrecision::Double => Ok(None),
        FactorPrecision::Single => form(Precision::Single, dense).map(Some),
        FactorPrecision::Auto => {
            let without_operator = scene.has_contact() && dense.is_none();
            // In smaller factors half the memory and half the time do not outweigh the steps of conjugate gradients.
            if analysed.structure.value_count() < 1 << 24 || without_operator {
                return Ok(None);
            }
            // A matrix that has no factor in single precision may have one in double.
            let formed = form(Precision::Single, dense).ok();
            Ok(formed.filter(DualSystem::is_well_preconditioned))
        }
    }
}

/// What the dense operator costs, where the scene or the estimate asks for it.
fn dense_operator(
    scene: &Scene,
    mesh: &Mesh,
    analysed: &Analysed,
    coupling: &Coupling,
) -> Option<OperatorEstimate> {
    let n_contact_nodes = mesh.contact.as_ref()?.nodes.len();
    let structure = &analysed.structure;
    let estimate = OperatorEstimate::new(structure, coupling, n_contact_nodes);
    let wanted = match scene.assemble.dual_operator {
        DualOperatorKind::Implicit => false,
        DualOperatorKind::Explicit => true,
        DualOperatorKind::Auto => estimate.prefers_explicit(),
    };
    wanted.then_some(estimate)
}

/// The error that one step with a factor in single precision may leave: of conjugate gradients on A, and of corrections by the dense
/// operator.
const SLOWEST: f64 = 0.1;

impl DualSystem {
    /// Whether both uses of the factor leave at most a tenth of an error a step: conjugate gradients on A, and, where S̃
    /// was formed from it, λ ← λ − S̃⁻¹(S λ − h), and whether panes feel little of what S̃ has wrong. The second knows what
    /// the first does not: the rigid motion of a body that nearly floats fills S, and its error hides what the panes feel. The
    /// third knows what the second does not: a small share of a motion that all panes take part in is much for one of them.
    #[must_use]
    pub fn is_well_preconditioned(&self) -> bool {
        let contact = self.contact.as_ref();
        match contact.and_then(|contact| Some((contact, contact.explicit()?))) {
            Some((contact, dual)) => self.serves(contact, dual),
            None => self.probe(&or_ones(&self.assembly.primal.load)).1 <= SLOWEST,
        }
    }

    /// On w = S̃⁻¹h, the stresses of a face that is bonded to the foundation: conjugate gradients on A, and
    /// ‖S̃⁻¹(S w − h)‖ / ‖w‖ with S w from them; and ‖ρ (S − S̃) e‖ / ‖e‖ on e = ρ (S w − h) with local stiffness ρ, which is rich in
    /// what S̃ has wrong.
    fn serves(&self, contact: &ContactSystem, dual: &ExplicitDual) -> bool {
        let local = LocalStiffness::new(dual);
        let rhs = or_ones(&dual.rhs);
        let bonded = local.bonded(&rhs);
        let (moved, of_gradients) = self.probe(&contact.coupling.nodal_forces(&bonded));
        let excess = difference(&contact.coupling.integrate(&moved), &rhs);
        let against_own = |wrong: &[f64]| -> Vec<f64> {
            let panes = local.stiffness.iter().zip(wrong);
            panes.map(|(rho, wrong)| rho * wrong).collect()
        };
        let error = against_own(&excess);
        let (moved, _) = self.probe(&contact.coupling.nodal_forces(&error));
        let wrong = difference(&contact.coupling.integrate(&moved), &dual.apply(&error));
        // Newton's method does not find from the answer of S̃ to that of S where what S̃ has wrong moves panes further than their own
        // stress moves them against their neighbours.
        of_gradients <= SLOWEST
            && norm(&local.bonded(&excess)) / norm(&bonded) <= SLOWEST
            && norm(&against_own(&wrong)) / norm(&error) <= 1.0
    }

    /// The displacement that some forces cause, and the contraction of the steps to it.
    fn probe(&self, forces: &[f64]) -> (Vec<f64>, f64) {
        let solved = self.assembly.by_gradients(forces, 1e-6, 0.0);
        let contraction = solved.contraction();
        (solved.solution, contraction)
    }
}

/// A vector, or ones where it vanishes.
fn or_ones(vector: &[f64]) -> Vec<f64> {
    if vector.iter().all(|value| *value == 0.0) {
        vec![1.0; vector.len()]
    } else {
        vector.to_vec()
    }
}

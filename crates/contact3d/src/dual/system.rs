//! The whole assembled problem.

use std::{sync::Arc, time::Instant};

use super::{
    Assembly, AssemblyError, ContactSystem, Need, OperatorEstimate,
    assembly::Analysed,
    need::{Admission, FACTORISING, Observation},
};
use crate::{
    contact::{Coupling, Interface},
    linalg::{CscMatrix, EngineCommand, EngineError, Factor, Precision, Work},
    mesh::Mesh,
    scene::{DualOperatorKind, FactorPrecision, InvalidValue, Scene},
};

/// Coefficients of the factor from which half the memory and half the time outweigh the steps of conjugate gradients.
const SINGLE_PAYS: usize = 1 << 24;

/// How a problem is assembled.
#[derive(Clone, Copy)]
pub struct Assembling<'a> {
    /// Asked before the stiffness and before the factor are allocated.
    pub admit: Admission<'a>,
    /// Told of each long step whose operations are counted, with what shows from then on how far it is.
    pub begun: Observation<'a>,
    /// The program that is to hold the factor; `None` for this one.
    pub engine: Option<&'a EngineCommand>,
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
}

impl DualSystem {
    /// Assembles and factorises, and forms S when the scene or the estimate asks for it.
    ///
    /// # Errors
    /// [`AssemblyError`] when A has no Cholesky factor, a formula of the scene has no value, or a number overflows.
    pub fn new(scene: &Scene, mesh: &Mesh) -> Result<Self, AssemblyError> {
        Self::watched(scene, mesh, &Assembling::default())
    }

    /// As [`Self::new`], as [`Assembling`] says. Where the choice is free and the dense operator does not fit, it is not formed.
    ///
    /// # Errors
    /// As [`Self::new`], and what `admit` refuses.
    pub fn watched(
        scene: &Scene,
        mesh: &Mesh,
        assembling: &Assembling<'_>,
    ) -> Result<Self, AssemblyError> {
        let Assembling {
            admit,
            begun,
            engine,
        } = *assembling;
        let interface = Interface::new(scene, mesh).map_err(AssemblyError::Scene)?;
        let analysed = Analysed::new(scene, mesh, admit)?;
        let face = interface.as_ref().zip(mesh.contact.as_ref());
        let coupling =
            face.map(|(interface, surface)| interface.coupling(surface, &analysed.primal.dofs));
        let dense = coupling
            .as_ref()
            .and_then(|coupling| dense_operator(scene, mesh, &analysed, coupling));
        let form = |precision, dense: Option<&OperatorEstimate>| {
            let Analysed {
                primal, structure, ..
            } = &analysed;
            let stiffness = &primal.stiffness;
            if engine.is_none() {
                admit(Need::of_factor(stiffness, structure, precision, dense))?;
            }
            let begin = |step, operations| {
                let work = Arc::new(Work::of(operations));
                begun(step, &work);
                work
            };
            let mut assembly = match engine {
                None => {
                    let work = begin(FACTORISING, analysed.structure.operations());
                    analysed.factorise(precision, &work)?
                }
                Some(engine) => {
                    let dense = coupling.as_ref().filter(|_| dense.is_some());
                    let transposed = dense.map_or_else(
                        || CscMatrix::empty(analysed.primal.dofs.n_free),
                        |coupling| coupling.transposed.clone(),
                    );
                    analysed.factorise_by(engine, transposed)?
                }
            };
            let contact = face
                .zip(coupling.clone())
                .map(|((interface, surface), coupling)| {
                    let unconstrained = assembly.unconstrained();
                    let dofs = &assembly.primal.dofs;
                    let mut contact =
                        ContactSystem::new(coupling, &unconstrained, dofs, surface, interface);
                    if let Some(estimate) = dense {
                        let started = Instant::now();
                        let work = begin("forming the dual operator", estimate.explicit_operations);
                        let face = (surface, interface);
                        contact.make_explicit(&assembly, &unconstrained, face, &work);
                        assembly.seconds.dual_operator = started.elapsed().as_secs_f64();
                    }
                    contact
                });
            let system = Self { assembly, contact };
            if let Some(failure) = system.assembly.factor.failure() {
                return Err(failure.into());
            }
            system.require_finite().map_err(AssemblyError::Scene)?;
            Ok(system)
        };
        if engine.is_some() {
            require_single_precision(scene)?;
            let system = form(Precision::Single, dense.as_ref())?;
            return system.served();
        }
        if let Some(single) = in_single_precision(scene, &analysed, dense.as_ref(), &form)? {
            return Ok(single);
        }
        match form(Precision::Double, dense.as_ref()) {
            Err(AssemblyError::Shortage(_))
                if dense.is_some() && scene.assemble.dual_operator == DualOperatorKind::Auto =>
            {
                form(Precision::Double, None)
            }
            formed => formed,
        }
    }

    /// The system, if the factor of its engine serves.
    fn served(self) -> Result<Self, AssemblyError> {
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
        let assembly = &mut self.assembly;
        assembly.primal.apply_loads(scene, mesh)?;
        if let (Some(contact), Some(interface), Some(surface)) =
            (&mut self.contact, interface, &mesh.contact)
        {
            let unconstrained = assembly.unconstrained();
            let dofs = &assembly.primal.dofs;
            contact.apply_loads(&unconstrained, dofs, surface, interface);
            if let Some(explicit) = contact.explicit_mut() {
                explicit.apply_loads(&unconstrained, surface, &interface.frame, dofs);
            }
        }
        self.require_finite()
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
            let without_operator = !scene.contacts.is_empty() && dense.is_none();
            if analysed.structure.value_count() < SINGLE_PAYS || without_operator {
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

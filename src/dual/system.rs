use std::time::Instant;

use super::{
    Assembly, AssemblyError, ContactSystem, ExplicitDual, OperatorEstimate, assembly::load_vector,
};
use crate::{
    contact::Interface,
    linalg::Workspace,
    mesh::Mesh,
    scene::{DualOperatorKind, Invalid, Scene},
};

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
    /// [`AssemblyError`] when A has no Cholesky factor, or a formula of the scene has no value.
    pub fn new(scene: &Scene, mesh: &Mesh, threads: usize) -> Result<Self, AssemblyError> {
        let interface = Interface::new(scene, mesh).map_err(AssemblyError::Scene)?;
        let mut assembly = Assembly::new(scene, mesh, threads)?;
        let (Some(interface), Some(surface)) = (interface, &mesh.contact) else {
            return Ok(Self {
                assembly,
                contact: None,
            });
        };
        let mut contact = ContactSystem::new(&assembly, surface, &interface);
        let wanted = match scene.assemble.dual_operator {
            DualOperatorKind::Implicit => false,
            DualOperatorKind::Explicit => true,
            DualOperatorKind::Auto => {
                OperatorEstimate::new(&assembly, &contact, surface.nodes.len()).prefers_explicit()
            }
        };
        if wanted {
            let started = Instant::now();
            let explicit = ExplicitDual::new(&assembly, &contact, surface, &interface);
            contact.explicit = Some(explicit);
            assembly.seconds.dual_operator = started.elapsed().as_secs_f64();
        }
        Ok(Self {
            assembly,
            contact: Some(contact),
        })
    }

    /// Replaces l, h and the free slip by those of a scene that differs in its loads, its gap or its
    /// friction only: one solve with the factor.
    ///
    /// # Errors
    /// A formula of the scene that has no value.
    pub fn apply_loads(&mut self, scene: &Scene, mesh: &Mesh) -> Result<(), Invalid> {
        let interface = Interface::new(scene, mesh)?;
        let assembly = &mut self.assembly;
        assembly.primal.load = load_vector(scene, mesh, &assembly.primal.dofs)?;
        if let (Some(contact), Some(interface), Some(surface)) =
            (&mut self.contact, &interface, &mesh.contact)
        {
            let unconstrained = assembly.solve(&assembly.primal.load, &mut Workspace::default());
            contact.apply_loads(&unconstrained, surface, interface);
            if let Some(explicit) = &mut contact.explicit {
                explicit.rhs.clone_from(&contact.dual_rhs);
                let dofs = &assembly.primal.dofs;
                explicit.apply_loads(&unconstrained, surface, &interface.frame, dofs);
            }
        }
        Ok(())
    }
}

use std::time::Instant;

use super::{Assembly, AssemblyError, ContactSystem, ExplicitDual, OperatorEstimate};
use crate::{
    contact::Interface,
    mesh::Mesh,
    scene::{DualOperatorKind, Scene},
};

/// The assembled problem: the elastic body, and its contact where the scene has one.
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
}

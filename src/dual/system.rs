use std::time::Instant;

use super::{Assembly, AssemblyError, ExplicitDual, OperatorEstimate};
use crate::{
    mesh::Mesh,
    scene::{DualOperatorKind, Scene},
};

/// The assembled problem together with the dense dual operator, where that is wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct DualSystem {
    /// A, l, B, the factor and h.
    pub assembly: Assembly,
    /// S and the contact compliance; `None` when S is applied through the factor.
    pub explicit: Option<ExplicitDual>,
}

impl DualSystem {
    /// Assembles and factorises, and forms S when the scene or the estimate asks for it.
    ///
    /// # Errors
    /// [`AssemblyError`] when A has no Cholesky factor.
    pub fn new(scene: &Scene, mesh: &Mesh, threads: usize) -> Result<Self, AssemblyError> {
        let mut assembly = Assembly::new(scene, mesh, threads)?;
        let wanted = match scene.assemble.dual_operator {
            DualOperatorKind::Implicit => false,
            DualOperatorKind::Explicit => true,
            DualOperatorKind::Auto => {
                OperatorEstimate::new(&assembly, mesh.contact.nodes.len()).prefers_explicit()
            }
        };
        let started = Instant::now();
        let explicit =
            wanted.then(|| ExplicitDual::new(&assembly, &mesh.contact, &scene.contact.frame()));
        if explicit.is_some() {
            assembly.seconds.dual_operator = started.elapsed().as_secs_f64();
        }
        Ok(Self { assembly, explicit })
    }
}

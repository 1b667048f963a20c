use std::{panic::resume_unwind, thread, time::Instant};

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
        Ok(Self::new_while(scene, mesh, threads, |_| ())?.0)
    }

    /// Like [`Self::new`]; while S is formed, a thread of its own does `meanwhile`, which gets all
    /// but S, and whose result is returned too.
    ///
    /// # Errors
    /// [`AssemblyError`] when A has no Cholesky factor; `meanwhile` is not called then.
    pub fn new_while<R: Send>(
        scene: &Scene,
        mesh: &Mesh,
        threads: usize,
        meanwhile: impl FnOnce(&Assembly) -> R + Send,
    ) -> Result<(Self, R), AssemblyError> {
        let mut assembly = Assembly::new(scene, mesh, threads)?;
        let wanted = match scene.assemble.dual_operator {
            DualOperatorKind::Implicit => false,
            DualOperatorKind::Explicit => true,
            DualOperatorKind::Auto => {
                OperatorEstimate::new(&assembly, mesh.contact.nodes.len()).prefers_explicit()
            }
        };
        let started = Instant::now();
        let (explicit, seconds, result) = thread::scope(|scope| {
            let other = scope.spawn(|| meanwhile(&assembly));
            let explicit =
                wanted.then(|| ExplicitDual::new(&assembly, &mesh.contact, &scene.contact.frame()));
            let seconds = started.elapsed().as_secs_f64();
            let result = other.join().unwrap_or_else(|panic| resume_unwind(panic));
            (explicit, seconds, result)
        });
        if explicit.is_some() {
            assembly.seconds.dual_operator = seconds;
        }
        Ok((Self { assembly, explicit }, result))
    }
}

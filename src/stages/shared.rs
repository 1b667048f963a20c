//! Meshes and assembled problems that several run files of a folder share.

use super::{AssemblyFile, Freshness, Session, StageError, freshness::input_digest};
use crate::{
    dual::DualSystem,
    mesh::Mesh,
    store::{SharedStage, Stage, StoredStage, Transaction},
};

/// A mesh and all of its assembled problem that does not depend on the loads, in memory.
#[derive(Debug, Clone)]
pub struct Operator {
    mesh: Mesh,
    system: DualSystem,
}

impl Operator {
    /// Unknowns of the body.
    #[must_use]
    pub fn n_free(&self) -> usize {
        self.system.assembly.primal.dofs.n_free
    }
}

impl Session {
    /// Makes mesh and assembled problem fresh with the least work: kept, linked from a file that another run file
    /// of the folder shares, or computed and shared. Loads it, or takes it from `known`, which must belong to a
    /// scene with the same [`super::operator_settings`].
    ///
    /// # Errors
    /// As [`Session::make_mesh`] and [`Session::assemble`].
    pub fn prepare_operator(&mut self, known: Option<&Operator>) -> Result<Operator, StageError> {
        self.keep_assembly(AssemblyFile::Shared);
        self.link_shared()?;
        let is_fresh = |session: &Self, index: usize| -> Result<bool, StageError> {
            Ok(session.states()?[index].freshness == Freshness::Fresh)
        };
        if !is_fresh(self, 0)? {
            self.make_mesh()?;
            self.link_shared()?;
        }
        if !is_fresh(self, 1)? {
            self.assemble()?;
        } else if let Some(known) = known {
            self.mesh = Some(known.mesh.clone());
            self.system = Some(known.system.clone());
            self.loads_applied = false;
        } else {
            self.load_mesh()?;
            self.load_operator()?;
        }
        self.load_interface()?;
        Ok(Operator {
            mesh: super::persistence::loaded(&self.mesh).clone(),
            system: super::persistence::loaded(&self.system).clone(),
        })
    }

    /// Links every upstream stage that is not fresh and that a shared file holds.
    fn link_shared(&self) -> Result<(), StageError> {
        let mut upstream: Vec<StoredStage> = Vec::new();
        let mut found = Vec::new();
        for state in self.states()?.into_iter().take(2) {
            if state.freshness == Freshness::Fresh && found.is_empty() {
                upstream.extend(state.stored);
                continue;
            }
            let known: Vec<&StoredStage> = upstream.iter().collect();
            let digest = input_digest(state.stage, self.scene(), &known);
            let Some(shared) = SharedStage::find(&self.file, state.stage, &digest) else {
                break;
            };
            upstream.push(shared.stored().clone());
            found.push(shared);
        }
        if found.is_empty() {
            return Ok(());
        }
        let mut transaction = Transaction::begin(&self.file)?;
        self.write_scene(&mut transaction)?;
        for shared in &found {
            transaction.link(shared)?;
        }
        transaction.remove(Stage::Checkpoint);
        Ok(transaction.commit()?)
    }
}

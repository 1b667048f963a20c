//! Meshes and assembled problems that several run files of a folder share.

use std::{fs, path::Path};

use contact3d::{dual::DualSystem, mesh::Mesh};
use runfile::{SharedGroup, StoreError, StoredGroup};

use super::{AssemblyFile, Freshness, Session, StageError, freshness::input_digest};
use crate::format::{self, FormatError, Stage};

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
    /// Makes mesh and assembled problem fresh with the least work: kept, linked from a file that
    /// another run file of the folder shares, or computed and shared. Loads it, or takes it from
    /// `known`, which must belong to a scene with the same [`super::operator_settings`]. A shared
    /// file whose values do not fit their digests is made again under the same name.
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
            self.assemble(&|_| {})?;
        } else if let Some(known) = known {
            self.mesh = Some(known.mesh.clone());
            self.system = Some(known.system.clone());
            self.loads_applied = false;
        } else if let Err(error) = self.load_mesh().and_then(|()| self.load_operator()) {
            if !is_of_content(&error) || !self.remove_shared()? {
                return Err(error.into());
            }
            (self.mesh, self.system) = (None, None);
            return self.prepare_operator(known);
        }
        self.load_interface()?;
        Ok(Operator {
            mesh: super::persistence::loaded(&self.mesh).clone(),
            system: super::persistence::loaded(&self.system).clone(),
        })
    }

    /// Removes the shared files that the run file links; whether there were any.
    fn remove_shared(&self) -> Result<bool, StageError> {
        let reader = self.reader()?;
        let folder = self.file.path().parent().unwrap_or(Path::new(""));
        let mut removed = false;
        for stage in [Stage::Mesh, Stage::Assemble] {
            let Some((name, _)) = reader.linked_file(stage.group()) else {
                continue;
            };
            let file = folder.join(name);
            fs::remove_file(&file).map_err(|source| StageError::Write { file, source })?;
            removed = true;
        }
        Ok(removed)
    }

    /// Links every upstream stage that is not fresh and that a shared file holds.
    fn link_shared(&self) -> Result<(), StageError> {
        let mut upstream: Vec<StoredGroup> = Vec::new();
        let mut found = Vec::new();
        for state in self.states()?.into_iter().take(2) {
            if state.freshness == Freshness::Fresh && found.is_empty() {
                upstream.extend(state.stored);
                continue;
            }
            let known: Vec<&StoredGroup> = upstream.iter().collect();
            let digest = input_digest(state.stage, &self.settings(state.stage), &known);
            let Some(shared) = SharedGroup::find(&self.file, state.stage.group(), &digest) else {
                break;
            };
            upstream.push(shared.stored().clone());
            found.push(shared);
        }
        if found.is_empty() {
            return Ok(());
        }
        let mut transaction = self.begin()?;
        self.write_scene(&mut transaction)?;
        for shared in &found {
            transaction.link(shared)?;
        }
        transaction.remove(format::CHECKPOINT);
        Ok(self.commit_change(transaction, &[])?)
    }
}

/// Whether what a file holds is at fault, and not the way to it.
fn is_of_content(error: &FormatError) -> bool {
    !matches!(error, FormatError::Store(StoreError::Io { .. }))
}

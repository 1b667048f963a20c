//! Where large stages are kept: in the run file, or in a file named by their digest that the run files of a folder share.

use std::sync::Arc;

use contact3d::{AssembledProblem, Problem};
use runfile::{SharedGroup, StoredGroup, Transaction};

use super::{
    Session, StageError, StoreWhen,
    freshness::input_digest,
    session::{LoadState, StageCache},
};
use crate::format::Stage;

/// Assembled data above this many bytes go to a file of their own.
///
/// Copying inside the run file costs every later commit about 2 s per gigabyte on a disk of 0.5
/// GB/s: a second at this size, and a run that is short commits once. Below it one file is worth more.
const LINK_ABOVE: u64 = 512_000_000;

/// The stages that may have another home than the run file, upstream first.
const LARGE: [Stage; 2] = [Stage::Mesh, Stage::Assemble];

/// Where a session keeps what `assemble` makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AssemblyFile {
    /// In the run file up to 512 MB, above that in a file beside it.
    #[default]
    BySize,
    /// In the run file, whatever its size.
    SelfContained,
    /// In a file beside it, whatever its size.
    Linked,
    /// The same, and the mesh in another.
    LinkedWithMesh,
}

impl AssemblyFile {
    /// Whether an assembly of so many bytes is in a file of its own, which then holds its factor too.
    pub(super) fn is_beside(self, bytes: u64) -> bool {
        match self {
            Self::BySize => bytes > LINK_ABOVE,
            Self::SelfContained => false,
            Self::Linked | Self::LinkedWithMesh => true,
        }
    }
}

impl Session {
    /// Chooses where the assembly is kept; `SelfContained` also takes in one that is kept
    /// elsewhere, at the next commit.
    pub fn keep_assembly(&mut self, assembly_file: AssemblyFile) {
        self.store.assembly_file = assembly_file;
    }

    /// Takes stages that are kept elsewhere into the run file now; does nothing if there are none.
    pub fn embed_assembly(&mut self) -> Result<(), StageError> {
        if !self.linked_files().is_empty() {
            let mut transaction = Transaction::begin(&self.store.file)?;
            transaction.embed_linked();
            self.store.end(transaction, &[])?;
        }
        Ok(())
    }

    /// The names of the files beside the run file that hold stages of it.
    pub fn linked_files(&self) -> Vec<String> {
        self.store.file.linked_names()
    }

    /// Makes mesh and assembled problem fresh with the least work: kept, linked from a file that
    /// another run file of the folder shares, or computed and shared. Loads it, or takes it from
    /// `known`, which must belong to a scene with the same [`super::operator_settings`]. A shared
    /// file that is not what was written is made again under the same name.
    pub fn prepare_operator(
        &mut self,
        known: Option<&Arc<AssembledProblem>>,
    ) -> Result<Arc<AssembledProblem>, StageError> {
        self.keep_assembly(AssemblyFile::LinkedWithMesh);
        self.link_shared(known.is_some())?;
        if !self.is_fresh(Stage::Mesh)? {
            self.perform(Stage::Mesh, StoreWhen::Now, &mut |_| {})?;
            self.link_shared(false)?;
        }
        if !self.is_fresh(Stage::Assemble)? {
            self.perform(Stage::Assemble, StoreWhen::Now, &mut |_| {})?;
        } else if let Some(known) = known {
            let scene = self.scene().clone();
            let problem = Problem::of_checked(scene, known.mesh().clone());
            let problem = problem.map_err(|invalid| self.store.input.refuse(invalid))?;
            let known = AssembledProblem {
                problem: problem.clone(),
                system: known.system.clone(),
            };
            self.cache = StageCache {
                problem: Some(Arc::new(problem)),
                assembled: Some((Arc::new(known), LoadState::Any)),
                ..StageCache::default()
            };
        }
        self.assembled()
    }

    fn is_fresh(&self, stage: Stage) -> Result<bool, StageError> {
        let mut states = self.states()?.into_iter();
        Ok(states.any(|state| state.stage == stage && state.is_fresh()))
    }

    /// Links every large stage that is not fresh and that a shared file holds: at once or, where all of them are in memory, with
    /// the next stage that is stored.
    fn link_shared(&mut self, in_memory: bool) -> Result<(), StageError> {
        let mut upstream: Vec<(Stage, StoredGroup)> = Vec::new();
        let mut found = Vec::new();
        for state in self.states()? {
            if !LARGE.contains(&state.stage) {
                break;
            }
            if state.is_fresh() && found.is_empty() {
                upstream.extend(state.stored.map(|stored| (state.stage, stored)));
                continue;
            }
            let settings = self.store.settings(state.stage);
            let digest = input_digest(state.stage, &settings, &upstream);
            let shared = SharedGroup::find(&self.store.file, state.stage.group(), &digest);
            let Some(shared) = shared else {
                break;
            };
            upstream.push((state.stage, shared.stored.clone()));
            found.push(shared);
        }
        if found.is_empty() {
            return Ok(());
        }
        let waits = in_memory && found.len() == LARGE.len();
        self.store.links = found;
        if waits {
            Ok(())
        } else {
            self.store.commit(None)
        }
    }
}

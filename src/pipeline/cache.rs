//! What of a run file is in memory: computed by this process, or read once it was needed.

use std::sync::Arc;

use contact3d::{AssembledProblem, Problem};

use super::{Session, StageError, mesh, results::Results};
use crate::format;

/// The chain from the mesh to the results, as far as it is in memory.
///
/// A new link replaces all that rested on the old one. Links are shared, so holding one keeps no other from being read.
#[derive(Debug, Default)]
pub(super) struct StageCache {
    pub(super) problem: Option<Arc<Problem>>,
    pub(super) assembled: Option<(Arc<AssembledProblem>, LoadState)>,
    pub(super) results: Option<Arc<Results>>,
    /// Whether the problem is in double precision because single precision led to no answer.
    pub(super) is_second_try: bool,
}

/// The loads of an assembled problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LoadState {
    /// Perhaps those of another scene.
    Any,
    /// Those of the scene, at the end of its load history.
    OfScene,
}

impl Session {
    /// The scene on its mesh.
    pub(super) fn problem(&mut self) -> Result<Arc<Problem>, StageError> {
        if let Some(problem) = &self.cache.problem {
            return Ok(problem.clone());
        }
        let problem = Arc::new(mesh::read(&self.store.reader()?, &self.store.input)?);
        self.cache.problem = Some(problem.clone());
        Ok(problem)
    }

    /// The assembled problem, whatever its loads.
    pub(super) fn assembled(&mut self) -> Result<Arc<AssembledProblem>, StageError> {
        if let Some((assembled, _)) = &self.cache.assembled {
            return Ok(assembled.clone());
        }
        let problem = self.problem()?.as_ref().clone();
        let system = format::read_assembly(&self.store.reader()?)?;
        let assembled = Arc::new(AssembledProblem::new(problem, system));
        self.cache.assembled = Some((assembled.clone(), LoadState::Any));
        Ok(assembled)
    }

    /// The assembled problem with the loads of the scene, which `load` applies where it has others.
    pub(super) fn loaded(
        &mut self,
        load: impl FnOnce(&Self, AssembledProblem) -> Result<AssembledProblem, StageError>,
    ) -> Result<Arc<AssembledProblem>, StageError> {
        let mut assembled = self.assembled()?;
        if !matches!(self.cache.assembled.take(), Some((_, LoadState::OfScene))) {
            assembled = Arc::new(load(self, Arc::unwrap_or_clone(assembled))?);
        }
        self.cache.assembled = Some((assembled.clone(), LoadState::OfScene));
        Ok(assembled)
    }

    /// The results of a solved file, evaluated anew where they are read.
    pub fn results(&mut self) -> Result<Arc<Results>, StageError> {
        if let Some(results) = &self.cache.results {
            return Ok(results.clone());
        }
        let problem = self.problem()?;
        let reader = self.store.reader()?;
        let results = Arc::new(Results::read(&reader, &self.store.input, &problem)?);
        self.cache.results = Some(results.clone());
        Ok(results)
    }
}

//! What one process knows of a run file: computed by it, or read back once it is needed.

use std::{path::Path, sync::Arc};

use contact3d::{dual::DualSystem, mesh::Mesh, scene::SceneFile};
use runfile::{Reader, StoreError};

use super::{
    StageError, history, load,
    mesh::{self, Meshed},
    post::{self, Evaluated},
    solve::{self, Equations},
};
use crate::format::{self, LAYOUT};

/// Where what is not in memory comes from.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) run_file: &'a Path,
    pub(super) input: &'a SceneFile,
}

/// The chain from the mesh to the results, as far as it is in memory.
///
/// A new link replaces all that rested on the old one. Links are shared, so holding one keeps no
/// other from being read.
#[derive(Debug, Default)]
pub(super) struct StageCache {
    meshed: Option<Arc<Meshed>>,
    problem: Option<CachedProblem>,
    evaluated: Option<Arc<Evaluated>>,
    /// Whether the problem is in double precision because single precision led to no answer.
    reconsidered: bool,
}

/// An assembled problem.
#[derive(Debug, Clone)]
enum CachedProblem {
    /// Its loads may be those of another scene.
    Operator(Arc<DualSystem>),
    /// Its loads are those of the scene.
    Loaded(Arc<DualSystem>),
}

impl CachedProblem {
    fn system(&self) -> &Arc<DualSystem> {
        match self {
            Self::Operator(system) | Self::Loaded(system) => system,
        }
    }
}

impl Source<'_> {
    pub(super) fn reader(&self) -> Result<Reader, StoreError> {
        Reader::open(self.run_file, LAYOUT)
    }
}

impl StageCache {
    /// Knows a mesh, and nothing that rests on another one.
    pub(super) fn set_mesh(&mut self, meshed: Arc<Meshed>) {
        *self = Self {
            meshed: Some(meshed),
            ..Self::default()
        };
    }

    /// Knows an assembled problem on the mesh, whatever its loads.
    pub(super) fn set_operator(&mut self, system: Arc<DualSystem>) {
        self.problem = Some(CachedProblem::Operator(system));
        self.evaluated = None;
        self.reconsidered = false;
    }

    /// Knows an assembled problem with the loads of the scene.
    pub(super) fn set_problem(&mut self, system: Arc<DualSystem>) {
        self.problem = Some(CachedProblem::Loaded(system));
        self.evaluated = None;
        self.reconsidered = false;
    }

    /// Knows the same problem in double precision, since single precision led to no answer; the results are yet to come.
    pub(super) fn reconsider(&mut self, system: Arc<DualSystem>) {
        self.problem = match self.problem.take() {
            Some(CachedProblem::Operator(_)) => Some(CachedProblem::Operator(system)),
            Some(CachedProblem::Loaded(_)) | None => Some(CachedProblem::Loaded(system)),
        };
        self.evaluated = None;
        self.reconsidered = true;
    }

    /// Whether single precision led to no answer.
    pub(super) fn is_reconsidered(&self) -> bool {
        self.reconsidered
    }

    /// Knows the results.
    pub(super) fn set_evaluated(&mut self, evaluated: Arc<Evaluated>) {
        self.evaluated = Some(evaluated);
    }

    /// The mesh and the laws of its contact face.
    pub(super) fn meshed(&mut self, source: Source<'_>) -> Result<Arc<Meshed>, StageError> {
        if let Some(meshed) = &self.meshed {
            return Ok(meshed.clone());
        }
        let meshed = Arc::new(mesh::read(&source.reader()?, source.input)?);
        self.meshed = Some(meshed.clone());
        Ok(meshed)
    }

    /// The assembled problem, whatever its loads.
    pub(super) fn operator(&mut self, source: Source<'_>) -> Result<Arc<DualSystem>, StageError> {
        if let Some(problem) = &self.problem {
            return Ok(problem.system().clone());
        }
        let system = Arc::new(format::read_assembly(&source.reader()?)?);
        self.problem = Some(CachedProblem::Operator(system.clone()));
        Ok(system)
    }

    /// The assembled problem with the loads of the scene, which `load` applies where it has others.
    pub(super) fn loaded(
        &mut self,
        source: Source<'_>,
        load: impl FnOnce(Arc<DualSystem>) -> Result<DualSystem, StageError>,
    ) -> Result<Arc<DualSystem>, StageError> {
        let system = match self.problem.take() {
            Some(CachedProblem::Loaded(system)) => system,
            Some(CachedProblem::Operator(operator)) => Arc::new(load(operator)?),
            None => Arc::new(load(Arc::new(format::read_assembly(&source.reader()?)?))?),
        };
        self.problem = Some(CachedProblem::Loaded(system.clone()));
        Ok(system)
    }

    /// The assembled problem with the loads of the scene as they are stored.
    pub(super) fn problem(&mut self, source: Source<'_>) -> Result<Arc<DualSystem>, StageError> {
        self.loaded(source, |operator| load::read(&source.reader()?, operator))
    }

    /// The results, evaluated anew where they are read.
    pub(super) fn evaluated(&mut self, source: Source<'_>) -> Result<Arc<Evaluated>, StageError> {
        if let Some(evaluated) = &self.evaluated {
            return Ok(evaluated.clone());
        }
        let meshed = self.meshed(source)?;
        let equations = match &self.problem {
            Some(_) => Equations::CachedProblem(self.problem(source)?),
            None => Equations::read(&source.reader()?)?,
        };
        let reader = source.reader()?;
        let evaluated = Arc::new(if source.input.scene.has_history() {
            history::read(&reader, source.input, &meshed, equations)?
        } else {
            post::run(post::Inputs {
                input: source.input,
                meshed: &meshed,
                answer: solve::read(&reader, equations)?,
            })?
        });
        self.evaluated = Some(evaluated.clone());
        Ok(evaluated)
    }

    /// The mesh and the assembled problem in memory; nothing is read.
    pub(super) fn in_memory(&self) -> Option<(&Mesh, &DualSystem)> {
        let (meshed, problem) = (self.meshed.as_ref()?, self.problem.as_ref()?);
        Some((&meshed.mesh, problem.system()))
    }
}
